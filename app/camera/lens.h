// A lens in the units of photographers: that of a camera whose film is 24 mm high.
#pragma once

#include <cmath>

namespace app {

inline constexpr double kFilmHeightMm = 24;

/// Focal length in mm of a vertical angle of view in radians, in (0, pi).
inline double focalLengthMm(double yfov)
{
    return 0.5 * kFilmHeightMm / std::tan(0.5 * yfov);
}

/// N of f/N for the radius of the opening in metres, which is above 0.
inline double fNumber(double yfov, double apertureRadius)
{
    return 1e-3 * focalLengthMm(yfov) / (2 * apertureRadius);
}

}  // namespace app

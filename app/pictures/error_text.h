// Errors as the window shows them: with as many digits as the standard error leaves, and with the
// reference's own noise where it makes up a part that shows.
#pragma once

#include <string>

#include "app/pictures/picture.h"

namespace app {

/// The value alone with the digits that report::measured leaves it: "0.119" of 0.1192 ± 0.001. All
/// digits of report::shortNumber where the error is unknown.
std::string digitsByError(double value, double error);

/// "0.119 ± 0.001". Where the reference's noise has a share that shows (more than the standard
/// error and half a per cent): "≤ 0.119, reference noise 0.114". `noise` 0: none, or unknown.
std::string rmseText(double rmse, double standardError, double noise);

/// Whether rmseText says "≤".
bool noiseShows(double rmse, double standardError, double noise);

/// The same with the error's name, for a point of the curve of errors: "RMSE ..." against a
/// reference, "noise 0.12" from the samples' own spread, or nothing. With the picture's mean
/// luminance as `mean` the noise is told as a part of it, "noise 12.0 %": a number in radiance says
/// little to who does not know how bright the scene is.
std::string errorText(const ErrorPoint& point, double noise, double mean = 0);

/// Of RGB radiance; pixels that are not finite are left out. 0 for none.
double meanLuminance(const core::Image& picture);

}  // namespace app

// Units of photographers against numbers of textbooks.
#include "app/camera/lens.h"

#include <gtest/gtest.h>

namespace {

constexpr double kDegree = 3.14159265358979 / 180;

TEST(Lens, AnglesAreFocalLengthsOfSmallFilm)
{
    EXPECT_NEAR(app::focalLengthMm(26.99 * kDegree), 50, 0.02);  // the normal lens, upright 27.0
    EXPECT_NEAR(app::focalLengthMm(37.85 * kDegree), 35, 0.02);
    EXPECT_NEAR(app::focalLengthMm(90 * kDegree), 12, 1e-9);
}

TEST(Lens, FNumbersAreFocalLengthsOverOpenings)
{
    const double yfov = 90 * kDegree;  // 12 mm
    EXPECT_NEAR(app::fNumber(yfov, 0.003), 2, 1e-9);
    EXPECT_NEAR(app::fNumber(yfov, 0.00075), 8, 1e-9);
}

}  // namespace

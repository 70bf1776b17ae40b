// Errors as text. See error_text.h.
#include "app/pictures/error_text.h"

#include <algorithm>
#include <cmath>

#include "app/report/text.h"

namespace app {

bool noiseShows(double rmse, double standardError, double noise)
{
    constexpr double kSeen = 0.005;
    if (!(noise > 0) || !(rmse > 0)) return false;
    const double without = std::sqrt(std::max(rmse * rmse - noise * noise, 0.0));
    return rmse - without > std::max(standardError, kSeen * rmse);
}

std::string rmseText(double rmse, double standardError, double noise)
{
    const std::string value = report::measured(rmse, standardError);
    if (!noiseShows(rmse, standardError, noise)) return value;
    // What may be far less is not told to the last digit.
    return "≤ " + report::shortNumber(rmse) + ", reference noise " + report::shortNumber(noise);
}

std::string errorText(const ErrorPoint& point, double noise)
{
    if (point.rmse > 0) return "RMSE " + rmseText(point.rmse, point.rmseSe, noise);
    if (point.estimated > 0) return "noise " + report::shortNumber(point.estimated);
    return {};
}

}  // namespace app

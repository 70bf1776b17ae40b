// Errors as text. See error_text.h.
#include "app/pictures/error_text.h"

#include <algorithm>
#include <cmath>

#include "app/report/text.h"
#include "shared/tonemap.h"

namespace app {

std::string digitsByError(double value, double error)
{
    const std::string text = report::measured(value, error);
    return text.substr(0, text.find(" ±"));
}

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

std::string errorText(const ErrorPoint& point, double noise, double mean)
{
    if (point.rmse > 0) return "RMSE " + rmseText(point.rmse, point.rmseSe, noise);
    if (point.estimated > 0 && mean > 0 && std::isfinite(mean))
        return "noise " + report::percent(point.estimated / mean, 3);
    if (point.estimated > 0) return "noise " + report::shortNumber(point.estimated);
    return {};
}

double meanLuminance(const core::Image& picture)
{
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i + 2 < picture.pixels.size(); i += picture.channels) {
        const float* p = &picture.pixels[i];
        const float luminance = shared::luminance({p[0], p[1], p[2]});
        if (!std::isfinite(luminance)) continue;
        sum += static_cast<double>(luminance);
        ++count;
    }
    return count > 0 ? sum / static_cast<double>(count) : 0;
}

}  // namespace app

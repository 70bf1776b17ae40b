// What a picture made by sample reuse says of itself, on every device.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/methods/renderer.h"
#include "core/methods/reuse_params.h"
#include "core/methods/reuse_settings.h"
#include "shared/reuse_allocation.h"

namespace core {

/// Sums over first hits that scatter.
struct ReuseFigures {
    double scatters = 0;     // how many there are
    double withHistory = 0;  // those that have samples of the view before
    double weights = 0;  // of the sums of v: one each on average, less where directions are lost
    double shares = 0;   // of c
    double paths = 0;    // new ones, of all pixels
    // Of the pass that begins a view, which alone looks at samples across a move:
    double asked = 0;   // first hits that scatter,
    double leaked = 0;  // and the parts of their luminance by old samples that are hidden now
    double lost = 0;    // and by new ones that had been, of those that were asked for visibility
    // How many have a deviation of single paths in a bin: shared::deviationBin.
    std::array<double, shared::kDeviationBins> deviations{};

    void add(const ReuseFigures& other)
    {
        for (double ReuseFigures::*sum :
             {&ReuseFigures::scatters, &ReuseFigures::withHistory, &ReuseFigures::weights,
              &ReuseFigures::shares, &ReuseFigures::paths, &ReuseFigures::asked,
              &ReuseFigures::leaked, &ReuseFigures::lost})
            this->*sum += other.*sum;
        for (size_t i = 0; i < deviations.size(); ++i) deviations[i] += other.deviations[i];
    }

    /// What old samples bring too much and new ones too little, if visibility is never asked for;
    /// `visibility` is the share for which it was.
    double leak(double visibility) const
    {
        return visibility > 0 ? leaked / std::max(asked, 1.0) / visibility : 0;
    }
    double loss(double visibility) const
    {
        return visibility > 0 ? lost / std::max(asked, 1.0) / visibility : 0;
    }

    /// What is told of a view of so many pixels; `mayMove`: the scene has other poses; `plain`:
    /// samples of a pixel that were taken after its history was full.
    std::vector<StatsDetail> details(const ReuseParams& params, bool mayMove, float visibility,
                                     uint32_t records, double pixels, uint32_t plain) const
    {
        std::vector<StatsDetail> details{{"bias", std::string(biasOf(params, mayMove))},
                                         {"history", withHistory / count()},
                                         {"c", shares / count()},
                                         {"n", paths / std::max(pixels, 1.0)},
                                         {"weights", weights / count()},
                                         {"records", double(records)},
                                         {"plain", double(plain)}};
        if (visibility > 0) {
            details.push_back({"visibility", double(visibility)});
            details.push_back({"leak", leak(double(visibility))});
            details.push_back({"loss", loss(double(visibility))});
        }
        return details;
    }

private:
    double count() const { return scatters > 0 ? scatters : 1; }

    static std::string_view biasOf(const ReuseParams& params, bool mayMove)
    {
        const auto strategy = static_cast<uint32_t>(params.reuse);
        if (shared::keepsMeans(strategy)) return "old light as it was";
        if (!shared::keepsSamples(strategy)) return "none";
        if (params.bias == ReuseBias::unbiased) return "none";
        if (params.bias == ReuseBias::bounded) return "visibility of old samples, bounded";
        return mayMove ? "visibility of old samples; light over more than two surfaces, where "
                         "things move"
                       : "visibility of old samples";
    }
};

/// The share of samples whose visibility is asked for again in the next view; `now` and `found` are
/// those of the view before. What is wrong with the samples that are not asked shall be less than
/// the bound. That this depends on samples is a bias of second order: they are those of other
/// views, and of all pixels.
inline float askedVisibility(const ReuseParams& params, float now, const ReuseFigures& found)
{
    constexpr float kFirst = 0.25f, kLeast = 1.0f / 16, kMost = 0.95f;
    const bool looksAtSamples = shared::keepsSamples(static_cast<uint32_t>(params.reuse));
    if (params.bias == ReuseBias::fast || !looksAtSamples) return 0;
    if (params.bias == ReuseBias::unbiased) return 1;
    if (!(now > 0)) return kFirst;
    if (!(found.withHistory > 0)) return now;
    const double wrong = found.leak(double(now)) + found.loss(double(now));
    const double wanted = wrong > double(params.bound) ? 1 - double(params.bound) / wrong : 0;
    return std::clamp(0.5f * (now + static_cast<float>(wanted)), kLeast, kMost);
}

/// What shared::allocatedPart multiplies deviations by, so that the mean over the picture is one as
/// far as the view before tells, in which they were as `found`; `now` is what it was there.
inline float partPerDeviation(const ReuseParams& params, float now, const ReuseFigures& found)
{
    if (!allocatesPaths(params)) return 0;
    double count = 0, largest = 0;
    for (uint32_t bin = 0; bin < shared::kDeviationBins; ++bin) {
        count += found.deviations[bin];
        if (found.deviations[bin] > 0) largest = double(shared::deviationOfBin(bin));
    }
    if (!(largest > 0)) return count > 0 ? 0 : now;
    const double least = 1 / double(params.rays), most = double(shared::kReuseMostPart);
    const auto meanPart = [&](double scale) {
        double sum = 0;
        for (uint32_t bin = 0; bin < shared::kDeviationBins; ++bin)
            sum += found.deviations[bin] *
                   std::min(least + scale * double(shared::deviationOfBin(bin)), most);
        return sum / count;
    };
    // Where next to all is in the first bin, the others cannot have the rest: the bound is theirs.
    double low = 0, high = most / largest;
    for (int i = 0; i < 64 && meanPart(high) < 1; ++i) high *= 2;
    for (int i = 0; i < 48; ++i) {
        const double middle = 0.5 * (low + high);
        (meanPart(middle) < 1 ? low : high) = middle;
    }
    return static_cast<float>(high);
}

}  // namespace core

// See guiding_results.h.
#include "app/bench/guiding_results.h"

#include <algorithm>

#include "core/base/check.h"

namespace app::guiding {

const Row* findRow(const SceneResult& scene, const std::string& variant, const std::string& device,
                   uint32_t spp)
{
    for (const Row& row : scene.rows)
        if (row.variant == variant && row.device == device && row.spp == spp) return &row;
    return nullptr;
}

const Row* plainOf(const SceneResult& scene, const Row& row)
{
    return findRow(scene, "path", row.device, row.spp);
}

const Device& deviceOf(const Results& results, const Row& row)
{
    const auto found = std::ranges::find(results.devices, row.device, &Device::name);
    CHECK(found != results.devices.end());
    return *found;
}

double secondsOf(const Device& device, const Sample& sample)
{
    return device.onHost ? sample.cpuSeconds : sample.renderSeconds;
}

namespace {

/// Over the product of the means of both numbers, and over their products for each seed.
template <class Error, class Cost>
Ratio ratioOf(const Row& plain, const Row& row, Error&& error, Cost&& cost)
{
    std::vector<double> single;
    for (size_t i = 0; i < std::min(plain.samples.size(), row.samples.size()); ++i) {
        const Sample &p = plain.samples[i], &s = row.samples[i];
        single.push_back(error(p) * cost(p) / (error(s) * cost(s)));
    }
    const Spread spread = spreadOf(single);
    return {meanOf(plain, error) * meanOf(plain, cost) / (meanOf(row, error) * meanOf(row, cost)),
            spread.low, spread.high};
}

double errorOf(const Sample& s)
{
    return s.relMse;
}

}  // namespace

Ratio varianceRatio(const Row& plain, const Row& row)
{
    return ratioOf(plain, row, errorOf, [](const Sample&) { return 1.0; });
}

Ratio efficiency(const Device& device, const Row& plain, const Row& row)
{
    return ratioOf(plain, row, errorOf, [&](const Sample& s) { return secondsOf(device, s); });
}

std::string ratioText(const Ratio& ratio)
{
    return spreadText({ratio.value, ratio.low, ratio.high, 1});
}

double biasScore(const Row& row)
{
    return row.difference.value / row.difference.error;
}

double relativeBias(const Row& row)
{
    return row.difference.value / (row.mean - row.difference.value);
}

}  // namespace app::guiding

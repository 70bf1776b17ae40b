// See light_results.h.
#include "app/bench/light_results.h"

#include <algorithm>

#include "core/base/check.h"

namespace app::light {

const Row* findRow(const SceneResult& scene, const std::string& strategy, const std::string& device,
                   uint32_t spp)
{
    for (const Row& row : scene.rows)
        if (row.strategy == strategy && row.device == device && row.spp == spp) return &row;
    return nullptr;
}

const Row* plainOf(const SceneResult& scene, const Row& row)
{
    return findRow(scene, "power", row.device, row.spp);
}

const BenchDevice& deviceOf(const Results& results, const Row& row)
{
    const auto found = std::ranges::find(results.devices, row.device, &BenchDevice::name);
    CHECK(found != results.devices.end());
    return *found;
}

double meanOf(const Row& row, double Sample::*number)
{
    double sum = 0;
    for (const Sample& s : row.samples) sum += s.*number;
    return sum / static_cast<double>(row.samples.size());
}

double meanSeconds(const BenchDevice& device, const Row& row)
{
    return meanOf(row, device.onHost ? &Sample::cpuSeconds : &Sample::renderSeconds);
}

Ratio errorRatio(const Row& plain, const Row& row, double Sample::*error)
{
    return ratioOf(
        plain.samples, row.samples, [error](const Sample& s) { return s.*error; },
        [](const Sample&) { return 1.0; });
}

Ratio timeRatio(const BenchDevice& device, const Row& plain, const Row& row)
{
    return ratioOf(
        row.samples, plain.samples, [](const Sample&) { return 1.0; },
        [&](const Sample& s) { return secondsOf(device, s); });
}

Ratio efficiency(const BenchDevice& device, const Row& plain, const Row& row, double Sample::*error)
{
    return ratioOf(
        plain.samples, row.samples, [error](const Sample& s) { return s.*error; },
        [&](const Sample& s) { return secondsOf(device, s); });
}

double biasScore(const Row& row)
{
    return row.difference.value / row.difference.error;
}

double relativeBias(const Row& row)
{
    return row.difference.value / (row.mean - row.difference.value);
}

}  // namespace app::light

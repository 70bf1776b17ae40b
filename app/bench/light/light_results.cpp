// See light_results.h.
#include "app/bench/light/light_results.h"

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

}  // namespace app::light

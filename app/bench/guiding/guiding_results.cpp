// See guiding_results.h.
#include "app/bench/guiding/guiding_results.h"

#include "app/base/read_value.h"

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

static double errorOf(const Sample& s)
{
    return s.relMse;
}

Ratio varianceRatio(const Row& plain, const Row& row)
{
    return ratioOf(plain.samples, row.samples, errorOf, [](const Sample&) { return 1.0; });
}

Ratio varianceRatio(const Arrival& arrival)
{
    const auto itself = [](double error) { return error; };
    return ratioOf(arrival.plain, arrival.guided, itself, [](double) { return 1.0; });
}

std::string arrivalText(const Arrival& arrival)
{
    return "first sample after " + numberText(arrival.degrees) + " degrees, " + arrival.place() +
           ": " + ratioText(varianceRatio(arrival)) + " times less variance";
}

Ratio efficiency(const BenchDevice& device, const Row& plain, const Row& row)
{
    return ratioOf(plain.samples, row.samples, errorOf,
                   [&](const Sample& s) { return secondsOf(device, s); });
}

}  // namespace app::guiding

// See many_lights_results.h.
#include "app/bench/many_lights/many_lights_results.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace app::many_lights {

const Row* findRow(const SceneResult& scene, const std::string& method, uint32_t clusters,
                   double rate)
{
    for (const Row& row : scene.rows) {
        const bool sameRate = std::isnan(rate) ? std::isnan(row.rowRate) : row.rowRate == rate;
        if (row.method == method && row.clusters == clusters && sameRate && !row.samples.empty())
            return &row;
    }
    return nullptr;
}

const Row* fullInSameSlices(const SceneResult& scene, const Row& row)
{
    for (const Row& other : scene.rows)
        if (other.method.starts_with("full") && other.packets &&
            other.params.sliceSize == row.params.sliceSize && other.clusters == row.clusters &&
            !other.samples.empty())
            return &other;
    return nullptr;
}

Sample middleSample(const Row& row)
{
    CHECK(!row.samples.empty());
    std::vector<Sample> sorted = row.samples;
    std::ranges::sort(sorted, {}, &Sample::seconds);
    Sample middle = sorted[sorted.size() / 2];
    const double stretch = spreadOf(row, secondsOf).median / middle.seconds;
    for (double Sample::*part : {&Sample::seconds, &Sample::cut, &Sample::order, &Sample::tracing,
                                 &Sample::matching, &Sample::shading})
        middle.*part *= stretch;
    return middle;
}

}  // namespace app::many_lights

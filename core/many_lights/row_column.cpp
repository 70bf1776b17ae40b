// See row_column.h.
#include "core/many_lights/row_column.h"

#include <algorithm>
#include <string>

#include "core/base/machine_memory.h"
#include "core/completion/row_weights.h"
#include "core/many_lights/column_clusters.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kRows = 300;
constexpr float kSampled = 2.0f / 3;  // of the clusters, by the sampling phase

/// One receiver of each of kRows parts of the picture; receivers stand in the order of its tiles.
std::vector<uint32_t> sampleRows(uint32_t receivers, Pcg32& random)
{
    std::vector<uint32_t> rows;
    const uint32_t count = std::min(kRows, receivers);
    for (uint32_t k = 0; k < count; ++k) {
        const auto begin = static_cast<uint32_t>(uint64_t(receivers) * k / count),
                   end = static_cast<uint32_t>(uint64_t(receivers) * (k + 1) / count);
        rows.push_back(begin + drawBelow(end - begin, random));
    }
    return rows;
}

}  // namespace

std::unique_ptr<RowColumn> RowColumn::make(const SliceJob& job, std::span<const Receiver> receivers,
                                           uint32_t clusters, const std::stop_token& stop,
                                           uint64_t& rays)
{
    auto made = std::make_unique<RowColumn>();
    std::vector<LightCluster>& out = made->clusters_;
    const std::span<const VirtualLight> lights = job.lights->lights;
    if (lights.size() <= clusters || receivers.empty()) {
        allLights(static_cast<uint32_t>(lights.size()), out);
        return made;
    }
    Pcg32 random(frameSeed(job.receivers));
    const std::vector<uint32_t> rows = sampleRows(static_cast<uint32_t>(receivers.size()), random);
    requireMemory(double(ReducedMatrix::bytes(rows.size(), lights.size())),
                  "row-column of " + std::to_string(lights.size()) + " lights",
                  "use fewer lights (--lights) or another technique");
    const std::optional<ReducedMatrix> matrix =
        traceReducedMatrix(job, receivers, rows, stop, rays);
    if (!matrix) return nullptr;
    const UnseenLights unseen = unseenLights(*matrix, clusters);
    const uint32_t seen = clusters - unseen.clusters;
    ColumnClusters parts = sampleClusters(
        *matrix, static_cast<uint32_t>(kSampled * static_cast<float>(seen)), random, stop);
    if (stop.stop_requested()) return nullptr;
    splitClusters(*matrix, seen, parts, stop);
    if (stop.stop_requested()) return nullptr;
    const std::vector<float> weights = representativeWeights(*matrix, lights);
    drawRepresentatives(parts, weights, random, out);
    drawSystematic(unseen.lights, weights, unseen.clusters, random, out);
    return made;
}

}  // namespace core::many_lights

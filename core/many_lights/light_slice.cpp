// See light_slice.h.
#include "core/many_lights/light_slice.h"

#include <algorithm>
#include <numeric>

#include "core/completion/row_weights.h"

namespace core::many_lights {

namespace {

constexpr float kGlobalShare = 0.3f;   // of the clusters, for the whole picture
constexpr uint32_t kNeighbours = 8;    // a slice itself included
constexpr float kAllRowsShare = 0.1f;  // of the weight of representatives in a slice

/// A random receiver of each slice.
std::vector<uint32_t> seedReceivers(const Slices& slices, Pcg32& random)
{
    std::vector<uint32_t> seeds;
    for (const IndexRange& range : slices.ranges)
        seeds.push_back(slices.order[range.begin + drawBelow(range.size(), random)]);
    return seeds;
}

}  // namespace

std::unique_ptr<LightSlice> LightSlice::make(const SliceJob& job,
                                             std::span<const Receiver> receivers,
                                             const Slices& slices, const SliceSettings& slicing,
                                             uint32_t clusters, const std::stop_token& stop,
                                             uint64_t& rays)
{
    std::unique_ptr<LightSlice> made(new LightSlice);
    const std::span<const VirtualLight> lights = job.lights->lights;
    made->clusters_ = clusters;
    made->lights_ = static_cast<uint32_t>(lights.size());
    made->seed_ = frameSeed(job.receivers);
    if (lights.size() <= clusters || slices.ranges.empty()) return made;
    for (const IndexRange& range : slices.ranges) {
        Place place;
        for (uint32_t i = range.begin; i < range.end; ++i) {
            place.position += receivers[slices.order[i]].position;
            place.normal += slicing.normalScale * receivers[slices.order[i]].normal;
        }
        const float share = 1 / static_cast<float>(range.size());
        made->places_.push_back({place.position * share, place.normal * share});
    }
    Pcg32 random(made->seed_);
    const std::vector<uint32_t> seeds = seedReceivers(slices, random);
    std::optional<ReducedMatrix> matrix = traceReducedMatrix(job, receivers, seeds, stop, rays);
    if (!matrix) return nullptr;
    made->matrix_ = *std::move(matrix);
    const auto global = static_cast<uint32_t>(kGlobalShare * static_cast<float>(clusters));
    made->global_ = sampleClusters(made->matrix_, std::max(global, 1u), random, stop);
    if (stop.stop_requested()) return nullptr;
    made->unseen_ = unseenLights(made->matrix_, clusters);
    made->weights_ = representativeWeights(made->matrix_, lights);
    return made;
}

std::vector<uint32_t> LightSlice::neighbours(uint32_t slice) const
{
    std::vector<std::pair<float, uint32_t>> near;
    for (uint32_t s = 0; s < places_.size(); ++s) {
        const glm::vec3 p = places_[s].position - places_[slice].position,
                        n = places_[s].normal - places_[slice].normal;
        near.emplace_back(glm::dot(p, p) + glm::dot(n, n), s);
    }
    const auto count = std::min<size_t>(kNeighbours, near.size());
    std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(count));
    std::vector<uint32_t> rows;
    for (size_t k = 0; k < count; ++k) rows.push_back(near[k].second);
    return rows;
}

/// How probable representatives are in a slice: by what its neighbourhood sees, and a share by what
/// all rows see.
std::vector<float> LightSlice::localWeights(const ReducedMatrix& local) const
{
    double norms = 0, all = 0;
    for (uint32_t j = 0; j < local.columns(); ++j) {
        norms += double(local.norm(j));
        all += double(weights_[j]);
    }
    const float share = norms > 0 ? kAllRowsShare * static_cast<float>(norms / all) : 1.0f;
    std::vector<float> weights(local.columns());
    for (uint32_t j = 0; j < local.columns(); ++j) weights[j] = local.norm(j) + share * weights_[j];
    return weights;
}

void LightSlice::choose(const SliceRows&, uint32_t slice, CutMemory&,
                        std::vector<LightCluster>& out) const
{
    out.clear();
    if (weights_.empty()) return allLights(lights_, out);  // as many clusters as lights
    static thread_local ReducedMatrix local;
    const std::vector<uint32_t> rows = neighbours(slice);
    local.reset(static_cast<uint32_t>(rows.size()), matrix_.columns());
    for (uint32_t j = 0; j < matrix_.columns(); ++j) {
        const std::span<const float> column = matrix_.column(j);
        for (size_t i = 0; i < rows.size(); ++i) local.column(j)[i] = column[rows[i]];
        local.updateNorm(j);
    }
    ColumnClusters clusters = global_;
    splitClusters(local, clusters_ - unseen_.clusters, clusters);
    Pcg32 random(seed_, slice + 1);
    drawRepresentatives(clusters, localWeights(local), random, out);
    drawSystematic(unseen_.lights, weights_, unseen_.clusters, random, out);
}

}  // namespace core::many_lights

// See light_slice.h.
#include "core/many_lights/light_slice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/machine_memory.h"
#include "core/base/parallel.h"
#include "core/completion/row_weights.h"

namespace core::many_lights {

namespace {

constexpr float kGlobalShare = 0.3f;   // of the clusters, for the whole picture
constexpr uint32_t kNeighbours = 8;    // a slice itself included
constexpr float kAllRowsShare = 0.1f;  // of the weight of representatives in a slice
// .2 to 1 are alike; without that row the error in corners is twice as large, and does not fall
// with the clusters.
constexpr double kBoundShare = 0.5;
constexpr uint32_t kPoll = 4096;  // lights between two looks at a stop

/// A random receiver of each slice.
std::vector<uint32_t> seedReceivers(const Slices& slices, Pcg32& random)
{
    std::vector<uint32_t> seeds;
    for (const IndexRange& range : slices.ranges)
        seeds.push_back(slices.order[range.begin + drawBelow(range.size(), random)]);
    return seeds;
}

}  // namespace

LightSlice::LightSlice(const TechniqueInput& input)
    : tree_(input.tree), gather_(input.job.gather), clusters_(input.clusters),
      lights_(static_cast<uint32_t>(input.job.lights->lights.size())),
      seed_(frameSeed(input.job.receivers))
{}

std::unique_ptr<LightSlice> LightSlice::make(const TechniqueInput& input,
                                             const std::stop_token& stop, uint64_t& rays)
{
    std::unique_ptr<LightSlice> made(new LightSlice(input));
    const Slices& slices = input.slices;
    if (made->lights_ <= input.clusters || slices.ranges.empty()) return made;
    const size_t count = slices.ranges.size();
    requireMemory(made->bytes(count),
                  "lightslice of " + std::to_string(made->lights_) + " lights and " +
                      std::to_string(count) + " slices",
                  "use fewer lights (--lights), larger slices (--slice-size) or another technique");
    for (const IndexRange& range : slices.ranges) {
        Place place;
        for (uint32_t i = range.begin; i < range.end; ++i) {
            const Receiver& receiver = input.receivers[slices.order[i]];
            place.position += receiver.position;
            place.normal += input.slicing.normalScale * receiver.normal;
        }
        const float share = 1 / static_cast<float>(range.size());
        made->places_.push_back({place.position * share, place.normal * share});
    }
    Pcg32 random(made->seed_);
    const std::vector<uint32_t> seeds = seedReceivers(slices, random);
    std::optional<ReducedMatrix> matrix =
        traceReducedMatrix(input.job, input.receivers, seeds, stop, rays);
    if (!matrix) return nullptr;
    made->matrix_ = *std::move(matrix);
    const auto global = static_cast<uint32_t>(kGlobalShare * static_cast<float>(input.clusters));
    made->global_ = sampleClusters(made->matrix_, std::max(global, 1u), random, stop);
    if (stop.stop_requested()) return nullptr;
    made->unseen_ = unseenLights(made->matrix_, input.clusters);
    made->weights_ = representativeWeights(made->matrix_, input.job.lights->lights);
    return made;
}

/// Of the reduced matrix and, for each thread, of the neighbourhood of the slice at work.
double LightSlice::bytes(size_t slices) const
{
    return double(ReducedMatrix::bytes(slices, lights_)) +
           double(threadCount()) * double(ReducedMatrix::bytes(kNeighbours + 1, lights_));
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

/// The columns that tell lights apart in a slice: what its neighbourhood sees of them, and below it
/// a row of what they bring to the slice at most, kBoundShare as bright as a row of the others.
/// False when `stop` came first.
bool LightSlice::gatherColumns(const SliceRows& sliceRows, uint32_t slice, ReducedMatrix& local,
                               const std::stop_token& stop) const
{
    const std::vector<uint32_t> rows = neighbours(slice);
    const auto count = static_cast<uint32_t>(rows.size());
    static thread_local std::vector<float> bounds;
    bounds.resize(lights_);
    lightBounds(tree_, sliceRows.query(gather_), bounds);
    if (stop.stop_requested()) return false;
    local.reset(count + 1, lights_);
    double seen = 0, most = 0;
    for (uint32_t j = 0; j < lights_; ++j) {
        if (j % kPoll == 0 && stop.stop_requested()) return false;
        const std::span<const float> column = matrix_.column(j);
        for (uint32_t i = 0; i < count; ++i) {
            local.column(j)[i] = column[rows[i]];
            seen += double(column[rows[i]]);
        }
        // Lights around the slice that no clamp holds have no bound.
        if (!std::isfinite(bounds[j])) bounds[j] = 0;
        most += double(bounds[j]);
    }
    const double scale = most > 0 ? kBoundShare * seen / (count * most) : 0;
    for (uint32_t j = 0; j < lights_; ++j) {
        if (j % kPoll == 0 && stop.stop_requested()) return false;
        local.column(j)[count] = static_cast<float>(scale * double(bounds[j]));
        local.updateNorm(j);
    }
    return true;
}

void LightSlice::choose(const SliceRows& rows, uint32_t slice, CutMemory&,
                        std::vector<LightCluster>& out, const std::stop_token& stop) const
{
    out.clear();
    if (weights_.empty()) return allLights(lights_, out);  // as many clusters as lights
    static thread_local ReducedMatrix local;
    if (!gatherColumns(rows, slice, local, stop)) return;
    ColumnClusters clusters = global_;
    splitClusters(local, clusters_ - unseen_.clusters, clusters, stop);
    if (stop.stop_requested()) return;
    Pcg32 random(seed_, slice + 1);
    drawRepresentatives(clusters, localWeights(local), random, out);
    drawSystematic(unseen_.lights, weights_, unseen_.clusters, random, out);
}

}  // namespace core::many_lights

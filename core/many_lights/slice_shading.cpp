// See slice_shading.h.
#include "core/many_lights/slice_shading.h"

#include <algorithm>
#include <utility>

#include "core/base/time.h"
#include "core/trace/scene_view.h"

namespace core::many_lights {

namespace {

using glm::vec3;

/// Seconds since the last call.
double lap(Clock::time_point& since)
{
    const double seconds = secondsSince(since);
    since = Clock::now();
    return seconds;
}

/// Writes a bit for each weight above 0.
void setBits(std::span<const float> weights, std::span<uint64_t> words)
{
    for (size_t w = 0; w < words.size(); ++w) {
        const size_t count = std::min<size_t>(64, weights.size() - 64 * w);
        uint64_t word = 0;
        for (size_t i = 0; i < count; ++i) word |= uint64_t(weights[64 * w + i] > 0 ? 1 : 0) << i;
        words[w] = word;
    }
}

/// Clears the weights of rows that the light does not reach.
void maskWeights(std::span<const uint64_t> words, std::span<float> weights)
{
    for (size_t w = 0; w < words.size(); ++w) {
        const size_t count = std::min<size_t>(64, weights.size() - 64 * w);
        const uint64_t word = words[w];
        float* out = weights.data() + 64 * w;
        for (size_t i = 0; i < count; ++i) out[i] = (word >> i & 1) != 0 ? out[i] : 0.0f;
    }
}

/// Which octant, seen from the light, the slice lies in: columns of one octant share what blocks
/// them.
uint32_t octantOf(const VirtualLight& light, const vec3& slice)
{
    const vec3 d = light.kind == LightKind::directional ? light.normal : slice - light.position;
    return (d.x < 0 ? 1u : 0u) | (d.y < 0 ? 2u : 0u) | (d.z < 0 ? 4u : 0u);
}

}  // namespace

SliceStats& SliceStats::operator+=(const SliceStats& other)
{
    completion += other.completion;
    slices += other.slices;
    rows += other.rows;
    clusters += other.clusters;
    otherRays += other.otherRays;
    cutSeconds += other.cutSeconds;
    orderSeconds += other.orderSeconds;
    shadingSeconds += other.shadingSeconds;
    lostSeconds += other.lostSeconds;
    return *this;
}

bool SliceWorker::run(const SliceJob& job, std::span<const Receiver> receivers,
                      std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop)
{
    stats_ = {};
    stats_.slices = 1;
    stats_.rows = chosen.size();
    radiance_.assign(chosen.size(), vec3(0));
    Clock::time_point since = Clock::now();
    rows_.reset(sceneView(job.receivers.accel->world()), receivers, chosen);
    stats_.shadingSeconds += lap(since);
    makeColumns(job);
    stats_.cutSeconds = lap(since);
    if (!weighColumns(job, stop)) return false;
    orderColumns();
    stats_.orderSeconds = lap(since);

    SliceOracle oracle(*job.receivers.accel, rows_, ordered_, orderedMatters_, stop);
    const uint64_t seed =
        uint64_t(job.receivers.settings.seed) << 32 ^ uint64_t(job.receivers.frame) << 20 ^ slice;
    complete(oracle, rows_.count(), ranges_, job.completion, seed, completed_);
    if (stop.stop_requested()) return false;
    stats_.completion = completed_.stats;
    since = Clock::now();
    if (!sum(job, stop)) return false;
    stats_.shadingSeconds += lap(since);
    if (job.compensates && losesLight(job.receivers.accel->world(), job.gather.clampDistance))
        stats_.otherRays +=
            addLostLight(job.receivers, job.gather.clampDistance, receivers, chosen, radiance_);
    for (size_t i = 0; i < chosen.size(); ++i) radiance_[i] *= receivers[chosen[i]].throughput;
    stats_.lostSeconds = lap(since);
    return !stop.stop_requested();
}

void SliceWorker::makeColumns(const SliceJob& job)
{
    const std::vector<VirtualLight>& lights = job.lights->lights;
    cutLightTree(*job.tree, lights, rows_.query(job.gather), job.clusters, cutMemory_, clusters_);
    columns_.clear();
    for (const LightCluster& cluster : clusters_)
        columns_.push_back(
            {&lights[cluster.light], cluster.scale,
             shared::hashUint(cluster.light ^ shared::hashUint(job.receivers.frame))});
    stats_.clusters = columns_.size();
}

/// Which rows each column can light at all, and how brightly.
bool SliceWorker::weighColumns(const SliceJob& job, const std::stop_token& stop)
{
    const auto count = static_cast<uint32_t>(columns_.size());
    weights_.resize(rows_.count());
    brightness_.resize(count);
    octants_.resize(count);
    matters_.reset(rows_.count(), count);
    const vec3 middle = rows_.query(job.gather).position;
    for (uint32_t j = 0; j < count; ++j) {
        if (j % 256 == 0 && stop.stop_requested()) return false;
        rows_.weigh(columns_[j], job.gather, weights_);
        setBits(weights_, matters_.column(j));
        brightness_[j] = SliceRows::brightness(columns_[j], weights_);
        octants_[j] = octantOf(*columns_[j].light, middle);
    }
    return true;
}

/// Octant by octant, in each the brightest first; ties as the cut has them.
void SliceWorker::orderColumns()
{
    const auto count = static_cast<uint32_t>(columns_.size());
    order_.resize(count);
    for (uint32_t j = 0; j < count; ++j) order_[j] = j;
    std::sort(order_.begin(), order_.end(), [this](uint32_t a, uint32_t b) {
        if (octants_[a] != octants_[b]) return octants_[a] < octants_[b];
        return brightness_[a] != brightness_[b] ? brightness_[a] > brightness_[b] : a < b;
    });
    orderedMatters_.reset(rows_.count(), count);
    ordered_.clear();
    ranges_.clear();
    for (uint32_t j = 0; j < count; ++j) {
        const uint32_t from = order_[j];
        ordered_.push_back(columns_[from]);
        std::ranges::copy(std::as_const(matters_).column(from), orderedMatters_.column(j).begin());
        if (j == 0 || octants_[order_[j - 1]] != octants_[from]) ranges_.push_back({j, j});
        ranges_.back().end = j + 1;
    }
}

bool SliceWorker::sum(const SliceJob& job, const std::stop_token& stop)
{
    std::ranges::stable_sort(completed_.residual, {}, &ResidualEntry::column);
    auto residual = completed_.residual.begin();
    for (uint32_t j = 0; j < ordered_.size(); ++j) {
        if (j % 256 == 0 && stop.stop_requested()) return false;
        const std::span<const uint64_t> visible = std::as_const(completed_.visible).column(j);
        rows_.weigh(ordered_[j], job.gather, weights_);
        corrections_.clear();
        for (; residual != completed_.residual.end() && residual->column == j; ++residual)
            corrections_.emplace_back(residual->row, residual->weight * weights_[residual->row]);
        if (completed_.coefficients.empty())
            maskWeights(visible, weights_);
        else
            for (uint32_t i = 0; i < rows_.count(); ++i)
                weights_[i] *= completed_.coefficients[size_t(j) * rows_.count() + i];
        for (const auto& [row, correction] : corrections_) weights_[row] += correction;
        rows_.add(ordered_[j], *job.lights, weights_);
    }
    for (uint32_t row = 0; row < rows_.count(); ++row) radiance_[row] = rows_.radiance(row);
    return true;
}

}  // namespace core::many_lights

// See slice_visibility.h.
#include "core/many_lights/slice_visibility.h"

#include <algorithm>
#include <utility>

#include "core/base/time.h"
#include "core/many_lights/column_source.h"
#include "core/many_lights/light_radii.h"
#include "core/trace/scene_view.h"

namespace core::many_lights {

namespace {

using glm::vec3;

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

bool SliceVisibility::run(const SliceJob& job, std::span<const Receiver> receivers,
                          std::span<const uint32_t> chosen, uint32_t slice,
                          const std::stop_token& stop, SliceStats& stats)
{
    if (!prepare(job, receivers, chosen, slice, stop, stats)) return false;
    SliceOracle oracle(*job.receivers.accel, rows_, ordered_, orderedMatters_, stop, job.packets,
                       orderedBrightness_);
    complete(oracle, rows_.count(), ranges_, job.completion, frameSeed(job.receivers) ^ slice,
             completed_, stop);
    stats.completion += completed_.stats;
    return !stop.stop_requested();
}

bool SliceVisibility::prepare(const SliceJob& job, std::span<const Receiver> receivers,
                              std::span<const uint32_t> chosen, uint32_t slice,
                              const std::stop_token& stop, SliceStats& stats)
{
    Clock::time_point since = Clock::now();
    rows_.reset(sceneView(job.receivers.accel->world()), receivers, chosen);
    chooseSome(job, receivers, chosen);
    stats.shadingSeconds += secondsSince(since);
    since = Clock::now();
    if (!makeColumns(job, slice, stop)) return false;
    ++stats.slices;
    stats.rows += chosen.size();
    stats.clusters += columns_.size();
    stats.cutSeconds += secondsSince(since);
    since = Clock::now();
    if (!weighColumns(job, stop)) return false;
    orderColumns();
    stats.orderSeconds += secondsSince(since);
    return true;
}

/// How bright columns are, which decides on their order, few rows tell: evenly spaced ones.
void SliceVisibility::chooseSome(const SliceJob& job, std::span<const Receiver> receivers,
                                 std::span<const uint32_t> chosen)
{
    constexpr size_t kStep = 16, kFewest = 64;
    const size_t step = std::clamp<size_t>(chosen.size() / kFewest, 1, kStep);
    someChosen_.clear();
    for (size_t i = step / 2; i < chosen.size(); i += step) someChosen_.push_back(chosen[i]);
    some_.reset(sceneView(job.receivers.accel->world()), receivers, someChosen_);
}

bool SliceVisibility::makeColumns(const SliceJob& job, uint32_t slice, const std::stop_token& stop)
{
    job.columns->choose(rows_, slice, cutMemory_, clusters_, stop);
    if (stop.stop_requested()) return false;
    columns_.clear();
    for (const LightCluster& cluster : clusters_) {
        columns_.push_back(columnOf(job.lights->lights[cluster.light], cluster.scale, cluster.light,
                                    job.receivers.frame));
        fetchLight(columns_.back());
    }
    if (job.shape != LightShape::point) setRadii(job.aloneRadius);
    return true;
}

/// Radii follow the lights of the slice: these are sparser than all lights, and radii of the latter
/// would leave the bright spots that extent is to take away.
void SliceVisibility::setRadii(float alone)
{
    std::vector<glm::vec3> positions;
    std::vector<Column*> placed;
    for (Column& column : columns_)
        if (column.light->kind != LightKind::directional) {
            positions.push_back(column.light->position);
            placed.push_back(&column);
        }
    std::vector<float> radii(positions.size());
    lightRadii(positions, alone, radii);
    for (size_t i = 0; i < placed.size(); ++i) placed[i]->radius = radii[i];
}

/// Which rows each column can light at all, and how brightly.
bool SliceVisibility::weighColumns(const SliceJob& job, const std::stop_token& stop)
{
    const auto count = static_cast<uint32_t>(columns_.size());
    weights_.resize(rows_.count());
    brightness_.resize(count);
    octants_.resize(count);
    matters_.reset(rows_.count(), count);
    const vec3 middle = rows_.middle();
    for (uint32_t j = 0; j < count; ++j) {
        if (j % 256 == 0 && stop.stop_requested()) return false;
        rows_.findReached(columns_[j], job.gather, weights_, matters_.column(j));
        some_.weigh(columns_[j], job.gather, std::span(weights_).first(some_.count()));
        brightness_[j] =
            SliceRows::brightness(columns_[j], std::span(weights_).first(some_.count()));
        octants_[j] = octantOf(*columns_[j].light, middle);
    }
    return true;
}

/// Octant by octant, in each the brightest first; ties as the cut has them.
void SliceVisibility::orderColumns()
{
    const auto count = static_cast<uint32_t>(columns_.size());
    order_.resize(count);
    for (uint32_t j = 0; j < count; ++j) order_[j] = j;
    std::sort(order_.begin(), order_.end(), [this](uint32_t a, uint32_t b) {
        if (octants_[a] != octants_[b]) return octants_[a] < octants_[b];
        return brightness_[a] != brightness_[b] ? brightness_[a] > brightness_[b] : a < b;
    });
    orderedMatters_.reset(rows_.count(), count);
    double total = 0;
    for (const float b : brightness_) total += double(b);
    const double scale = total > 0 ? count / total : 0;
    orderedBrightness_.clear();
    ordered_.clear();
    ranges_.clear();
    for (uint32_t j = 0; j < count; ++j) {
        const uint32_t from = order_[j];
        ordered_.push_back(columns_[from]);
        orderedBrightness_.push_back(static_cast<float>(double(brightness_[from]) * scale));
        std::ranges::copy(std::as_const(matters_).column(from), orderedMatters_.column(j).begin());
        if (j == 0 || octants_[order_[j - 1]] != octants_[from]) ranges_.push_back({j, j});
        ranges_.back().end = j + 1;
    }
}

}  // namespace core::many_lights

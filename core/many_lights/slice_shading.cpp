// See slice_shading.h.
#include "core/many_lights/slice_shading.h"

#include <algorithm>

#include "core/base/time.h"
#include "core/many_lights/lost_light.h"
#include "core/many_lights/piece_sum.h"
#include "core/many_lights/slice_lighter.h"
#include "core/trace/scene_view.h"

namespace core::many_lights {

bool SliceWorker::run(const SliceJob& job, std::span<const Receiver> receivers,
                      std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop)
{
    stats_ = {};
    radiance_.resize(chosen.size());
    if (job.lighter != nullptr) {
        if (!job.lighter->light(job, receivers, chosen, slice, stop, radiance_, stats_))
            return false;
    } else {
        if (!visibility_.run(job, receivers, chosen, slice, stop, stats_)) return false;
        const Clock::time_point since = Clock::now();
        const bool summed = job.shape == LightShape::point
                                ? sum(job, stop)
                                : sumExtended(job, receivers, chosen, stop);
        if (!summed) return false;
        stats_.shadingSeconds += secondsSince(since);
    }
    addLost(job, receivers, chosen);
    return !stop.stop_requested();
}

bool SliceWorker::run(const SliceJob& job, std::span<const Receiver> receivers,
                      std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
                      SliceQueue& queue)
{
    stats_ = {};
    if (!visibility_.run(job, receivers, chosen, slice, stop, stats_)) return false;
    radiance_.assign(chosen.size(), glm::vec3(0));
    addLost(job, receivers, chosen);
    const auto rows = static_cast<uint32_t>(chosen.size());
    const auto columns = static_cast<uint32_t>(visibility_.columns().size());
    const uint32_t each = pieceColumns(rows, job.shape);
    const auto pending = std::make_shared<PendingSlice>();
    // Without any light, too, a slice is a piece, so that it comes out of the queue.
    pending->slice = slice;
    pending->pieces = std::max(1u, (columns + each - 1) / each);
    pending->radiance = radiance_;
    pending->stats = stats_;
    for (uint32_t piece = 0, count = pending->pieces; piece < count; ++piece) {
        const Clock::time_point since = Clock::now();
        SlicePiece packed = packPiece(job, visibility_, receivers, chosen,
                                      {piece * each, std::min(columns, (piece + 1) * each)});
        packed.slice = pending;
        if (piece == 0) pending->stats.shadingSeconds += secondsSince(since);
        if (!queue.push(std::move(packed))) return false;
    }
    return !stop.stop_requested();
}

/// Light that the columns do not bring.
void SliceWorker::addLost(const SliceJob& job, std::span<const Receiver> receivers,
                          std::span<const uint32_t> chosen)
{
    const Clock::time_point since = Clock::now();
    if (job.compensates && losesLight(job.receivers.accel->world(), job.gather.clampDistance))
        stats_.otherRays +=
            addLostLight(job.receivers, job.gather.clampDistance, receivers, chosen, radiance_);
    stats_.lostSeconds = secondsSince(since);
}

bool SliceWorker::sumExtended(const SliceJob& job, std::span<const Receiver> receivers,
                              std::span<const uint32_t> chosen, const std::stop_token& stop)
{
    std::ranges::fill(radiance_, glm::vec3(0));
    const auto columns = static_cast<uint32_t>(visibility_.columns().size());
    const uint32_t each = pieceColumns(static_cast<uint32_t>(chosen.size()), job.shape);
    const shared::SceneView scene = sceneView(job.receivers.accel->world());
    for (uint32_t first = 0; first < columns; first += each) {
        const SlicePiece piece = packPiece(job, visibility_, receivers, chosen,
                                           {first, std::min(columns, first + each)});
        if (!sumPiece(scene, piece, sumRules(job), radiance_, stop)) return false;
    }
    return true;
}

bool SliceWorker::sum(const SliceJob& job, const std::stop_token& stop)
{
    SliceRows& rows = visibility_.rows();
    const CompletedSlice& completed = visibility_.completed();
    const std::span<const Column> columns = visibility_.columns();
    residual_ = completed.residual;
    std::ranges::stable_sort(residual_, {}, &ResidualEntry::column);
    auto residual = residual_.begin();
    weights_.resize(rows.count());
    const bool asSeen = completed.coefficients.empty() && residual_.empty();
    for (uint32_t j = 0; j < columns.size(); ++j) {
        if (j % 256 == 0 && stop.stop_requested()) return false;
        if (j + 2 < columns.size()) fetchLight(columns[j + 2]);
        if (j + 1 < columns.size()) fetchDetail(columns[j + 1], *job.lights);
        const std::span<const uint64_t> visible = completed.visible.column(j);
        if (asSeen) {
            addVisible(job, columns[j], visible);
            continue;
        }
        rows.weigh(columns[j], job.gather, weights_);
        corrections_.clear();
        for (; residual != residual_.end() && residual->column == j; ++residual)
            corrections_.emplace_back(residual->row, residual->weight * weights_[residual->row]);
        if (completed.coefficients.empty())
            maskValues(visible, weights_);
        else
            for (uint32_t i = 0; i < rows.count(); ++i)
                weights_[i] *= completed.coefficients[size_t(j) * rows.count() + i];
        for (const auto& [row, correction] : corrections_) weights_[row] += correction;
        rows.add(columns[j], *job.lights, weights_);
    }
    for (uint32_t row = 0; row < rows.count(); ++row) radiance_[row] = rows.radiance(row);
    return true;
}

/// A column's light to the rows that see it. Words of 64 rows of which none does are left out.
void SliceWorker::addVisible(const SliceJob& job, const Column& column,
                             std::span<const uint64_t> visible)
{
    SliceRows& rows = visibility_.rows();
    for (size_t begin = 0, end; begin < visible.size(); begin = end + 1) {
        end = begin;
        while (end < visible.size() && visible[end] != 0) ++end;
        if (end == begin) continue;
        const IndexRange lit{static_cast<uint32_t>(64 * begin),
                             std::min(static_cast<uint32_t>(64 * end), rows.count())};
        rows.weigh(column, job.gather, lit, weights_);
        maskValues(visible.subspan(begin, end - begin),
                   std::span(weights_).subspan(lit.begin, lit.size()));
        rows.add(column, *job.lights, lit, weights_);
    }
}

}  // namespace core::many_lights

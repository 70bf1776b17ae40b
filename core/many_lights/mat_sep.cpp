// See mat_sep.h.
#include "core/many_lights/mat_sep.h"

#include <algorithm>
#include <cmath>

#include "core/base/time.h"
#include "core/many_lights/slice_visibility.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr float kFarOff = 1000;  // in radii of the scene: where lights without a place stand

std::vector<vec3> placesOf(std::span<const Column> columns, float radius)
{
    std::vector<vec3> places;
    places.reserve(columns.size());
    for (const Column& column : columns)
        places.push_back(column.light->kind == LightKind::directional
                             ? -kFarOff * radius * column.light->normal
                             : column.light->position);
    return places;
}

/// What each column brings each row: three columns, red, green and blue, of each that brings
/// anything.
bool shade(const SliceJob& job, SliceVisibility& slice, const BitMatrix& visible,
           const std::stop_token& stop, Matrix& shaded)
{
    SliceRows& rows = slice.rows();
    std::vector<uint32_t> lit;
    for (uint32_t j = 0; j < visible.columns(); ++j)
        if (countBits(visible.column(j)) > 0) lit.push_back(j);
    shaded = Matrix(rows.count(), 3 * lit.size());
    std::vector<float> weights(rows.count());
    for (size_t k = 0; k < lit.size(); ++k) {
        if (k % 64 == 0 && stop.stop_requested()) return false;
        const Column& column = slice.columns()[lit[k]];
        rows.weigh(column, job.gather, weights);
        maskValues(visible.column(lit[k]), weights);
        rows.clear({0, rows.count()});
        rows.add(column, *job.lights, weights);
        for (uint32_t row = 0; row < rows.count(); ++row) {
            const vec3 sent = rows.radiance(row);
            for (int c = 0; c < 3; ++c) shaded(row, 3 * k + size_t(c)) = double(sent[c]);
        }
    }
    return true;
}

void sumRows(const Matrix& shaded, std::span<vec3> radiance)
{
    std::array<std::vector<double>, 3> sums;
    for (std::vector<double>& sum : sums) sum.resize(shaded.rows());
    for (size_t j = 0; j < shaded.columns(); ++j)
        for (size_t i = 0; i < shaded.rows(); ++i) sums[j % 3][i] += std::max(shaded(i, j), 0.0);
    for (size_t i = 0; i < shaded.rows(); ++i)
        radiance[i] = {float(sums[0][i]), float(sums[1][i]), float(sums[2][i])};
}

}  // namespace

bool MatSep::light(const SliceJob& job, std::span<const Receiver> receivers,
                   std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
                   std::span<vec3> radiance, SliceStats& stats) const
{
    static thread_local SliceVisibility prepared;
    SliceJob own = job;
    own.columns = columns_.get();
    if (!prepared.prepare(own, receivers, chosen, slice, stop, stats)) return false;
    SliceRows& rows = prepared.rows();
    std::vector<vec3> points;
    for (uint32_t row = 0; row < rows.count(); ++row)
        points.push_back(rows.queryAt(row, job.gather).position);
    const core::Accel& accel = *job.receivers.accel;
    const std::vector<vec3> lights = placesOf(prepared.columns(), accel.world().radius);
    SliceOracle oracle(accel, rows, prepared.columns(), prepared.matters(), stop, job.packets);
    CompletedSlice completed;
    const uint64_t seed = octantSeed(frameSeed(job.receivers) ^ slice, 0);
    if (!predictVisibility(oracle, {points, lights}, settings_.prediction, seed, stop, completed))
        return false;

    Clock::time_point since = Clock::now();
    Matrix shaded;
    if (!shade(job, prepared, completed.visible, stop, shaded)) return false;
    stats.shadingSeconds += secondsSince(since);
    since = Clock::now();
    if (settings_.separates && shaded.columns() > 0) {
        Pcg32 random(seed, 1);
        shaded = separateByFactors(shaded, settings_.separation, random, stop).low.matrix;
    }
    sumRows(shaded, radiance);
    completed.stats.seconds += secondsSince(since);
    stats.completion += completed.stats;
    return !stop.stop_requested();
}

}  // namespace core::many_lights

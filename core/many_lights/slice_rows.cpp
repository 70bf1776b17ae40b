// See slice_rows.h. The loops over rows are written so that compilers make vectors of them: no
// branches, no calls.
#include "core/many_lights/slice_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/completion/bits.h"
#include "shared/path.h"

namespace core::many_lights {

using glm::vec3;
using shared::kTooNear2;

namespace {

/// Cosine to a surface of directions that stand for those below its horizon.
constexpr float kAboveHorizon = 0.05f;

/// Rows looked at together: nothing is done for those that a light does not reach.
constexpr uint32_t kBlock = GlossRows::kMost;

// Loops of their own: a promise made within another loop is not kept.
void addScaled(float* __restrict x, float* __restrict y, float* __restrict z, vec3 scale,
               const float* a, IndexRange rows)
{
    for (uint32_t i = rows.begin; i < rows.end; ++i) {
        x[i] += scale.x * a[i];
        y[i] += scale.y * a[i];
        z[i] += scale.z * a[i];
    }
}

void addProducts(float* __restrict sum, const float* a, const float* b, IndexRange rows)
{
    for (uint32_t i = rows.begin; i < rows.end; ++i) sum[i] += a[i] * b[i];
}

void scaleFrom(float* __restrict out, float to, const float* at, float near, const float* scale,
               IndexRange rows)
{
    for (uint32_t i = rows.begin; i < rows.end; ++i) out[i] = (to - near * at[i]) * scale[i];
}

/// Cosines and distances of a contribution; `cosine(i, x, y, z)` is that at row i. Without the
/// promise that nothing else lies at `out` the loops would not become vectors.
template <class Cosine>
void weighRows(const Column& column, float clampDistance, const RowTriple& position,
               const Cosine& cosine, IndexRange rows, float* __restrict out)
{
    const VirtualLight& light = *column.light;
    const vec3 p = light.position, n = light.normal;
    if (light.kind == LightKind::directional) {
        for (uint32_t i = rows.begin; i < rows.end; ++i) out[i] = cosine(i, -n.x, -n.y, -n.z);
        return;
    }
    const float* px = position[0].data();
    const float* py = position[1].data();
    const float* pz = position[2].data();
    if (light.kind == LightKind::point) {
        for (uint32_t i = rows.begin; i < rows.end; ++i) {
            const float x = p.x - px[i], y = p.y - py[i], z = p.z - pz[i];
            const float d2 = std::max(x * x + y * y + z * z, kTooNear2);
            out[i] = cosine(i, x, y, z) / (d2 * std::sqrt(d2));
        }
        return;
    }
    const float b = std::max(clampDistance, column.radius), b2 = b * b;
    const float behind = light.bothSides != 0 ? 1.0f : 0.0f;
    for (uint32_t i = rows.begin; i < rows.end; ++i) {
        const float x = p.x - px[i], y = p.y - py[i], z = p.z - pz[i];
        const float d2 = x * x + y * y + z * z;
        const float facing = -(x * n.x + y * n.y + z * n.z);
        const float leaves = std::max(facing, -behind * facing);
        const float safe = std::max(d2, kTooNear2);
        const float w = cosine(i, x, y, z) * leaves / (safe * std::max(safe, b2));
        out[i] = w * static_cast<float>(d2 > kTooNear2);
    }
}

}  // namespace

void SliceRows::reset(const shared::SceneView& scene, std::span<const Receiver> receivers,
                      std::span<const uint32_t> chosen)
{
    count_ = static_cast<uint32_t>(chosen.size());
    for (RowTriple* triple :
         {&position_, &normal_, &side_, &albedo_, &irradiance_, &sum_, &wi_, &leaving_})
        for (std::vector<float>& v : *triple) v.assign(count_, 0.0f);
    for (std::vector<float>& v : origin_) v.resize(2 * size_t(count_));
    events_.resize(count_);
    seeds_.resize(count_);
    transmits_.assign(count_, 0);
    scale_.resize(count_);
    surfaces_.clear();
    gloss_.clear();
    otherSurfaces_ = 0;
    mean_ = meanNormal_ = vec3(0);
    anyTransmits_ = anySideDiffers_ = anyAbsorbs_ = false;
    mostEvents_ = 0;
    for (uint32_t row = 0; row < count_; ++row) setRow(row, scene, receivers[chosen[row]]);
    bounds_.reset(position_, normal_, side_, count_);
}

void SliceRows::setRow(uint32_t row, const shared::SceneView& scene, const Receiver& receiver)
{
    const shared::Hit hit{0, receiver.barycentrics, receiver.slot};
    shared::Vertex v;
    v.surface = shared::makeSurfacePoint(scene, hit, receiver.direction);
    const shared::Shading shading = shared::evaluateMaterial(scene, v.surface, receiver.direction);
    v.bsdf = shared::makeBsdf(shading.inputs);
    const vec3 normal = v.surface.frame[2];
    const vec3 front = shared::originOnSide(v.surface, 1),
               back = shared::originOnSide(v.surface, -1);
    vec3 albedo(0);
    if (shared::isLambert(v.bsdf)) {
        albedo = v.bsdf.diffuse * shared::kInvPi;
    } else {
        v.wo = shared::toLocal(v.surface.frame, -receiver.direction);
        v.lobes = shared::lobesAt(v.bsdf, v.wo);
        const bool gloss = isGloss(v.bsdf, v.wo);
        surfaces_.push_back({row, v.surface.frame, v.wo, v.bsdf, v.lobes, gloss});
        if (gloss) gloss_.push(row, v.surface.frame, glossOf(v.bsdf, v.lobes, v.wo));
        otherSurfaces_ += gloss ? 0 : 1;
        transmits_[row] = (v.bsdf.parts & shared::kBsdfTransmission) != 0 ? 1 : 0;
        anyTransmits_ = anyTransmits_ || transmits_[row] != 0;
    }
    for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<size_t>(c);
        position_[i][row] = v.surface.position[c];
        normal_[i][row] = normal[c];
        side_[i][row] = receiver.normal[c];
        albedo_[i][row] = albedo[c];
        origin_[i][row] = front[c];
        origin_[i][size_t(count_) + row] = back[c];
    }
    setMedia(row, scene, receiver.medium, shared::mediumBehind(receiver.medium, v.surface, v.bsdf));
    events_[row] = static_cast<int>(receiver.events);
    mostEvents_ = std::max(mostEvents_, events_[row]);
    anySideDiffers_ = anySideDiffers_ || normal != receiver.normal;
    seeds_[row] = shared::hashUint(receiver.place);
    mean_ += v.surface.position;
    meanNormal_ += normal;
}

void SliceRows::setMedia(uint32_t row, const shared::SceneView& scene, uint32_t front,
                         uint32_t behind)
{
    if (front == shared::kNone && behind == shared::kNone) return;
    if (!anyAbsorbs_)
        for (std::vector<float>& v : absorption_) v.assign(2 * size_t(count_), 0.0f);
    anyAbsorbs_ = true;
    const vec3 before = shared::absorptionOf(scene, front),
               beyond = shared::absorptionOf(scene, behind);
    for (int c = 0; c < 3; ++c) {
        std::vector<float>& absorption = absorption_[static_cast<size_t>(c)];
        absorption[row] = before[c];
        absorption[size_t(count_) + row] = beyond[c];
    }
}

CutQuery SliceRows::query(const GatherSettings& settings) const
{
    const auto count = static_cast<float>(std::max(count_, 1u));
    CutQuery query;
    query.clampDistance = settings.clampDistance;
    query.position = middle();
    float distances2 = 0;
    for (uint32_t i = 0; i < count_; ++i) {
        const vec3 away = vec3(position_[0][i], position_[1][i], position_[2][i]) - query.position;
        distances2 += glm::dot(away, away);
    }
    query.spread = std::sqrt(distances2 / count);
    const float length = glm::length(meanNormal_);
    if (anyTransmits_ || !(length > 1e-3f * count)) return query;
    query.normal = meanNormal_ / length;
    // The mean of n . m over unit normals n is the length of their mean, whose direction is m.
    // Less by rounding, so that lights at the horizon of a flat slice keep an order.
    query.cosHalf = std::min(length / count, 1.0f) - 1e-5f;
    query.sinHalf = std::sqrt(1 - query.cosHalf * query.cosHalf);
    return query;
}

CutQuery SliceRows::queryAt(uint32_t row, const GatherSettings& settings) const
{
    CutQuery query;
    query.clampDistance = settings.clampDistance;
    query.position = {position_[0][row], position_[1][row], position_[2][row]};
    query.normal = shadingNormal(row);
    return query;
}

bool SliceRows::isLambert(uint32_t row) const
{
    const auto at = std::ranges::lower_bound(surfaces_, row, {}, &Surface::row);
    return at == surfaces_.end() || at->row != row;
}

float SliceRows::largestResponse(uint32_t row, const LightNode& node, LightKind kind) const
{
    const auto at = std::ranges::lower_bound(surfaces_, row, {}, &Surface::row);
    if (at == surfaces_.end() || at->row != row)
        return shared::maxComponent({albedo_[0][row], albedo_[1][row], albedo_[2][row]});
    // Directions to the node: a cone around its sphere, or around its normals.
    vec3 axis = -node.axis;
    float sine = node.sinHalf;
    bool everywhere = node.cosHalf <= 0;
    if (kind != LightKind::directional) {
        const vec3 position(position_[0][row], position_[1][row], position_[2][row]);
        axis = 0.5f * (node.low + node.high) - position;
        const float distance = glm::length(axis), radius = 0.5f * glm::length(node.high - node.low);
        everywhere = !(distance > radius);
        sine = everywhere ? 1 : radius / distance;
        if (distance > 0) axis /= distance;
    }
    const vec3 mirror(-at->wo.x, -at->wo.y, at->wo.z);
    const auto response = [&](vec3 wi) {
        // Of light from below the horizon something may still come from above it.
        if (transmits_[row] == 0) wi.z = std::max(wi.z, kAboveHorizon);
        wi = glm::normalize(wi);
        vec3 f;
        float pdf;
        shared::evalPdfLobes(at->bsdf, at->lobes, at->wo, wi, f, pdf);
        return shared::maxComponent(f);
    };
    if (everywhere) return response(mirror);
    // Towards the mirror image as far as the cone reaches.
    const vec3 middle = shared::toLocal(at->frame, axis);
    const vec3 across = mirror - middle * glm::dot(middle, mirror);
    const float length = glm::length(across);
    const float cosine = std::sqrt(std::max(0.0f, 1 - sine * sine));
    const vec3 nearest = glm::dot(middle, mirror) >= cosine || !(length > 0)
                             ? mirror
                             : cosine * middle + sine * (across / length);
    return std::max(response(middle), response(nearest));
}

/// Events before the receiver, at the receiver, and before the light are maxDepth at most: what a
/// receiver must have less of.
static int mostEventsBefore(const Column& column, const GatherSettings& settings)
{
    return static_cast<int>(settings.maxDepth - std::min(settings.maxDepth, column.light->bounces));
}

/// Whether light from the front is all there is to ask for, whichever row it is.
bool SliceRows::isSimple(const Column& column, const GatherSettings& settings) const
{
    return !anyTransmits_ && mostEvents_ < mostEventsBefore(column, settings);
}

void SliceRows::findReached(const Column& column, const GatherSettings& settings,
                            std::span<float> scratch, std::span<uint64_t> reached)
{
    if (!isSimple(column, settings)) {
        weigh(column, settings, scratch);
        positiveToBits(scratch, reached);
        return;
    }
    const std::span<const float> reach = bounds_.reach(*column.light, anySideDiffers_);
    for (size_t w = 0; w < reached.size(); ++w) {
        reached[w] = reach[w] == RowBounds::kAll ? wordOfRows(count_, w) : 0;
        if (reach[w] != RowBounds::kSome) continue;
        const auto begin = static_cast<uint32_t>(RowBounds::kRows * w);
        const IndexRange rows{begin, std::min(begin + RowBounds::kRows, count_)};
        weigh(column, settings, rows, scratch);
        positiveToBits(scratch.subspan(begin, rows.size()), reached.subspan(w, 1));
    }
}

void SliceRows::weigh(const Column& column, const GatherSettings& settings, IndexRange rows,
                      std::span<float> weights) const
{
    const float* nx = normal_[0].data();
    const float* ny = normal_[1].data();
    const float* nz = normal_[2].data();
    const float* gx = side_[0].data();
    const float* gy = side_[1].data();
    const float* gz = side_[2].data();
    const int most = mostEventsBefore(column, settings);
    const auto weighWith = [&](const auto& cosine) {
        weighRows(column, settings.clampDistance, position_, cosine, rows, weights.data());
    };
    if (isSimple(column, settings)) {
        if (anySideDiffers_)
            weighWith([=](uint32_t i, float x, float y, float z) {
                const float a = x * nx[i] + y * ny[i] + z * nz[i];
                const float g = x * gx[i] + y * gy[i] + z * gz[i];
                return std::max(a, 0.0f) * static_cast<float>(g > 0);
            });
        else
            weighWith([=](uint32_t i, float x, float y, float z) {
                return std::max(x * nx[i] + y * ny[i] + z * nz[i], 0.0f);
            });
        return;
    }
    const int* events = events_.data();
    const int* transmits = transmits_.data();
    // The cosine at the receiver, both normals agreeing: 0 where light cannot go through.
    weighWith([=](uint32_t i, float x, float y, float z) {
        const float a = x * nx[i] + y * ny[i] + z * nz[i];
        const float g = x * gx[i] + y * gy[i] + z * gz[i];
        // Products in place of branches, which end vectorization.
        const int passes = int(a * g > 0) & (int(a > 0) | transmits[i]) & int(events[i] < most);
        return std::abs(a) * static_cast<float>(passes);
    });
}

void SliceRows::clear(IndexRange rows)
{
    for (RowTriple* triple : {&irradiance_, &sum_})
        for (std::vector<float>& v : *triple)
            std::fill(v.begin() + rows.begin, v.begin() + rows.end, 0.0f);
    gloss_.forget(rows);
}

void SliceRows::add(const Column& column, const LightSet& lights, IndexRange rows,
                    std::span<const float> weights)
{
    if (column.light->detail == shared::kNone && surfaces_.empty() && !anyAbsorbs_)
        return addLambert(column, rows, weights);
    for (uint32_t begin = rows.begin; begin < rows.end; begin += kBlock) {
        const IndexRange block{begin, std::min(begin + kBlock, rows.end)};
        uint32_t bits = 0;  // sums of floats have an order and do not become vectors
        for (uint32_t i = block.begin; i < block.end; ++i)
            bits |= std::bit_cast<uint32_t>(weights[i]);
        if (bits != 0) addBlock(column, lights, block, weights);
    }
}

/// Of Lambertian rows and a light that sends the same to all.
void SliceRows::addLambert(const Column& column, IndexRange rows, std::span<const float> weights)
{
    addScaled(irradiance_[0].data(), irradiance_[1].data(), irradiance_[2].data(),
              column.light->intensity * column.scale, weights.data(), rows);
}

void SliceRows::addBlock(const Column& column, const LightSet& lights, IndexRange rows,
                         std::span<const float> weights)
{
    findLight(column, lights, rows, weights);
    // What is infinitely far is in no medium.
    if (anyAbsorbs_ && column.light->kind != LightKind::directional) dimLight(rows, weights);
    for (size_t c = 0; c < 3 && surfaces_.size() < count_; ++c)
        addProducts(irradiance_[c].data(), leaving_[c].data(), weights.data(), rows);
    if (!gloss_.empty()) gloss_.add(rows, wi_, leaving_, weights);
    if (otherSurfaces_ == 0) return;
    // Surfaces stand in the order of their rows.
    for (auto at = std::ranges::lower_bound(surfaces_, rows.begin, {}, &Surface::row);
         at != surfaces_.end() && at->row < rows.end; ++at) {
        const Surface& s = *at;
        if (s.isGloss || weights[s.row] == 0) continue;
        const vec3 wi(wi_[0][s.row], wi_[1][s.row], wi_[2][s.row]);
        vec3 f;
        float pdf;
        shared::evalPdfLobes(s.bsdf, s.lobes, s.wo, shared::toLocal(s.frame, wi), f, pdf);
        for (int c = 0; c < 3; ++c) {
            const auto k = static_cast<size_t>(c);
            sum_[k][s.row] += f[c] * leaving_[k][s.row] * weights[s.row];
        }
    }
}

void SliceRows::findDirections(const VirtualLight& light, IndexRange rows)
{
    const bool distant = light.kind == LightKind::directional;
    const vec3 from = distant ? -light.normal : light.position;
    const float near = distant ? 0.0f : 1.0f;
    const float* px = position_[0].data();
    const float* py = position_[1].data();
    const float* pz = position_[2].data();
    float* __restrict scale = scale_.data();
    for (uint32_t i = rows.begin; i < rows.end; ++i) {
        const float x = from.x - near * px[i], y = from.y - near * py[i], z = from.z - near * pz[i];
        scale[i] = 1 / std::sqrt(std::max(x * x + y * y + z * z, kTooNear2));
    }
    for (size_t c = 0; c < 3; ++c)
        scaleFrom(wi_[c].data(), from[static_cast<int>(c)], position_[c].data(), near,
                  scale_.data(), rows);
}

/// What the light of a column sends to rows whose weight is not 0, and from where.
void SliceRows::findLight(const Column& column, const LightSet& lights, IndexRange rows,
                          std::span<const float> weights)
{
    const VirtualLight& light = *column.light;
    const vec3 intensity = light.intensity * column.scale;
    findDirections(light, rows);
    const auto send = [&](const auto& share) {
        for (uint32_t i = rows.begin; i < rows.end; ++i) {
            if (weights[i] == 0) continue;
            const vec3 sent = intensity * share(-vec3(wi_[0][i], wi_[1][i], wi_[2][i]));
            for (int c = 0; c < 3; ++c) leaving_[static_cast<size_t>(c)][i] = sent[c];
        }
    };
    if (light.detail == shared::kNone) {
        for (int c = 0; c < 3; ++c) {
            std::vector<float>& out = leaving_[static_cast<size_t>(c)];
            std::fill(out.begin() + rows.begin, out.begin() + rows.end, intensity[c]);
        }
    } else if (light.kind != LightKind::surface) {
        send([&](const vec3& out) {
            return lights.spots[light.detail].at(glm::dot(out, light.normal));
        });
    } else {
        const LightSurface& s = lights.surfaces[light.detail];
        if (isGloss(s.bsdf, s.incident))
            scatterTowards(s, intensity, rows, wi_, leaving_);
        else if (shared::isLambert(s.bsdf))
            scatterDiffuse(s, intensity, rows, wi_, leaving_);
        else
            send([&](const vec3& out) { return s.scattered(out); });
    }
}

/// shared::dimming, of what findLight has found.
void SliceRows::dimLight(IndexRange rows, std::span<const float> weights)
{
    for (uint32_t i = rows.begin; i < rows.end; ++i) {
        if (weights[i] == 0) continue;
        const vec3 wi(wi_[0][i], wi_[1][i], wi_[2][i]);
        const size_t at = fromBehind(i, wi) ? size_t(count_) + i : i;
        for (size_t c = 0; c < 3; ++c) leaving_[c][i] *= std::exp(-absorption_[c][at] / scale_[i]);
    }
}

float SliceRows::brightness(const Column& column, std::span<const float> weights)
{
    // Several sums at a time, in an order of their own that is always the same.
    constexpr size_t kLanes = 16;
    std::array<float, kLanes> sums{};
    size_t i = 0;
    for (; i + kLanes <= weights.size(); i += kLanes)
        for (size_t k = 0; k < kLanes; ++k) sums[k] += weights[i + k];
    for (; i < weights.size(); ++i) sums[0] += weights[i];
    float sum = 0;
    for (const float s : sums) sum += s;
    return sum * shared::luminance(column.light->intensity) * column.scale;
}

}  // namespace core::many_lights

// See row_bounds.h.
#include "core/many_lights/row_bounds.h"

#include <algorithm>
#include <cmath>

#include "shared/virtual_light.h"

namespace core::many_lights {

using glm::vec3;

namespace {

// Of the distance: by so much bounds are wider than they are found, for they and the weights that
// they speak of are rounded.
constexpr float kRounding = 1e-4f;
constexpr float kApart = 1e-8f;  // the square is well above shared::kTooNear2

vec3 at(const RowTriple& triple, size_t i)
{
    return {triple[0][i], triple[1][i], triple[2][i]};
}

void put(RowTriple& triple, size_t i, const vec3& v)
{
    for (size_t c = 0; c < 3; ++c) triple[c][i] = v[static_cast<int>(c)];
}

/// By value, as references leave branches behind.
float lesser(float a, float b)
{
    return a < b ? a : b;
}

/// kNone, kSome or kAll of numbers between two bounds, which are to be above 0.
float verdict(float low, float high, float margin)
{
    return static_cast<float>(high > -margin) + static_cast<float>(low > margin);
}

}  // namespace

void RowBounds::reset(const RowTriple& position, const RowTriple& normal, const RowTriple& side,
                      uint32_t count)
{
    const size_t words = (count + kRows - 1) / kRows;
    for (RowTriple* triple : {&middle_, &shading_.axis, &geometric_.axis})
        for (std::vector<float>& v : *triple) v.resize(words);
    for (Cone* cone : {&shading_, &geometric_})
        for (std::vector<float>* v : {&cone->cosine, &cone->sine, &cone->away}) v->resize(words);
    radius_.resize(words);
    reach_.resize(words);
    for (size_t w = 0; w < words; ++w) {
        const auto begin = static_cast<uint32_t>(kRows * w), end = std::min(begin + kRows, count);
        vec3 low = at(position, begin), high = low;
        for (uint32_t i = begin; i < end; ++i) {
            low = glm::min(low, at(position, i));
            high = glm::max(high, at(position, i));
        }
        const vec3 middle = 0.5f * (low + high);
        float radius2 = 0;
        for (uint32_t i = begin; i < end; ++i) {
            const vec3 away = at(position, i) - middle;
            radius2 = std::max(radius2, glm::dot(away, away));
        }
        put(middle_, w, middle);
        radius_[w] = std::sqrt(radius2);
        setCone(shading_, position, normal, w, begin, end);
        setCone(geometric_, position, side, w, begin, end);
    }
}

void RowBounds::setCone(Cone& cone, const RowTriple& position, const RowTriple& normal, size_t word,
                        uint32_t begin, uint32_t end)
{
    vec3 sum(0);
    for (uint32_t i = begin; i < end; ++i) sum += at(normal, i);
    const float length = glm::length(sum);
    const vec3 axis = length > 0 ? sum / length : at(normal, begin);
    float cosine = 1, height = 0;
    for (uint32_t i = begin; i < end; ++i) {
        cosine = std::min(cosine, glm::dot(axis, at(normal, i)));
        height = std::max(height, std::abs(glm::dot(axis, at(position, i) - at(middle_, word))));
    }
    const float sine = std::sqrt(std::max(1 - cosine * cosine, 0.0f));
    put(cone.axis, word, axis);
    cone.cosine[word] = cosine;
    cone.sine[word] = sine;
    cone.away[word] = height + radius_[word] * (cosine > 0 ? sine : 1.0f);
}

/// Cosines to the rows: with the angle phi between the axis and the way from the middle to the
/// light and theta of the cone they lie between those of phi + theta and phi - theta.
void RowBounds::judge(const VirtualLight& light, const Cone& cone)
{
    const bool distant = light.kind == LightKind::directional;
    const vec3 from = distant ? -light.normal : light.position;
    const float near = distant ? 0.0f : 1.0f;
    const float *mx = middle_[0].data(), *my = middle_[1].data(), *mz = middle_[2].data();
    const float *ax = cone.axis[0].data(), *ay = cone.axis[1].data(), *az = cone.axis[2].data();
    float* __restrict reach = reach_.data();
    for (size_t w = 0; w < reach_.size(); ++w) {
        const float x = from.x - near * mx[w], y = from.y - near * my[w], z = from.z - near * mz[w];
        const float d2 = x * x + y * y + z * z, along = x * ax[w] + y * ay[w] + z * az[w];
        const float rest = d2 - along * along;
        const float across = std::sqrt(rest > 0 ? rest : 0);
        const float away = near * cone.away[w];
        const float least = along * cone.cosine[w] - across * cone.sine[w],
                    most = along * cone.cosine[w] + across * cone.sine[w];
        // Beyond the axis and its opposite, which the cone may reach
        const float length = std::sqrt(d2);
        const float low = along < -cone.cosine[w] * length ? -length : least,
                    high = along > cone.cosine[w] * length ? length : most;
        const float margin = kRounding * (length + near * radius_[w]);
        reach[w] = lesser(reach[w], verdict(low - away, high + away, margin));
    }
}

/// Cosines at the light, and distances that have an inverse.
void RowBounds::judgeSide(const VirtualLight& light)
{
    const vec3 p = light.position, n = light.normal;
    const float back = light.bothSides != 0 ? 1.0f : 0.0f;
    const float *mx = middle_[0].data(), *my = middle_[1].data(), *mz = middle_[2].data();
    float* __restrict reach = reach_.data();
    for (size_t w = 0; w < reach_.size(); ++w) {
        const float x = mx[w] - p.x, y = my[w] - p.y, z = mz[w] - p.z;
        const float length = std::sqrt(x * x + y * y + z * z), r = radius_[w];
        const float facing = x * n.x + y * n.y + z * n.z, behind = -back * facing;
        const float most = facing > behind ? facing : behind;
        const float margin = kRounding * (length + r);
        reach[w] = lesser(reach[w], verdict(most - r, most + r, margin));
        // Nor too near to have an inverse
        reach[w] = lesser(reach[w], 1 + static_cast<float>(length - r > margin + kApart));
    }
}

std::span<const float> RowBounds::reach(const VirtualLight& light, bool sides)
{
    std::ranges::fill(reach_, kAll);
    judge(light, shading_);
    if (sides) judge(light, geometric_);
    if (light.kind == LightKind::surface) judgeSide(light);
    return reach_;
}

}  // namespace core::many_lights

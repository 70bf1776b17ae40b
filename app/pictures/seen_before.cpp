// See seen_before.h.
#include "app/pictures/seen_before.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/camera.h"

namespace app {

namespace {

constexpr float kNearnessOff = 0.03f;  // relative error up to which two places are one
constexpr float kTurnOff = 0.5f;       // cosine between their normals
constexpr float kSeen = 0.25f;         // samples from which a surface was there, and is no guess

/// Directions of points of the film, from -1 to 1 on it.
struct Film {
    glm::dvec3 right, up, forward;
    glm::dvec2 half;  // tangents

    Film(const core::Camera& camera, glm::uvec2 size)
    {
        const shared::CameraData data = core::cameraData(camera, size.x, size.y);
        right = data.right;
        up = data.up;
        forward = data.forward;
        half = static_cast<double>(data.tanHalfHeight) * glm::dvec2(data.aspect, 1);
    }
};

}  // namespace

uint32_t packSurface(const core::Aovs& aovs, size_t pixel)
{
    const float *normal = &aovs.normal.pixels[3 * pixel], *ids = &aovs.ids.pixels[3 * pixel];
    if (!(aovs.depth.pixels[pixel] > 0)) return 0xff000000u;
    uint32_t packed = (static_cast<uint32_t>(ids[1]) & 0x3fu) | (ids[2] >= 0 ? 0x40u : 0u);
    for (int c = 0; c < 3; ++c) {
        const float scaled = std::round(127 * std::clamp(normal[c], -1.0f, 1.0f));
        packed = packed << 8 | (static_cast<uint32_t>(static_cast<int>(scaled)) & 0xffu);
    }
    return packed;
}

bool oneSurface(uint32_t a, uint32_t b)
{
    if (a == b) return true;
    if ((a ^ b) >> 24 != 0) return false;
    int dot = 0;
    for (int shift = 0; shift < 24; shift += 8)
        dot += static_cast<int8_t>(a >> shift) * static_cast<int8_t>(b >> shift);
    return static_cast<float>(dot) >= kTurnOff * 127 * 127;
}

FilmPoints::FilmPoints(const core::Camera& camera, glm::uvec2 size)
    : width_(size.x), pixel_(glm::vec2(2) / glm::vec2(size)), half_(Film(camera, size).half),
      shift_(camera.shift)
{}

float FilmPoints::nearness(const core::Aovs& aovs, size_t pixel) const
{
    const float depth = aovs.depth.pixels[pixel];  // along the ray
    const glm::vec2 at((static_cast<float>(pixel % width_) + 0.5f) * pixel_.x - 1,
                       1 - (static_cast<float>(pixel / width_) + 0.5f) * pixel_.y);
    const glm::vec2 tangents = half_ * (at + shift_);
    return depth > 0 ? std::sqrt(1 + glm::dot(tangents, tangents)) / depth : 0;
}

double additive(uint64_t i, double step)
{
    const double x = 0.5 + static_cast<double>(i & 0xffffu) * step;
    return x - std::floor(x);
}

SeenBefore::SeenBefore(const std::vector<SeenPlace>& places, glm::uvec2 size,
                       const core::Camera& then, const core::Camera& now, uint64_t count)
    : places_(places), size_(size),
      chance_(additive(count, 0.6180339887498949), additive(count, 0.4142135623730950))
{
    if (places_.empty()) return;
    const Film here(now, size), there(then, size);
    half_ = here.half;
    const auto onFilm = [&](const glm::dvec3& d) {
        const glm::dvec3 p(glm::dot(d, there.right) / there.half.x,
                           glm::dot(d, there.up) / there.half.y, glm::dot(d, there.forward));
        return glm::vec3(0.5 * size.x * (p.z + p.x), 0.5 * size.y * (p.z - p.y), p.z);
    };
    turn_ = {onFilm(here.right), onFilm(here.up), onFilm(here.forward)};
    way_ = onFilm(now.position - then.position);
}

Look SeenBefore::lookUp(const glm::vec3& direction, float nearness, uint32_t surface,
                        float slack) const
{
    Look look;
    const glm::vec3 v = direction + nearness * way_;
    if (!(v.z > 1e-6f)) return look;
    const float scale = 1 / v.z;
    const glm::vec2 film = glm::vec2(v) * scale - 0.5f;
    if (!(film.x > -1 && film.y > -1 && film.x < static_cast<float>(size_.x) &&
          film.y < static_cast<float>(size_.y)))
        return look;
    const int x = static_cast<int>(film.x + 1) - 1, y = static_cast<int>(film.y + 1) - 1;
    const float tx = film.x - static_cast<float>(x), ty = film.y - static_cast<float>(y);
    const float near = nearness * scale, off = kNearnessOff * near + slack * scale;
    const int last = size_.x * size_.y - 1, first = y * size_.x + x;
    const float left = x >= 0 ? 1 - tx : 0, right = x + 1 < size_.x ? tx : 0,
                above = y >= 0 ? 1 - ty : 0, below = y + 1 < size_.y ? ty : 0;
    const std::array<float, 4> weights{left * above, right * above, left * below, right * below};
    std::array<const SeenPlace*, 4> four;
    for (int i = 0; i < 4; ++i) {
        const int at = std::clamp(first + (i & 1) + (i >> 1) * size_.x, 0, last);
        four[static_cast<size_t>(i)] = &places_[static_cast<size_t>(at)];
    }
    const size_t pick = (tx > chance_.x ? 1u : 0u) + (ty > chance_.y ? 2u : 0u);
    float best = 0;
    for (size_t i = 0; i < 4; ++i) {
        const SeenPlace& p = *four[i];
        const bool fits = std::abs(p.nearness - near) <= off && oneSurface(p.surface, surface);
        const float weight = fits ? weights[i] : 0;
        if (i == pick) look.picked = fits;
        look.weight += weight;
        look.light += weight * p.light;
        const float otherWeight =
            fits || p.nearness < near - off || p.light.w < kSeen ? 0 : weights[i];
        if (otherWeight > best) {
            best = otherWeight;
            look.other = &p;
        }
    }
    if (look.weight > 0) look.light /= look.weight;
    if (!(look.light.w > 0)) look.weight = 0;
    if (!(weights[pick] > 0)) look.picked = look.weight > kFewestSeen;  // beside the film
    look.picked &= look.weight > 0;
    return look;
}

float SeenBefore::nearnessNow(float then, const glm::vec3& direction) const
{
    const float ahead = 1 - then * way_.z;
    return ahead > 1e-6f ? then * direction.z / ahead : -1;
}

}  // namespace app

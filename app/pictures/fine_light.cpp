// See fine_light.h. Joint bilateral upsampling (Kopf et al. 2007), by surfaces instead of colours.
#include "app/pictures/fine_light.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "app/pictures/pixel_rays.h"
#include "app/pictures/same_surface.h"
#include "core/base/parallel.h"

namespace app {

namespace {

constexpr size_t kBand = 8;  // rows of a piece of a loop
constexpr float kNothing = -1, kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr float kLeastWeight = 1e-3f;  // of the four pixels around, so that one alone is enough
// Of a surface that faces away, among those around of which none is the same
constexpr float kLeastTurn = 0.02f;

/// What a pixel shows, and the light on it where it is known.
struct Place {
    float kind = kUnknown;  // number of the material, or kNothing
    glm::vec3 normal{0}, point{0}, light{0};
    bool emits = false;  // what falls on it tells little of what falls on others

    bool isSurface() const { return kind >= 0; }
};

/// The pixels of a picture by their first hits.
class Places {
public:
    /// Points are relative to `origin`.
    Places(const SeenSurfaces& seen, const glm::dvec3& origin)
        : aovs_(seen.aovs), rays_(seen.camera, aovs_.depth.width, aovs_.depth.height),
          from_(seen.camera.position - origin),
          emits_(aovs_.emission.pixels.size() == aovs_.albedo.pixels.size())
    {}

    Place at(uint32_t x, uint32_t y) const
    {
        const float depth = *aovs_.depth.at(x, y);
        Place p;
        p.kind = depth > 0 ? aovs_.ids.at(x, y)[1] : kNothing;
        if (!p.isSurface()) return p;
        const float* n = aovs_.normal.at(x, y);
        p.normal = {n[0], n[1], n[2]};
        p.point = from_ + rays_.point(x, y, depth);
        return p;
    }
    glm::vec3 albedo(uint32_t x, uint32_t y) const
    {
        return albedoAt(aovs_, size_t(y) * aovs_.depth.width + x);
    }
    glm::vec3 emission(uint32_t x, uint32_t y) const
    {
        if (!emits_) return glm::vec3(0);
        const float* e = aovs_.emission.at(x, y);
        return {e[0], e[1], e[2]};
    }

private:
    const core::Aovs& aovs_;
    PixelRays rays_;
    glm::vec3 from_;
    bool emits_;
};

bool oneSurface(const Place& a, const Place& b)
{
    if (a.kind != b.kind || glm::dot(a.normal, b.normal) <= kSameTurn) return false;
    const glm::vec3 d = b.point - a.point;
    const float leaves = glm::dot(d, a.normal + b.normal);
    return leaves * leaves <= kSameBend * glm::dot(d, d);
}

/// Light that is known at the pixels of a small picture.
class KnownLight {
public:
    KnownLight(const core::Image& mean, const SeenSurfaces& seen)
        : size_(mean.width, mean.height), places_(size_t(mean.width) * mean.height),
          rays_(seen.camera, mean.width, mean.height)
    {
        const Places all(seen, seen.camera.position);
        glm::vec3 sum(0);
        float count = 0;
        for (uint32_t y = 0; y < mean.height; ++y)
            for (uint32_t x = 0; x < mean.width; ++x) {
                const float* m = mean.at(x, y);
                const glm::vec3 radiance = glm::vec3(m[0], m[1], m[2]) - all.emission(x, y);
                if (!std::isfinite(radiance.x + radiance.y + radiance.z)) continue;
                Place& p = places_[size_t(y) * mean.width + x];
                p = all.at(x, y);
                if (!p.isSurface()) continue;
                p.light = glm::max(radiance, glm::vec3(0)) / all.albedo(x, y);
                p.emits = all.emission(x, y) != glm::vec3(0);
                if (p.emits) continue;
                sum += p.light;
                ++count;
            }
        mean_ = sum / std::max(count, 1.0f);
    }

    /// On a surface, whose point is relative to the camera that has seen the light.
    glm::vec3 on(const Place& here) const
    {
        const std::optional<glm::vec2> seen = rays_.film(here.point);
        if (!seen) return mean_;
        // What is beyond the rim is seen at the rim, and its numbers stay whole ones.
        const glm::vec2 film = glm::clamp(*seen, glm::vec2(-1), glm::vec2(size_));
        const glm::ivec2 corner(glm::floor(film));
        const glm::vec2 part = film - glm::vec2(corner);
        glm::vec3 sum(0);
        float weights = 0;
        for (int i = 0; i < 4; ++i) {
            const glm::ivec2 step(i & 1, i >> 1);
            const Place& there = place(corner + step);
            if (!oneSurface(here, there)) continue;
            const glm::vec2 w = glm::mix(1.0f - part, part, glm::vec2(step));
            sum += (w.x * w.y + kLeastWeight) * there.light;
            weights += w.x * w.y + kLeastWeight;
        }
        return weights > 0 ? sum / weights : around(here, corner, part);
    }

private:
    const Place& place(glm::ivec2 p) const
    {
        p = glm::clamp(p, glm::ivec2(0), size_ - 1);
        return places_[size_t(p.y) * size_t(size_.x) + size_t(p.x)];
    }

    /// On one that none of the four pixels around shows: of sixteen those of the same material, or
    /// all; the more, the nearer they are and the more they face the same way.
    glm::vec3 around(const Place& here, glm::ivec2 corner, glm::vec2 part) const
    {
        glm::vec4 same(0), all(0);
        for (int y = -1; y <= 2; ++y)
            for (int x = -1; x <= 2; ++x) {
                const Place& there = place(corner + glm::ivec2(x, y));
                if (!there.isSurface() || (there.emits && here.kind != there.kind)) continue;
                const glm::vec2 d = glm::vec2(x, y) - part;
                const float turn = std::max(glm::dot(here.normal, there.normal), kLeastTurn);
                const glm::vec4 light =
                    turn * turn / (0.25f + glm::dot(d, d)) * glm::vec4(there.light, 1);
                all += light;
                if (here.kind == there.kind) same += light;
            }
        if (same.w > kLeastTurn) return glm::vec3(same) / same.w;
        return all.w > 0 ? glm::vec3(all) / all.w : mean_;
    }

    glm::ivec2 size_;
    std::vector<Place> places_;
    PixelRays rays_;
    glm::vec3 mean_{0};
};

}  // namespace

core::Image lightOnSurfaces(const core::Image& mean, const SeenSurfaces& coarse,
                            const SeenSurfaces& fine)
{
    const uint32_t width = fine.aovs.depth.width, height = fine.aovs.depth.height;
    const KnownLight known(mean, coarse);
    const Places places(fine, coarse.camera.position);
    core::Image result(width, height, 3);
    core::parallelFor(height, kBand, [&](size_t begin, size_t end) {
        for (auto y = static_cast<uint32_t>(begin); y < end; ++y)
            for (uint32_t x = 0; x < width; ++x) {
                const Place here = places.at(x, y);
                glm::vec3 shown = places.emission(x, y);
                if (here.isSurface()) shown += known.on(here) * places.albedo(x, y);
                for (int c = 0; c < 3; ++c) result.at(x, y)[c] = shown[c];
            }
    });
    return result;
}

}  // namespace app

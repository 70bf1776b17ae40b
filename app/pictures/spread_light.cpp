// See spread_light.h. Edge-avoiding averages in growing steps (a-trous: Dammertz et al. 2010), here
// as exchange between pairs of pixels: what one gains the other loses, so that no light is won or
// lost, and a constant stays one. Steps of 1, 2, ... 16 with weights 1/4, 1/2, 1/4 make a triangle
// of 32 pixels to each side. Steps go along rows, then along columns, for loops over floats that
// lie side by side.
#include "app/pictures/spread_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "app/pictures/pixel_rays.h"
#include "app/pictures/preview_shading.h"
#include "app/pictures/same_surface.h"
#include "core/base/parallel.h"
#include "shared/tonemap.h"

namespace app {

namespace {

constexpr size_t kBlock = 64;
constexpr size_t kRows = 16;        // of a block of a loop
constexpr uint32_t kFarthest = 16;  // the last step, in pixels
constexpr float kQuiet = 0.12f;     // relative standard error from which nothing is averaged
// Of the mean brightness: what is shown where as good as no light has come. With more of it
// pictures become flat, with less what few scattering events leave dark is black: a quarter is best
// for the error on show in three rooms with three events, a half with one.
constexpr float kLamp = 0.35f;

using Plane = std::vector<float>;

/// What of a picture may be averaged with what.
struct Surfaces {
    Plane kind;  // number of the material; no number where nothing is averaged
    std::array<Plane, 3> normal, point;
};

/// Red, green, blue light on a surface, the square of its luminance, and the share of pixels that
/// have had none.
using Light = std::array<Plane, 5>;

/// Neighbours at a distance, of which a row has so many pairs.
struct Step {
    uint32_t width, height, pixels;
    bool down;
    size_t offset() const { return down ? size_t(pixels) * width : pixels; }
    uint32_t pairs(uint32_t row) const
    {
        if (down) return row + pixels < height ? width : 0;
        return width > pixels ? width - pixels : 0;
    }
};

void forRows(uint32_t height, const auto& body)
{
    core::parallelFor(height, kRows, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) body(static_cast<uint32_t>(y));
    });
}

/// Whether the pixel's light comes from elsewhere, and is of a size that has a square.
bool reflects(const core::Image& mean, const core::Aovs& aovs, size_t pixel)
{
    constexpr float kMost = 1e15f;
    const float* p = &mean.pixels[3 * pixel];
    return aovs.depth.pixels[pixel] > 0 && aovs.ids.pixels[3 * pixel + 2] < 0 &&
           !emits(aovs, pixel) && std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]) < kMost;
}

Surfaces surfacesOf(const core::Image& mean, const core::Aovs& aovs, const core::Camera& camera)
{
    const size_t count = size_t(mean.width) * mean.height;
    Surfaces s;
    s.kind.resize(count);
    for (size_t c = 0; c < 3; ++c) {
        s.normal[c].resize(count);
        s.point[c].resize(count);
    }
    const PixelRays rays(camera, mean.width, mean.height);
    forRows(mean.height, [&](uint32_t y) {
        for (uint32_t x = 0; x < mean.width; ++x) {
            const size_t i = size_t(y) * mean.width + x;
            s.kind[i] = reflects(mean, aovs, i) ? aovs.ids.pixels[3 * i + 1]
                                                : std::numeric_limits<float>::quiet_NaN();
            const glm::vec3 point = rays.point(x, y, aovs.depth.pixels[i]);
            for (size_t c = 0; c < 3; ++c) {
                s.normal[c][i] = aovs.normal.pixels[3 * i + c];
                s.point[c][i] = point[static_cast<int>(c)];
            }
        }
    });
    return s;
}

Light lightOf(const core::Image& mean, const core::Aovs& aovs, const Surfaces& surfaces)
{
    const size_t count = surfaces.kind.size();
    Light light;
    for (Plane& plane : light) plane.resize(count);
    forRows(mean.height, [&](uint32_t y) {
        for (size_t i = size_t(y) * mean.width; i < size_t(y + 1) * mean.width; ++i) {
            if (std::isnan(surfaces.kind[i])) continue;
            const glm::vec3 albedo = albedoAt(aovs, i);
            const float* p = &mean.pixels[3 * i];
            const glm::vec3 e = glm::vec3(p[0], p[1], p[2]) / albedo;
            const float luminance = shared::luminance(e);
            for (size_t c = 0; c < 3; ++c) light[c][i] = e[static_cast<int>(c)];
            light[3][i] = luminance * luminance;
            light[4][i] = luminance > 0 ? 0 : 1;
        }
    });
    return light;
}

/// Shares that `count` pairs exchange, kBlock of them at most: a quarter, none between two
/// surfaces. They are made in a place of their own and without branches, so that eight go at a
/// time.
void sharesOf(const Surfaces& s, const Plane& open, size_t first, size_t count, size_t offset,
              Plane& out)
{
    const auto from = [first](const Plane& plane) { return plane.data() + first; };
    const float *kind = from(s.kind), *nx = from(s.normal[0]), *ny = from(s.normal[1]),
                *nz = from(s.normal[2]), *px = from(s.point[0]), *py = from(s.point[1]),
                *pz = from(s.point[2]), *wide = from(open);
    std::array<float, kBlock> shares;
    for (size_t a = 0; a < count; ++a) {
        const size_t b = a + offset;
        const float dx = px[b] - px[a], dy = py[b] - py[a], dz = pz[b] - pz[a];
        const float leaves = dx * (nx[a] + nx[b]) + dy * (ny[a] + ny[b]) + dz * (nz[a] + nz[b]);
        const float turn = nx[a] * nx[b] + ny[a] * ny[b] + nz[a] * nz[b];
        const float one = kind[a] == kind[b] ? 0.125f : 0, turned = turn > kSameTurn ? one : 0,
                    apart = kSameBend * (dx * dx + dy * dy + dz * dz),
                    bent = leaves * leaves <= apart ? turned : 0;
        shares[a] = bent * (wide[a] + wide[b]);
    }
    std::copy_n(shares.begin(), count, out.begin() + static_cast<std::ptrdiff_t>(first));
}

/// One row after its pairs have exchanged their shares.
void exchangeRow(const Plane& from, const Plane& shares, const Step& step, uint32_t row, Plane& to)
{
    const size_t first = size_t(row) * step.width, offset = step.offset();
    const float *x = from.data(), *w = shares.data();
    float* __restrict out = to.data();
    const size_t ahead = first + step.pairs(row);
    for (size_t i = first; i < ahead; ++i) out[i] = x[i] + w[i] * (x[i + offset] - x[i]);
    for (size_t i = ahead; i < first + step.width; ++i) out[i] = x[i];
    const bool behind = !step.down || row >= step.pixels;
    const size_t from0 = step.down ? first : first + std::min(step.pixels, step.width);
    for (size_t i = from0; behind && i < first + step.width; ++i)
        out[i] += w[i - offset] * (x[i - offset] - x[i]);
}

void exchange(const Surfaces& surfaces, const Plane& open, const Step& step, Plane& shares,
              Light& light, Light& next)
{
    forRows(step.height, [&](uint32_t row) {
        const size_t first = size_t(row) * step.width, end = first + step.pairs(row);
        for (size_t i = first; i < end; i += kBlock)
            sharesOf(surfaces, open, i, std::min(end - i, kBlock), step.offset(), shares);
    });
    forRows(step.height, [&](uint32_t row) {
        for (size_t c = 0; c < light.size(); ++c) exchangeRow(light[c], shares, step, row, next[c]);
    });
    std::swap(light, next);
}

/// How many independent pixels an average to that distance is worth.
float worthOf(uint32_t farthest)
{
    const float h = static_cast<float>(farthest), one = 3 * h * h * h / (2 * h * h + 1);
    return one * one;
}

/// Which pixels need more of their neighbours, from 0 to 1: those whose light varies by more than
/// kQuiet as it stands.
void openUp(const Light& light, float worth, Plane& open)
{
    constexpr float kLeast = 1e-30f;
    const float scale = 1 / (worth * kQuiet * kQuiet);
    const float *r = light[0].data(), *g = light[1].data(), *b = light[2].data(),
                *square = light[3].data();
    for (size_t i = 0; i < open.size(); ++i) {
        const float m = shared::luminance({r[i], g[i], b[i]}), m2 = m * m;
        const float excess = scale * (square[i] - m2) / std::max(m2, kLeast) - 1;
        open[i] = m2 > kLeast ? std::clamp(excess, 0.0f, 1.0f) : 1;
    }
}

/// The light after all steps.
void average(const Surfaces& surfaces, uint32_t width, uint32_t height, Light& light)
{
    Light next = light;
    Plane open(surfaces.kind.size(), 1), shares(open.size());
    for (uint32_t pixels = 1; pixels <= kFarthest; pixels *= 2) {
        for (const bool down : {false, true})
            exchange(surfaces, open, {width, height, pixels, down}, shares, light, next);
        if (pixels < kFarthest) openUp(light, worthOf(2 * pixels), open);
    }
}

/// How bright a lamp at the camera is that shows the mean luminance of the picture, or that of the
/// surfaces where this is less.
float lampOf(const core::Image& mean, const Surfaces& surfaces, const core::Image& lamp)
{
    double all = 0, seen = 0, lit = 0;
    for (size_t i = 0; i < surfaces.kind.size(); ++i) {
        const float *p = &mean.pixels[3 * i], *l = &lamp.pixels[3 * i];
        const float luminance = shared::luminance({p[0], p[1], p[2]});
        if (!std::isfinite(luminance)) continue;
        all += static_cast<double>(luminance);
        if (std::isnan(surfaces.kind[i])) continue;
        seen += static_cast<double>(luminance);
        lit += static_cast<double>(shared::luminance({l[0], l[1], l[2]}));
    }
    all /= static_cast<double>(surfaces.kind.size());
    return static_cast<float>(lit > 0 ? std::min(all, seen / lit) : all);
}

/// The pixels of emitters, and those of nothing, that are beside something else.
class Rims {
public:
    Rims(const core::Image& mean, const core::Aovs& aovs)
        : before_(mean), aovs_(aovs), end_(mean.width, mean.height)
    {}

    /// Gives each of them the value in the middle of those around that show the same, by luminance:
    /// a path through its corner may have met the other.
    void clear(core::Image& mean) const
    {
        for (int y = 0; y < end_.y; ++y)
            for (int x = 0; x < end_.x; ++x)
                if (const size_t i = index({x, y}); kindOf(i) != kReflects)
                    std::copy_n(&before_.pixels[3 * middleAround({x, y})], 3, &mean.pixels[3 * i]);
    }

private:
    static constexpr float kReflects = -2;

    size_t index(glm::ivec2 p) const { return size_t(p.y) * before_.width + size_t(p.x); }
    float kindOf(size_t i) const
    {
        if (!(aovs_.depth.pixels[i] > 0)) return -1;
        const float emitter = aovs_.ids.pixels[3 * i + 2];
        return emitter < 0 ? kReflects : emitter;
    }
    float luminanceOf(size_t i) const
    {
        const float* v = &before_.pixels[3 * i];
        return shared::luminance({v[0], v[1], v[2]});
    }

    size_t middleAround(glm::ivec2 p) const
    {
        const size_t own = index(p);
        std::array<std::pair<float, size_t>, 9> found;
        size_t count = 0;
        bool rim = false;
        for (int i = 0; i < 9; ++i) {
            const glm::ivec2 q = p + glm::ivec2(i % 3 - 1, i / 3 - 1);
            if (q.x < 0 || q.y < 0 || q.x >= end_.x || q.y >= end_.y) continue;
            const size_t other = index(q);
            if (kindOf(other) != kindOf(own))
                rim = true;
            else if (const float l = luminanceOf(other); std::isfinite(l))
                found[count++] = {l, other};
        }
        if (!rim || count == 0) return own;
        std::nth_element(found.data(), found.data() + count / 2, found.data() + count);
        return found[count / 2].second;
    }

    core::Image before_;
    const core::Aovs& aovs_;
    glm::ivec2 end_;
};

}  // namespace

void spreadLight(core::Image& mean, const core::Aovs& aovs, const core::Camera& camera)
{
    const Surfaces surfaces = surfacesOf(mean, aovs, camera);
    Light light = lightOf(mean, aovs, surfaces);
    average(surfaces, mean.width, mean.height, light);
    const core::Image lamp = litFromCamera(aovs, camera);
    const float level = kLamp * lampOf(mean, surfaces, lamp);
    if (!(level > 0)) return;
    Rims(mean, aovs).clear(mean);
    forRows(mean.height, [&](uint32_t y) {
        for (size_t i = size_t(y) * mean.width; i < size_t(y + 1) * mean.width; ++i) {
            if (std::isnan(surfaces.kind[i])) continue;
            const glm::vec3 e(light[0][i], light[1][i], light[2][i]), albedo = albedoAt(aovs, i);
            const float missing = std::max(level - shared::luminance(e), 0.0f) * light[4][i];
            const float* l = &lamp.pixels[3 * i];
            const glm::vec3 shown = e * albedo + missing * glm::vec3(l[0], l[1], l[2]);
            for (int c = 0; c < 3; ++c) mean.pixels[3 * i + size_t(c)] = shown[c];
        }
    });
}

}  // namespace app

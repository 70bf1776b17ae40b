// See preview_shading.h.
#include "app/pictures/preview_shading.h"

#include <algorithm>
#include <cmath>

#include "app/pictures/edge_cuts.h"
#include "app/pictures/pixel_rays.h"
#include "core/base/parallel.h"
#include "shared/tonemap.h"

namespace app {

namespace {

constexpr float kDarkest = 0.15f;  // of a surface seen edge on
constexpr float kGrey = 0.1f;      // share of grey in reflectances: black things are seen, too
const glm::vec3 kEmptySpace(0.03f), kEmitter(1.5f);

glm::vec3 vectorAt(const core::Image& image, uint32_t x, uint32_t y)
{
    const float* v = image.at(x, y);
    return {v[0], v[1], v[2]};
}

/// What a lamp at the camera makes of the surface in a pixel.
glm::vec3 lit(const core::Aovs& aovs, const PixelRays& rays, uint32_t x, uint32_t y)
{
    const float facing = std::abs(glm::dot(vectorAt(aovs.normal, x, y), rays.direction(x, y)));
    return (kDarkest + (1 - kDarkest) * facing) *
           glm::mix(vectorAt(aovs.albedo, x, y), glm::vec3(0.5f), kGrey);
}

bool oneSurface(const core::Aovs& aovs, glm::uvec2 p, glm::uvec2 q)
{
    const float a = *aovs.depth.at(p.x, p.y), b = *aovs.depth.at(q.x, q.y);
    if (!(a > 0) || !(b > 0)) return !(a > 0) && !(b > 0);
    const float turn = glm::dot(vectorAt(aovs.normal, p.x, p.y), vectorAt(aovs.normal, q.x, q.y));
    const float *idsA = aovs.ids.at(p.x, p.y), *idsB = aovs.ids.at(q.x, q.y);
    const bool oneMaterial = idsA[1] == idsB[1] && (idsA[2] < 0) == (idsB[2] < 0);
    return oneMaterial && std::max(a, b) < 1.25f * std::min(a, b) && turn > 0.9f;
}

/// Bits of the neighbours of each pixel that there are and are `alike`.
template <class Alike> core::Image guideOf(glm::uvec2 size, const Alike& alike)
{
    const glm::ivec2 end(size);
    core::Image guide(size.x, size.y, 1);
    const auto bitsOf = [&](glm::ivec2 p) {
        uint32_t bits = 0;
        for (int i = 0; i < 9; ++i) {
            const glm::ivec2 q = p + glm::ivec2(i % 3 - 1, i / 3 - 1);
            if (q.x < 0 || q.y < 0 || q.x >= end.x || q.y >= end.y) continue;
            if (alike(p, q)) bits |= 1u << i;
        }
        return bits;
    };
    core::parallelFor(size.y, 8, [&](size_t begin, size_t last) {
        for (size_t y = begin; y < last; ++y)
            for (uint32_t x = 0; x < size.x; ++x)
                *guide.at(x, static_cast<uint32_t>(y)) = static_cast<float>(bitsOf({x, y}));
    });
    return guide;
}

void store(core::Image& image, uint32_t x, uint32_t y, glm::vec3 value)
{
    for (int c = 0; c < 3; ++c) image.at(x, y)[c] = value[c];
}

}  // namespace

bool fits(const core::Aovs& aovs, const core::Image& image)
{
    const auto same = [&](const core::Image& other, uint32_t channels) {
        return other.width == image.width && other.height == image.height &&
               other.channels == channels && !other.pixels.empty();
    };
    return same(aovs.depth, 1) && same(aovs.normal, 3) && same(aovs.albedo, 3) && same(aovs.ids, 3);
}

core::Image litFromCamera(const core::Aovs& aovs, const core::Camera& camera)
{
    core::Image image(aovs.depth.width, aovs.depth.height, 3);
    const PixelRays rays(camera, image.width, image.height);
    for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 0; x < image.width; ++x) {
            const bool nothing = !(*aovs.depth.at(x, y) > 0);
            const bool emits = aovs.ids.at(x, y)[2] >= 0;
            store(image, x, y, nothing ? kEmptySpace : emits ? kEmitter : lit(aovs, rays, x, y));
        }
    return image;
}

void fillUnlit(core::Image& mean, const core::Aovs& aovs, const core::Camera& camera)
{
    double sum = 0;
    const size_t count = size_t(mean.width) * mean.height;
    for (size_t i = 0; i < count; ++i) {
        const float* p = &mean.pixels[3 * i];
        const float luminance = shared::luminance({p[0], p[1], p[2]});
        if (std::isfinite(luminance)) sum += static_cast<double>(luminance);
    }
    const auto level = static_cast<float>(sum / static_cast<double>(count));
    if (!(level > 0)) return;
    const PixelRays rays(camera, mean.width, mean.height);
    for (uint32_t y = 0; y < mean.height; ++y)
        for (uint32_t x = 0; x < mean.width; ++x)
            if (*aovs.depth.at(x, y) > 0 && vectorAt(mean, x, y) == glm::vec3(0))
                store(mean, x, y, level * lit(aovs, rays, x, y));
}

core::Image surfaceGuide(const core::Aovs& aovs)
{
    core::Image guide = guideOf({aovs.depth.width, aovs.depth.height},
                                [&](glm::uvec2 p, glm::uvec2 q) { return oneSurface(aovs, p, q); });
    addCuts(guide);
    return guide;
}

core::Image smoothGuide(glm::uvec2 size)
{
    return guideOf(size, [](glm::uvec2, glm::uvec2) { return true; });
}

}  // namespace app

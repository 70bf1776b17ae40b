// Ids of nothing are -1, as images of floats have no kNone.
#include "core/methods/first_hits.h"

#include <algorithm>

namespace core {

namespace {

float asId(uint32_t id)
{
    return id == shared::kNone ? -1.0f : static_cast<float>(id);
}

void store(Image& image, size_t pixel, const glm::vec3& v)
{
    for (int c = 0; c < 3; ++c) image.pixels[3 * pixel + static_cast<size_t>(c)] = v[c];
}

}  // namespace

Aovs emptyAovs(uint32_t width, uint32_t height)
{
    Aovs aovs{Image(width, height, 1), Image(width, height, 3), Image(width, height, 3),
              Image(width, height, 3), Image(width, height, 3)};
    std::ranges::fill(aovs.ids.pixels, -1.0f);
    return aovs;
}

void storeFirstHit(const shared::FirstHit& hit, size_t pixel, Aovs& aovs)
{
    aovs.depth.pixels[pixel] = hit.depth;
    store(aovs.normal, pixel, hit.normal);
    store(aovs.albedo, pixel, hit.albedo);
    store(aovs.emission, pixel, hit.emission);
    store(aovs.ids, pixel, {asId(hit.triangle), asId(hit.material), asId(hit.emitter)});
}

}  // namespace core

#include "core/methods/guide_maps.h"

#include <array>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/methods/method.h"
#include "shared/camera.h"
#include "shared/rng.h"

namespace core {

std::vector<Image> makeGuideMaps(const Aovs& aovs, const shared::CameraData& camera,
                                 const guiding::Guide& guide)
{
    const uint32_t width = aovs.depth.width, height = aovs.depth.height;
    std::vector<Image> images(guideMaps().size(), Image(width, height, 1));
    const auto tables = guide.tables();
    const shared::GuideView view = tables->view();
    const glm::vec2 size(static_cast<float>(width), static_cast<float>(height));
    const auto addRow = [&](size_t y) {
        for (size_t x = 0; x < width; ++x) {
            const size_t i = y * width + x;
            const float depth = aovs.depth.pixels[i];
            if (!(depth > 0)) continue;
            glm::vec3 origin, direction;
            shared::cameraRay(camera, {float(x) + 0.5f, float(y) + 0.5f}, size, glm::vec2(0.5f),
                              origin, direction);
            const glm::vec3 normal(aovs.normal.pixels[3 * i], aovs.normal.pixels[3 * i + 1],
                                   aovs.normal.pixels[3 * i + 2]);
            const shared::GuideLeaf leaf =
                shared::guideAt(view, origin + depth * direction, normal);
            const std::array values{1 - leaf.share,
                                    shared::unitFloat(shared::hashUint(leaf.index + 1)),
                                    float(guide.visits(leaf.index)), leaf.reflected};
            CHECK(values.size() == images.size());
            for (size_t k = 0; k < values.size(); ++k) images[k].pixels[i] = values[k];
        }
    };
    parallelFor(height, 8, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) addRow(y);
    });
    return images;
}

std::span<const MapInfo> guideMaps()
{
    static constexpr std::array kMaps{
        MapInfo{"guided", "share of directions that the guide chooses; 0: the BSDF does better", 1},
        MapInfo{"leaf", "leaves of the guide, each a number of its own: their borders show", 1},
        MapInfo{"learnt", "records that the leaf has learnt from"},
        MapInfo{"reflected", "luminance that the leaf's surfaces send out on average"},
    };
    return kMaps;
}

}  // namespace core

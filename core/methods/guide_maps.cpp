#include "core/methods/guide_maps.h"

#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/methods/method.h"
#include "shared/camera.h"
#include "shared/rng.h"

namespace core {

namespace {

constexpr uint32_t kHemisphereSide = 48;  // pixels of a probe's picture

glm::vec3 normalAt(const Aovs& aovs, uint32_t x, uint32_t y)
{
    const float* n = aovs.normal.at(x, y);
    return {n[0], n[1], n[2]};
}

/// What the guide knows of the first hit, which must be there.
shared::GuideLeaf leafAt(const shared::GuideView& guide, const Aovs& aovs,
                         const shared::CameraData& camera, uint32_t x, uint32_t y)
{
    const glm::vec2 size(float(aovs.depth.width), float(aovs.depth.height));
    glm::vec3 origin, direction;
    shared::cameraRay(camera, {float(x) + 0.5f, float(y) + 0.5f}, size, glm::vec2(0.5f), origin,
                      direction);
    const glm::vec3 position = origin + *aovs.depth.at(x, y) * direction;
    return shared::guideAt(guide, position, normalAt(aovs, x, y));
}

/// The density over the surface, as the disk under the hemisphere; -1 around it.
Image hemisphereOf(const shared::GuideView& guide, const shared::GuideLeaf& leaf,
                   const glm::vec3& normal)
{
    Image image(kHemisphereSide, kHemisphereSide, 1);
    const glm::mat3 frame = shared::makeFrame(normal);
    for (uint32_t y = 0; y < kHemisphereSide; ++y) {
        for (uint32_t x = 0; x < kHemisphereSide; ++x) {
            const glm::vec2 p =
                (glm::vec2(float(x), float(y)) + 0.5f) * (2.0f / float(kHemisphereSide)) - 1.0f;
            const float squared = 1 - glm::dot(p, p);
            if (squared < 0) {
                *image.at(x, y) = -1;
                continue;
            }
            const glm::vec3 wi = frame * glm::vec3(p.x, -p.y, std::sqrt(squared));
            *image.at(x, y) = shared::pdfGuide(guide, leaf, wi);
        }
    }
    return image;
}

class GuideProbe final : public PlaceProbe {
public:
    GuideProbe(Aovs aovs, const shared::CameraData& camera,
               std::shared_ptr<const guiding::GuideTables> guide)
        : aovs_(std::move(aovs)), camera_(camera), guide_(std::move(guide))
    {}

    std::optional<PlacePicture> at(glm::uvec2 pixel) const override
    {
        if (pixel.x >= aovs_.depth.width || pixel.y >= aovs_.depth.height) return std::nullopt;
        if (!(*aovs_.depth.at(pixel.x, pixel.y) > 0)) return std::nullopt;
        const shared::GuideView guide = guide_->view();
        const shared::GuideLeaf leaf = leafAt(guide, aovs_, camera_, pixel.x, pixel.y);
        const long percent = std::lround(100 * (1 - leaf.share));
        return PlacePicture{hemisphereOf(guide, leaf, normalAt(aovs_, pixel.x, pixel.y)),
                            percent > 0 ? "the guide draws " + std::to_string(percent) +
                                              " % of the directions here, like this:"
                                        : "the guide is not followed here; it knows this:"};
    }

private:
    Aovs aovs_;
    shared::CameraData camera_;
    std::shared_ptr<const guiding::GuideTables> guide_;
};

}  // namespace

std::vector<Image> makeGuideMaps(const Aovs& aovs, const shared::CameraData& camera,
                                 const guiding::Guide& guide)
{
    const uint32_t width = aovs.depth.width, height = aovs.depth.height;
    std::vector<Image> images(guideMaps().size(), Image(width, height, 1));
    const auto tables = guide.tables();
    const shared::GuideView view = tables->view();
    const auto addRow = [&](uint32_t y) {
        for (uint32_t x = 0; x < width; ++x) {
            if (!(*aovs.depth.at(x, y) > 0)) continue;
            const shared::GuideLeaf leaf = leafAt(view, aovs, camera, x, y);
            const std::array values{1 - leaf.share,
                                    shared::unitFloat(shared::hashUint(leaf.index + 1)),
                                    float(guide.visits(leaf.index)), leaf.reflected};
            CHECK(values.size() == images.size());
            for (size_t k = 0; k < values.size(); ++k) *images[k].at(x, y) = values[k];
        }
    };
    parallelFor(height, 8, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) addRow(static_cast<uint32_t>(y));
    });
    return images;
}

std::shared_ptr<const PlaceProbe> makeGuideProbe(Aovs aovs, const shared::CameraData& camera,
                                                 std::shared_ptr<const guiding::GuideTables> guide)
{
    return std::make_shared<GuideProbe>(std::move(aovs), camera, std::move(guide));
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

// Lamps below a clear coat (KHR_materials_clearcoat), which shine less the lower they are seen: by
// hits and by connections, by every strategy, in every method that renders light, on every device.
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <glm/gtc/packing.hpp>
#include <gtest/gtest.h>

#include "core/methods/method.h"
#include "shared/warp.h"
#include "tests/support/methods/every_picture.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

constexpr float kCoat = 0.9f;
constexpr float kGroundAlbedo = 0.6f;

core::Material coatedLamp(float radiance, float roughness)
{
    core::Material m = emitter(glm::vec3(radiance));
    m.data.clearcoat = kCoat;
    m.data.clearcoatRoughness = roughness;
    return m;
}

/// Fresnel's reflectance of the coat, of index 1.5, in double.
double reflectance(double cosine)
{
    const double inside = std::sqrt(1 - (1 - cosine * cosine) / (1.5 * 1.5));
    const double s = (cosine - 1.5 * inside) / (cosine + 1.5 * inside);
    const double p = (1.5 * cosine - inside) / (1.5 * cosine + inside);
    return 0.5 * (s * s + p * p);
}

double shareLeft(double cosine, double coat = static_cast<double>(kCoat))
{
    return 1 - coat * reflectance(cosine);
}

/// A texture of one texel for the coat of a material; it multiplies the factor.
void setCoatTexture(SceneBuilder& b, core::Material& material, float value)
{
    core::Texture texture;
    texture.width = texture.height = 1;
    const uint16_t half = glm::packHalf1x16(value);
    texture.texels.push_back({half, half, half, glm::packHalf1x16(1.0f)});
    core::TextureUse use;
    use.texture = static_cast<int>(b.scene.textures.size());
    material.textures[shared::kTextureClearcoat] = static_cast<int>(b.scene.textureUses.size());
    b.scene.textures.push_back(texture);
    b.scene.textureUses.push_back(use);
}

TEST(CoatedLamp, ShinesLessTheLowerItIsSeen)
{
    for (const double degrees : {0.0, 50.0, 75.0, 86.0}) {
        SceneBuilder b;
        b.quad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.material(coatedLamp(2, 0.3f)));
        const double angle = degrees * std::numbers::pi / 180;
        b.camera({4 * std::sin(angle), 0, 4 * std::cos(angle)}, {0, 0, 0}, 1e-4);
        const double exact = 2 * shareLeft(std::cos(angle));
        forEachPicture(b.world(), {8, 8}, 4, [&](const PictureTaken& picture) {
            for (const float value : picture.estimate.mean.pixels)
                ASSERT_NEAR(value, exact, 1e-3) << picture.where << ", " << degrees << " degrees";
        });
    }
}

/// A floor beside a lamp that looks down and is low: little of what it sends there leaves it
/// steeply.
struct LowLamp {
    SceneBuilder builder;
    double exact = 0;  // radiance of the floor where the camera looks

    /// The coat's factor is kCoat times `texel`.
    explicit LowLamp(float roughness, float texel = 1)
    {
        core::Material lamp = coatedLamp(30, roughness);
        if (texel < 1) setCoatTexture(builder, lamp, texel);
        const glm::dvec3 corner(2.5, 0.7, 0.5), u(1, 0, 0), v(0, 0, -1);
        builder.quad({-8, 0, 8}, {16, 0, 0}, {0, 0, -16},
                     builder.material(lambert(glm::vec3(kGroundAlbedo))));
        builder.quad(corner, v, u, builder.material(lamp));
        builder.camera({-0.3, 0.5, 0.4}, {0, 0, 0}, 0.002);
        constexpr int kCells = 200;
        for (int i = 0; i < kCells; ++i) {
            for (int k = 0; k < kCells; ++k) {
                const glm::dvec3 d = corner + (i + 0.5) / kCells * u + (k + 0.5) / kCells * v;
                const double cosine = d.y / glm::length(d);  // at both ends
                exact +=
                    shareLeft(cosine, double(kCoat * texel)) * cosine * cosine / glm::dot(d, d);
            }
        }
        exact *= 30 * static_cast<double>(kGroundAlbedo) / std::numbers::pi / (kCells * kCells);
    }
};

TEST(CoatedLamp, LightsByTheAngleWithEveryStrategy)
{
    for (const float roughness : {0.0f, 0.4f}) {
        const LowLamp scene(roughness);
        const auto renderer = core::makeRenderer("path");
        renderer->setWorld(scene.builder.world(), {});
        for (const core::Strategy strategy :
             {core::Strategy::bsdf, core::Strategy::light, core::Strategy::mis}) {
            const core::PathParams params = independentParams(strategy, 1);
            const auto world = scene.builder.world();
            renderer->setView({world->cameras[0], {32, 32}, params}, core::Start::anew);
            const bool byHits = strategy == core::Strategy::bsdf;
            renderer->advance({.samples = byHits ? 4000u : 60u}, {});
            const PictureMean e = estimate(renderer->read(core::Reading::everything));
            EXPECT_LT(std::abs(score(e, scene.exact)), kScore)
                << e.mean << " instead of " << scene.exact << " by " << core::enumName(strategy);
            EXPECT_LT(detectable(e, scene.exact), byHits ? 0.08 : 0.03) << core::enumName(strategy);
        }
    }
}

/// What the coat reflects of the floor is a thousandth; a coat that darkens nothing would let a
/// third more come.
TEST(CoatedLamp, LightsByTheAngleInEveryMethod)
{
    const LowLamp scene(0.4f);
    forEachPicture(scene.builder.world(), {32, 32}, 64, [&](const PictureTaken& picture) {
        const PictureMean e = estimate(picture.estimate);
        EXPECT_NEAR(e.mean, scene.exact, 0.02 * scene.exact) << picture.where;
    });
}

/// A lamp of smooth normals, seen from behind their horizons: what it sends there does not depend
/// on where light would have arrived (.25 % less light here if it did).
TEST(CoatedLamp, LightsByTheAngleBeyondItsHorizons)
{
    SceneBuilder b;
    b.quad({-3, 1.2, -3}, {6, 0, 0}, {0, 0, 6}, b.material(lambert(glm::vec3(0.8f))));
    const std::vector<glm::vec3> corners{{0.8, 0, 0}, {0, 0.8, 0}, {0, 0, 0.8}};
    core::Mesh& lamp = b.scene.meshes[static_cast<size_t>(
        b.mesh(corners, {{0, 1, 2}}, b.material(coatedLamp(5, 0))))];
    lamp.hasNormals = true;
    for (const glm::vec3& corner : corners)
        lamp.attributes.push_back({shared::packOct(glm::normalize(corner)), 0, 0, 0});
    b.camera({-0.6, 0.8, 0.8}, {-0.75, 1.2, 0.8}, 0.5);
    std::optional<double> first;
    forEachPicture(b.world(), {16, 16}, 256, [&](const PictureTaken& picture) {
        const PictureMean e = estimate(picture.estimate);
        if (!first) first = e.mean;
        EXPECT_NEAR(e.mean, *first, 0.0012 * *first) << picture.where;
    });
}

/// A texture may leave half of the coat, or none: then no kernel knows of coats.
TEST(CoatedLamp, LightsByWhatTexturesLeaveOfItsCoat)
{
    for (const float texel : {0.5f, 0.0f}) {
        const LowLamp scene(0.4f, texel);
        forEachPicture(scene.builder.world(), {32, 32}, 64, [&](const PictureTaken& picture) {
            const PictureMean e = estimate(picture.estimate);
            EXPECT_NEAR(e.mean, scene.exact, 0.02 * scene.exact)
                << picture.where << ", " << texel << " of the coat";
        });
    }
}

}  // namespace

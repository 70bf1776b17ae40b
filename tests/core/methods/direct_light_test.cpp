// T11: one scattering event under each kind of light, against closed forms in double, at 16 points
// of a plane. Also what dims light on its way: absorption, alpha.
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>

#include "core/methods/method.h"
#include "shared/warp.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

using std::numbers::pi;
constexpr float kStageAlbedo = 0.6f;

/// Irradiance at p (normal n) from a polygon of radiance one wholly above the horizon: Lambert's
/// formula.
double polygonIrradiance(const std::vector<glm::dvec3>& polygon, const glm::dvec3& p,
                         const glm::dvec3& n)
{
    double sum = 0;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 a = glm::normalize(polygon[i] - p),
                         b = glm::normalize(polygon[(i + 1) % polygon.size()] - p);
        const glm::dvec3 c = glm::cross(a, b);
        sum += glm::dot(n, c) / glm::length(c) * std::atan2(glm::length(c), glm::dot(a, b));
    }
    return std::abs(0.5 * sum);
}

/// The same at p, facing up, from a convex body: its front faces hide nothing of each other.
double convexIrradiance(const core::Mesh& mesh, const glm::dvec3& p)
{
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
        if (glm::dot(glm::cross(b - a, c - a), p - a) > 0)
            sum += polygonIrradiance({a, b, c}, p, {0, 1, 0});
    }
    return sum;
}

/// The floor y = 0 with `lights`, seen from nearby at 16 points, each a few thousandths across.
struct Stage {
    SceneBuilder builder;
    std::vector<glm::dvec3> points;

    Stage()
    {
        builder.quad({-8, 0, 8}, {16, 0, 0}, {0, 0, -16},
                     builder.material(lambert(glm::vec3(kStageAlbedo))));
        for (int i = 0; i < 16; ++i) points.emplace_back(-1.5 + i % 4, 0.0, -1.2 + 0.9 * (i / 4));
        for (const glm::dvec3& p : points) builder.camera(p + glm::dvec3(0.3, 0.5, 0.4), p, 0.002);
    }

    /// Compares reflected radiance with albedo / pi times `irradiance`: at each point, and over all
    /// of them together with the power to see a bias of `mdb`.
    void compare(uint32_t spp, const std::function<double(glm::dvec3)>& irradiance,
                 double mdb = 0.005) const
    {
        const auto world = builder.world();
        const auto renderer = core::makeRenderer("path");
        renderer->setWorld(world, {});
        PictureMean ratio;  // of measured to exact, mean over the points that are lit
        double lit = 0;
        for (size_t i = 0; i < points.size(); ++i) {
            core::PathParams params = independentParams(core::Strategy::mis, 1);
            params.seed = static_cast<uint32_t>(i);  // or all points would err alike
            renderer->setView({world->cameras[i], {16, 16}, params}, core::Start::anew);
            renderer->advance({.samples = spp}, {});
            const core::Estimate film = renderer->read(core::Reading::everything);
            EXPECT_TRUE(film.counters.clean());
            const double exact = static_cast<double>(kStageAlbedo) / pi * irradiance(points[i]);
            const PictureMean e = estimate(film);
            if (exact == 0) {
                EXPECT_EQ(e.mean, 0.0);
                continue;
            }
            // The footprint of the pixels and single precision are worth 3e-5.
            EXPECT_LT(std::abs(e.mean - exact), kScore * std::sqrt(e.varianceOfMean) + 3e-5 * exact)
                << "point " << i << ": " << e.mean << " instead of " << exact;
            ratio.mean += e.mean / exact;
            ratio.varianceOfMean += e.varianceOfMean / (exact * exact);
            lit += 1;
        }
        ASSERT_GE(lit, 8);
        ratio.mean /= lit;
        ratio.varianceOfMean /= lit * lit;
        EXPECT_LT(std::abs(ratio.mean - 1), kScore * std::sqrt(ratio.varianceOfMean) + 3e-5);
        EXPECT_LT(detectable(ratio, 1), mdb) << "underpowered";
    }
};

core::PunctualLight punctual(uint32_t kind, float intensity)
{
    core::PunctualLight light;
    light.kind = kind;
    light.intensity = intensity;
    return light;
}

TEST(DirectLight, Point)
{
    Stage stage;
    const glm::dvec3 at(0.4, 1.7, -0.3);
    stage.builder.light(punctual(shared::kEmitterPoint, 7), glm::translate(glm::dmat4(1), at));
    stage.compare(
        4, [&](glm::dvec3 p) { return 7 * (at.y - p.y) / std::pow(glm::distance(at, p), 3); },
        0.005);
}

TEST(DirectLight, Spot)
{
    Stage stage;
    core::PunctualLight light = punctual(shared::kEmitterSpot, 9);
    light.innerCone = 0.3f;
    light.outerCone = 0.8f;
    const glm::dvec3 at(0.4, 1.7, -0.3), target(-0.2, 0, 0.3);
    stage.builder.light(light, glm::inverse(glm::lookAt(at, target, glm::dvec3(0, 0, 1))));
    const glm::dvec3 axis = glm::normalize(target - at);
    stage.compare(
        4,
        [&](glm::dvec3 p) {
            const double inner = std::cos(0.3), outer = std::cos(0.8);
            const double cosine = glm::dot(glm::normalize(p - at), axis);
            const double ramp = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
            return 9 * ramp * ramp * at.y / std::pow(glm::distance(at, p), 3);
        },
        0.005);
}

TEST(DirectLight, Directional)
{
    Stage stage;
    const glm::dvec3 axis = glm::normalize(glm::dvec3(0.3, -1, 0.5));
    stage.builder.light(punctual(shared::kEmitterDirectional, 3),
                        glm::inverse(glm::lookAt(glm::dvec3(0), axis, glm::dvec3(0, 0, 1))));
    stage.compare(4, [&](glm::dvec3) { return 3 * -axis.y; });
}

TEST(DirectLight, Rectangle)
{
    Stage stage;
    const std::vector<glm::dvec3> corners{
        {-0.5, 2, -0.5}, {0.5, 2, -0.5}, {0.5, 2.4, 0.6}, {-0.5, 2.4, 0.6}};
    std::vector<glm::vec3> positions(corners.begin(), corners.end());
    stage.builder.mesh(positions, {{0, 1, 2}, {0, 2, 3}},
                       stage.builder.material(emitter(glm::vec3(5))));
    stage.compare(
        300,
        [&](glm::dvec3 p) {
            return 5 * polygonIrradiance(corners, p, {0, 1, 0});
        },
        0.005);
}

TEST(DirectLight, Sphere)
{
    Stage stage;
    stage.builder.sphere({0.3f, 1.8f, 0.2f}, 0.5f, 3,
                         stage.builder.material(emitter(glm::vec3(5))));
    const core::Mesh& mesh = stage.builder.scene.meshes.back();
    stage.compare(1300, [&](glm::dvec3 p) { return 5 * convexIrradiance(mesh, p); });
}

/// The flat faces of a small body are often seen almost edge-on: shadow rays must not be stopped by
/// the face they aim at.
TEST(DirectLight, Octahedron)
{
    Stage stage;
    stage.builder.sphere({0.3f, 1.8f, 0.2f}, 0.5f, 0,
                         stage.builder.material(emitter(glm::vec3(5))));
    const core::Mesh& mesh = stage.builder.scene.meshes.back();
    stage.compare(1200, [&](glm::dvec3 p) { return 5 * convexIrradiance(mesh, p); });
}

/// A lamp with alpha shines as much as it is there, however it is found.
TEST(DirectLight, TransparentLamp)
{
    for (const bool mask : {false, true}) {
        Stage stage;
        core::Material lamp = emitter(glm::vec3(5));
        lamp.data.flags |= mask ? shared::kMaterialAlphaMask : shared::kMaterialAlphaBlend;
        lamp.data.alpha = mask ? 0.6f : 0.4f;  // 0.6 is above the cut-off
        const std::vector<glm::dvec3> corners{{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
        stage.builder.mesh({corners.begin(), corners.end()}, {{0, 1, 2}, {0, 2, 3}},
                           stage.builder.material(lamp));
        if (mask) {  // a second lamp, cut away
            lamp.data.alpha = 0.3f;
            stage.builder.quad({-1, 0.7f, -1}, {2, 0, 0}, {0, 0, 2}, stage.builder.material(lamp));
        }
        stage.compare(
            900,
            [&](glm::dvec3 p) {
                return 5 * (mask ? 1.0 : 0.4) * polygonIrradiance(corners, p, {0, 1, 0});
            },
            0.02);
    }
}

TEST(DirectLight, ConstantEnvironment)
{
    Stage stage;
    stage.builder.constantEnvironment(glm::vec3(1.5f));
    stage.compare(600, [&](glm::dvec3) { return 1.5 * pi; });
}

TEST(DirectLight, Sun)
{
    Stage stage;
    const glm::vec3 towards = glm::normalize(glm::vec3(0.4f, 1, -0.3f));
    for (const float angle : {0.00465f, 0.3f}) {
        stage.builder.scene.sun = core::Sun{towards, angle, glm::vec3(100)};
        const double s = std::sin(static_cast<double>(angle));
        stage.compare(
            40, [&](glm::dvec3) { return 100 * pi * s * s * static_cast<double>(towards.y); });
    }
}

/// N11: a sun of one texel at 1e9 and 1e12, and a lamp of 1e-8 square metres.
TEST(DirectLight, TinyAndBright)
{
    for (const float radiance : {1e9f, 1e12f}) {
        Stage stage;
        core::Environment e;
        e.width = 64;
        e.height = 32;
        e.texels.assign(64 * 32, glm::vec4(0));
        e.texels[6 * 64 + 20] = glm::vec4(glm::vec3(radiance), 1);
        stage.builder.scene.environment = std::move(e);
        // The bilinear tent about the texel's centre, integrated with the floor's cosine.
        double irradiance = 0;
        const int steps = 400;
        for (int j = 0; j < steps; ++j) {
            const double v = 5.5 + 2.0 * (j + 0.5) / steps, theta = pi * v / 32;
            irradiance += (1 - std::abs(v - 6.5)) * std::sin(theta) * std::cos(theta);
        }
        irradiance *= 2.0 / steps * (pi / 32) * (2 * pi / 64) * static_cast<double>(radiance);
        stage.compare(600, [&](glm::dvec3) { return irradiance; });
    }
    Stage stage;
    const float side = 1e-4f;
    stage.builder.quad({0, 2, 0}, {side, 0, 0}, {0, 0, side},
                       stage.builder.material(emitter(glm::vec3(1e9f))));
    stage.compare(
        4,
        [&](glm::dvec3 p) {
            const glm::dvec3 d = glm::dvec3(5e-5, 2, 5e-5) - p;
            return 1e9 * static_cast<double>(side) * static_cast<double>(side) * d.y * d.y /
                   std::pow(glm::dot(d, d), 2);
        },
        0.005);
}

/// Light through a solid of index one is dimmed by exp(-sigma d) and by nothing else, at every
/// scale of the file (N1).
TEST(DirectLight, AbsorptionFollowsLength)
{
    for (const double scale : {1e-3, 1.0, 1e3}) {
        SceneBuilder b;
        core::Material clear = glossy(glm::vec3(1), 0, 0);
        clear.data.specular = 0;
        clear.data.ior = 1;
        clear.data.transmission = 1;
        clear.data.absorption = glm::vec3(static_cast<float>(1 / scale));
        clear.data.flags = shared::kMaterialVolume;
        const auto s = static_cast<float>(scale);
        b.box(s * glm::vec3(-1, -1, -0.35f), s * glm::vec3(1, 1, 0.35f), b.material(clear), false);
        b.quad(s * glm::vec3(-3, -3, -2), s * glm::vec3(6, 0, 0), s * glm::vec3(0, 6, 0),
               b.material(emitter(glm::vec3(2))));
        b.camera({0, 0, 4 * scale}, {0, 0, 0}, 0.01);
        core::PathParams params = independentParams();
        params.rouletteDepth = 4096;  // no chance in it
        const PictureMean e = estimate(render(b.world(), 8, 8, 4, params));
        EXPECT_NEAR(e.mean, 2 * std::exp(-0.7), 1e-4) << scale;
    }
}

/// A veil of alpha 0.3 before an emitter shows 0.7 of it.
TEST(DirectLight, BlendedVeil)
{
    SceneBuilder b;
    core::Material veil = lambert(glm::vec3(0));
    veil.data.flags |= shared::kMaterialAlphaBlend;
    veil.data.alpha = 0.3f;
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, b.material(veil));
    b.quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.material(emitter(glm::vec3(1))));
    b.camera({0, 0, 5}, {0, 0, 0}, 0.05);
    const PictureMean e = estimate(render(b.world(), 64, 64, 64, independentParams()));
    EXPECT_LT(std::abs(score(e, 0.7)), kScore);
    EXPECT_LT(detectable(e, 0.7), 0.02);
}

/// Pictures of the same veil by other seeds have nothing in common.
TEST(DirectLight, SeedsDecideApartAboutBlending)
{
    SceneBuilder b;
    core::Material veil = lambert(glm::vec3(0));
    veil.data.flags |= shared::kMaterialAlphaBlend;
    veil.data.alpha = 0.5f;
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, b.material(veil));
    b.quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, b.material(emitter(glm::vec3(1))));
    b.camera({0, 0, 5}, {0, 0, 0}, 0.05);
    constexpr uint32_t kSide = 32;
    const auto picture = [&](uint32_t seed) {
        core::PathParams params = independentParams();
        params.seed = seed;
        const core::Image image = render(b.world(), kSide, kSide, 64, params).mean;
        std::vector<float> red;
        for (size_t i = 0; i < image.pixels.size(); i += image.channels)
            red.push_back(image.pixels[i]);
        return red;
    };
    const std::vector<float> first = picture(1);
    for (const uint32_t seed : {2u, 3u, 5u})
        EXPECT_LT(std::abs(correlation(first, picture(seed))), kScore / kSide) << seed;
}

/// A normal map seen from behind: all of the normal is reversed, as glTF demands, so that light
/// from the other side finds the slope it has there.
TEST(DirectLight, NormalMapsFromBehindAreReversed)
{
    const auto seen = [](bool behind, float towards) {
        SceneBuilder b;
        core::Material tilted = lambert(glm::vec3(kStageAlbedo));
        tilted.data.flags |= shared::kMaterialDoubleSided;
        core::Texture map;
        map.width = map.height = 1;
        const auto half = [](float value) { return glm::packHalf1x16(value); };
        map.texels.push_back({half(0.8f), half(0.5f), half(0.9f), half(1)});  // .6, 0, .8
        b.scene.textures.push_back(map);
        core::TextureUse use;
        use.texture = 0;
        use.record.row0 = glm::vec3(1, 0, 0);
        use.record.row1 = glm::vec3(0, 1, 0);
        b.scene.textureUses.push_back(use);
        tilted.textures[shared::kTextureNormal] = 0;
        const int index = b.mesh({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                                 {{0, 1, 2}, {0, 2, 3}}, b.material(tilted));
        core::Mesh& mesh = b.scene.meshes[static_cast<size_t>(index)];
        mesh.hasNormals = mesh.hasTexCoords = mesh.hasTangents = true;
        for (int i = 0; i < 4; ++i)
            mesh.attributes.push_back({shared::packOct(glm::vec3(0, 0, 1)), 0.0f, 0.0f,
                                       shared::packTangent(glm::vec3(1, 0, 0), 1)});
        const double side = behind ? -1 : 1;
        core::PunctualLight sun;
        sun.kind = shared::kEmitterDirectional;
        sun.color = glm::vec3(1);
        // From x = towards and the side of the camera, at 45 degrees.
        b.light(sun, glm::inverse(glm::lookAt(glm::dvec3(double(towards), 0, side), glm::dvec3(0),
                                              glm::dvec3(0, 1, 0))));
        b.camera({0, 0, 3 * side}, {0, 0, 0}, 0.01);
        return estimate(render(b.world(), 4, 4, 4, independentParams(core::Strategy::mis, 1))).mean;
    };
    const double facing = (0.6 + 0.8) / std::sqrt(2.0) * double(kStageAlbedo) / pi,
                 averted = (0.8 - 0.6) / std::sqrt(2.0) * double(kStageAlbedo) / pi;
    EXPECT_NEAR(seen(false, 1), facing, 2e-3);
    EXPECT_NEAR(seen(false, -1), averted, 2e-3);
    EXPECT_NEAR(seen(true, 1), averted, 2e-3);
    EXPECT_NEAR(seen(true, -1), facing, 2e-3);
}

/// What covers a lamp closely is met on the way to it, however far that is.
TEST(DirectLight, ACoverCloseToALampIsSeen)
{
    SceneBuilder b;
    b.quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6}, b.material(lambert(glm::vec3(kStageAlbedo))));
    b.quad({-1, 20, -1}, {2, 0, 0}, {0, 0, 2}, b.material(emitter(glm::vec3(10))));
    b.quad({-1.1f, 19.997f, -1.1f}, {2.2f, 0, 0}, {0, 0, 2.2f}, b.material(lambert(glm::vec3(0))));
    b.camera({0.3, 0.5, 0.4}, {0, 0, 0}, 0.002);
    for (const core::Strategy strategy :
         {core::Strategy::light, core::Strategy::mis, core::Strategy::bsdf})
        EXPECT_EQ(estimate(render(b.world(), 16, 16, 64, independentParams(strategy, 1))).mean, 0);
}

}  // namespace

// Flattening: placement (N1, N2), transforms (N16), degenerate input (N5), animation, cameras,
// lights, features.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "core/base/check.h"
#include "core/scene/animation.h"
#include "core/scene/features.h"
#include "core/trace/accel.h"
#include "core/trace/scene_view.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using namespace tests;
using Path = core::AnimationChannel::Path;

glm::vec3 faceNormal(const core::World& world, size_t triangle)
{
    const core::WorldTriangle& t = world.triangles[triangle];
    return glm::normalize(glm::cross(world.positions[t.v1] - world.positions[t.v0],
                                     world.positions[t.v2] - world.positions[t.v0]));
}

glm::dvec3 toFile(const core::World& world, const glm::vec3& p)
{
    return glm::dvec3(p) / world.placement.scale + world.placement.centre;
}

uint64_t countOf(const core::Warnings& warnings, const std::string& code)
{
    for (const auto& c : warnings.counts) {
        if (c.code == code) return c.count;
    }
    return 0;
}

/// A box of 2 x 3 x 4 whose fronts look outward, as a loose mesh 0, with one node under `matrix`.
SceneBuilder boxUnder(const glm::dmat4& matrix)
{
    SceneBuilder b;
    b.box({-1, -1.5f, -2}, {1, 1.5f, 2}, b.material(lambert(glm::vec3(0.5f))), false);
    b.scene.nodes[0].local = glm::dmat4x3(matrix);
    return b;
}

TEST(Placement, LeavesScenesOfHumanSizeUnscaled)
{
    for (const double factor : {0.5, 1.0, 8.0, 30.0}) {
        const auto world = boxUnder(glm::scale(glm::dmat4(1), glm::dvec3(factor))).world();
        EXPECT_EQ(world->placement.scale, 1.0) << factor;
    }
}

TEST(Placement, BringsEveryScaleIntoRangeByPowersOfTwo)
{
    for (const double factor : {1e-9, 1e-4, 1e-2, 0.1, 1e2, 1e4, 1e6, 1e12}) {
        const auto world = boxUnder(glm::scale(glm::dmat4(1), glm::dvec3(factor))).world();
        int exponent = 0;
        EXPECT_EQ(std::frexp(world->placement.scale, &exponent), 0.5) << factor;
        EXPECT_GE(world->radius, 0.99f) << factor;
        EXPECT_LE(world->radius, 102.0f) << factor;
        const double half = 1.5 * factor;
        EXPECT_NEAR(toFile(*world, world->boundsHigh).y / half, 1.0, 1e-6);
        EXPECT_EQ(world->triangles.size(), 12u);
        EXPECT_EQ(world->warnings.total(), 0u);
    }
}

/// A scene far away is the very same world as one at the origin, while double can hold it.
TEST(Placement, FarScenesAreTheSameWorld)
{
    const auto here = boxUnder(glm::dmat4(1)).world();
    for (const glm::dvec3 shift : {glm::dvec3(100, 0, 0), glm::dvec3(1e4, 0, 0),
                                   glm::dvec3(1e6, 0, 0), glm::dvec3(148376, 1234, -223423)}) {
        const auto there = boxUnder(glm::translate(glm::dmat4(1), shift)).world();
        EXPECT_EQ(there->placement.centre, here->placement.centre + shift);
        ASSERT_EQ(there->positions.size(), here->positions.size());
        for (size_t i = 0; i < here->positions.size(); ++i)
            EXPECT_EQ(there->positions[i], here->positions[i]);
    }
}

TEST(Placement, WarnsWhenSinglePrecisionRunsOut)
{
    SceneBuilder b;
    const int grey = b.material(lambert(glm::vec3(0.5f)));
    b.quad({-40, 0, -40}, {80, 0, 0}, {0, 0, 80}, grey);
    b.quad({30, 1, 30}, {1e-5f, 0, 0}, {0, 0, 1e-5f}, grey);
    EXPECT_EQ(countOf(b.world()->warnings, "PRECISION"), 1u);
}

/// Nobody sees one speck among thousands of triangles, nor that a sliver is a little too wide.
TEST(Placement, SpecksAndSliversAreNoMatterOfPrecision)
{
    const auto warnings = [](int specks, int slivers) {
        SceneBuilder b;
        const int grey = b.material(lambert(glm::vec3(0.5f)));
        for (int i = 0; i < 1200; ++i)
            b.quad({-40, 0.01f * static_cast<float>(i), -40}, {80, 0, 0}, {0, 0, 80}, grey);
        for (int i = 0; i < specks; ++i)
            b.quad({30, 1, 20 + static_cast<float>(i)}, {1e-5f, 0, 0}, {0, 0, 1e-5f}, grey);
        for (int i = 0; i < slivers; ++i)
            b.quad({30, 1, 20 + static_cast<float>(i)}, {1, 0, 0}, {0, 0, 1e-5f}, grey);
        return countOf(b.world()->warnings, "PRECISION");
    };
    EXPECT_EQ(warnings(1, 15), 0u);
    EXPECT_EQ(warnings(2, 0), 1u);
}

TEST(Placement, ScalesWhatHasALength)
{
    SceneBuilder b = boxUnder(glm::scale(glm::dmat4(1), glm::dvec3(1000)));
    core::Material glass = lambert(glm::vec3(1));
    glass.data.absorption = glm::vec3(2, 4, 8);
    b.scene.materials.push_back(glass);
    core::PunctualLight point;
    point.intensity = 100;
    b.light(point, glm::translate(glm::dmat4(1), glm::dvec3(10, 20, 30)));
    core::PunctualLight directional;
    directional.kind = shared::kEmitterDirectional;
    directional.intensity = 7;
    b.light(directional, glm::dmat4(1));
    b.camera({0, 0, 5000}, {0, 0, 0}, 0.5);
    b.scene.cameras[0].apertureRadius = 10;
    b.scene.cameras[0].focusDistance = 4000;
    const auto world = b.world();
    const double s = world->placement.scale;
    ASSERT_LT(s, 1.0);
    EXPECT_FLOAT_EQ(world->materials[1].absorption.y, static_cast<float>(4 / s));
    ASSERT_EQ(world->emitters.size(), 2u);
    EXPECT_FLOAT_EQ(world->emitters[0].radiance.x, static_cast<float>(100 * s * s));
    EXPECT_FLOAT_EQ(world->emitters[1].radiance.x, 7.0f);
    EXPECT_FLOAT_EQ(world->emitters[1].b.z, 1.0f);  // shines along -Z: towards it is +Z
    EXPECT_NEAR(glm::distance(toFile(*world, world->emitters[0].a), glm::dvec3(10, 20, 30)), 0,
                1e-3);
    const core::Camera& camera = world->cameras.at(0);
    EXPECT_NEAR(
        glm::distance(camera.position / s + world->placement.centre, glm::dvec3(0, 0, 5000)), 0,
        1e-9);
    EXPECT_DOUBLE_EQ(camera.apertureRadius, 10 * s);
    EXPECT_DOUBLE_EQ(camera.focusDistance, 4000 * s);
    EXPECT_NE(world->features & shared::kFeatureThinLens, 0u);
    b.scene.cameras[0].orthographic = true;
    EXPECT_EQ(b.world()->features & shared::kFeatureThinLens, 0u) << "parallel rays have no lens";
}

// --- N16

/// Whatever the transform, the fronts of a closed box look outward, seen by Embree from outside and
/// by the normals.
TEST(Transforms, FrontsStayFronts)
{
    glm::dmat4 shear(1);
    shear[1][0] = 0.7;
    glm::dmat4 chain(1);
    for (int i = 0; i < 64; ++i) {
        chain = chain * glm::rotate(glm::dmat4(1), 0.3 + i, glm::normalize(glm::dvec3(i, 1, 3))) *
                glm::scale(glm::dmat4(1), glm::dvec3(i % 2 ? 1.25 : -0.8, 1, 1));
    }
    const glm::dmat4 cases[] = {glm::dmat4(1),
                                glm::scale(glm::dmat4(1), glm::dvec3(-1, 1, 1)),
                                glm::scale(glm::dmat4(1), glm::dvec3(-1, -2, 1)),
                                glm::scale(glm::dmat4(1), glm::dvec3(-1, -2, -3)),
                                glm::scale(glm::dmat4(1), glm::dvec3(1, 1e-6, 1)),
                                shear,
                                shear * glm::scale(glm::dmat4(1), glm::dvec3(1, 1, -1)),
                                chain};
    for (const glm::dmat4& matrix : cases) {
        const auto world = boxUnder(matrix).world();
        ASSERT_EQ(world->triangles.size(), 12u);
        const glm::vec3 middle = 0.5f * (world->boundsLow + world->boundsHigh);
        for (size_t t = 0; t < 12; ++t) {
            const glm::vec3 corner = world->positions[world->triangles[t].v0];
            EXPECT_GT(glm::dot(faceNormal(*world, t), corner - middle), 0.0f) << t;
        }
    }
}

TEST(Transforms, NormalsFollowTheSurface)
{
    for (const glm::dvec3 scale :
         {glm::dvec3(1, 1, 1), glm::dvec3(3, 1, 0.5), glm::dvec3(-3, 1, 0.5)}) {
        SceneBuilder b;
        b.sphere(glm::vec3(0), 1, 4, b.material(lambert(glm::vec3(0.5f))), false, true);
        b.scene.nodes[0].local = glm::dmat4x3(glm::scale(glm::dmat4(1), scale));
        const auto world = b.world();
        ASSERT_NE(world->features & shared::kFeatureShadingNormals, 0u);
        for (size_t t = 0; t < world->triangles.size(); ++t) {
            const core::WorldTriangle& w = world->triangles[t];
            const glm::vec3 n = shared::unpackOct(world->attributes[w.v0].normal);
            // Gradient of the ellipsoid's implicit function.
            const glm::dvec3 p = toFile(*world, world->positions[w.v0]);
            const glm::dvec3 exact = glm::normalize(p / (scale * scale));
            ASSERT_GT(glm::dot(n, glm::vec3(exact)), 0.99999f);
            ASSERT_GT(glm::dot(n, faceNormal(*world, t)), 0.8f);
        }
    }
}

TEST(Transforms, ZeroScaleDropsTheInstance)
{
    SceneBuilder b = boxUnder(glm::dmat4(1));
    b.node(glm::scale(glm::dmat4(1), glm::dvec3(0)), {0});
    b.node(glm::scale(glm::dmat4(1), glm::dvec3(1, 0, 0)), {0});
    const auto world = b.world();
    EXPECT_EQ(world->triangles.size(), 12u);
    EXPECT_EQ(countOf(world->warnings, "NODE_SCALE_ZERO"), 2u);
}

TEST(Transforms, ParentsComeFirst)
{
    SceneBuilder b = boxUnder(glm::dmat4(1));
    b.scene.nodes[0].parent = 0;
    EXPECT_DEATH(b.world(), "parent");
}

TEST(Degenerate, TrianglesAreDroppedAndCounted)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();
    SceneBuilder clean;
    const std::vector<glm::vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    clean.mesh(corners, {{0, 1, 2}, {1, 3, 2}}, clean.material(lambert(glm::vec3(0.5f))));
    SceneBuilder b;
    std::vector<glm::vec3> positions = corners;
    positions.insert(positions.end(),
                     {{nan, 0, 0}, {0, infinity, 0}, {0.5f, 0, 0}, {1e-12f, 0, 0}, {0, 1e-12f, 0}});
    b.mesh(positions, {{0, 1, 2}, {0, 1, 4}, {0, 1, 1}, {0, 6, 1}, {0, 5, 1}, {1, 3, 2}, {0, 7, 8}},
           b.material(lambert(glm::vec3(0.5f))));
    const auto expected = clean.world(), world = b.world();
    EXPECT_EQ(world->warnings.counts.size(), 2u);
    EXPECT_EQ(countOf(world->warnings, "TRIANGLES_DEGENERATE"),
              1u);  // one finding per mesh, its text has the number
    EXPECT_EQ(countOf(world->warnings, "TRIANGLES_NOT_FINITE"), 1u);
    EXPECT_NE(world->warnings.listed[0].message.find("3 triangles"), std::string::npos);
    EXPECT_NE(world->warnings.listed[1].message.find("2 triangles"), std::string::npos);
    EXPECT_EQ(world->placement.centre, expected->placement.centre);
    ASSERT_EQ(world->triangles.size(), 2u);
    for (size_t t = 0; t < 2; ++t) {
        for (const auto vertex :
             {&core::WorldTriangle::v0, &core::WorldTriangle::v1, &core::WorldTriangle::v2}) {
            EXPECT_EQ(world->positions[world->triangles[t].*vertex],
                      expected->positions[expected->triangles[t].*vertex]);
        }
    }
}

// --- animation

core::AnimationChannel channel(core::AnimationChannel::Path path,
                               core::AnimationChannel::Interpolation interpolation,
                               std::vector<glm::vec4> values)
{
    core::AnimationChannel c;
    c.node = 0;
    c.path = path;
    c.interpolation = interpolation;
    c.keys =
        std::make_shared<const core::Keyframes>(core::Keyframes{{1, 3}, std::move(values), {}});
    return c;
}

TEST(Animation, InterpolatesAndHoldsItsEnds)
{
    using Interpolation = core::AnimationChannel::Interpolation;
    const glm::vec4 a(1, 2, 3, 0), b(5, 6, 7, 0);
    const auto at = [](const core::AnimationChannel& c, double time) {
        glm::dvec4 value(-1);
        EXPECT_TRUE(core::evaluateChannel(c, time, value));
        return glm::vec4(value);
    };
    const auto step = channel(Path::translation, Interpolation::step, {a, b});
    EXPECT_EQ(at(step, 2.999), a);
    EXPECT_EQ(at(step, 3), b);
    const auto linear = channel(Path::translation, Interpolation::linear, {a, b});
    EXPECT_EQ(at(linear, 0), a);
    EXPECT_EQ(at(linear, 1.5), 0.75f * a + 0.25f * b);
    EXPECT_EQ(at(linear, 9), b);
    // A cubic spline through a line's points with its slope as tangents is that line.
    const glm::vec4 slope = 0.5f * (b - a);
    const auto line =
        channel(Path::translation, Interpolation::cubicSpline, {slope, a, slope, slope, b, slope});
    EXPECT_LT(glm::distance(at(line, 1.5), 0.75f * a + 0.25f * b), 1e-5f);
    // With flat tangents it is the smooth step 3 t^2 - 2 t^3.
    const glm::vec4 zero(0);
    const auto smooth =
        channel(Path::translation, Interpolation::cubicSpline, {zero, a, zero, zero, b, zero});
    EXPECT_LT(glm::distance(at(smooth, 1.5), glm::mix(a, b, 0.15625f)), 1e-5f);
    glm::dvec4 value;
    EXPECT_FALSE(core::evaluateChannel({}, 0, value));
}

TEST(Animation, RotationsGoTheShortWay)
{
    const float h = std::sqrt(0.5f);
    // 0 and 90 degrees about Y; the second key is the negative quaternion, which is the same
    // rotation.
    const auto c = channel(Path::rotation, core::AnimationChannel::Interpolation::linear,
                           {{0, 0, 0, 1}, {0, -h, 0, -h}});
    glm::dvec4 q;
    ASSERT_TRUE(core::evaluateChannel(c, 2, q));
    EXPECT_NEAR(std::abs(q.y), std::sin(std::numbers::pi / 8), 1e-7);
    EXPECT_NEAR(std::abs(q.w), std::cos(std::numbers::pi / 8), 1e-7);
}

TEST(Animation, MovesTheWorldAndKeepsTheMeshes)
{
    SceneBuilder b = boxUnder(glm::dmat4(1));
    core::Transform turned;
    turned.rotation = {0, 0, 0, 0};  // without length: the identity
    b.scene.nodes[0].local = turned;
    core::Animation animation;
    animation.channels.push_back(channel(core::AnimationChannel::Path::translation,
                                         core::AnimationChannel::Interpolation::linear,
                                         {{0, 0, 0, 0}, {8, 0, 0, 0}}));
    b.scene.animations.push_back(animation);
    EXPECT_EQ(b.world(0)->placement.centre, glm::dvec3(0));
    const auto world = b.world(2);
    EXPECT_EQ(world->placement.centre, glm::dvec3(4, 0, 0));
    EXPECT_EQ(world->scene->meshes[0].positions.size(), 8u);
    EXPECT_TRUE(boxUnder(glm::dmat4(1)).world()->scene->meshes[0].positions.empty());
}

// --- cameras and features

TEST(Cameras, LookAlongMinusZ)
{
    SceneBuilder b = boxUnder(glm::dmat4(1));
    b.camera({0, 0, 10}, {0, 0, 0}, 0.5);
    b.camera({10, 0, 0}, {0, 0, 0}, 0.6);
    // A scaled node does not scale its camera.
    glm::dmat4x3& first = std::get<glm::dmat4x3>(b.scene.nodes[1].local);
    first = first * glm::scale(glm::dmat4(1), glm::dvec3(2, 3, 4));
    const auto world = b.world();
    ASSERT_EQ(world->cameras.size(), 2u);
    EXPECT_LT(glm::distance(world->cameras[0].forward, glm::dvec3(0, 0, -1)), 1e-12);
    EXPECT_LT(glm::distance(world->cameras[0].up, glm::dvec3(0, 1, 0)), 1e-12);
    EXPECT_EQ(world->cameras[0].yfov, 0.5);
    EXPECT_LT(glm::distance(world->cameras[1].forward, glm::dvec3(-1, 0, 0)), 1e-12);
}

/// Without a camera the default one sees all of the scene.
TEST(Cameras, DefaultFramesTheScene)
{
    const auto world = boxUnder(glm::translate(glm::dmat4(1), glm::dvec3(50, 3, 7))).world();
    ASSERT_EQ(world->cameras.size(), 1u);
    const core::Camera& c = world->cameras[0];
    const glm::dvec3 right = glm::cross(c.forward, c.up);
    double largest = 0;
    for (size_t i = 0; i + 1 < world->positions.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(world->positions[i]) - c.position;
        const double z = glm::dot(d, c.forward);
        ASSERT_GT(z, 0.0);
        largest =
            std::max({largest, std::abs(glm::dot(d, c.up)) / z, std::abs(glm::dot(d, right)) / z});
    }
    EXPECT_LT(largest, std::tan(0.5 * c.yfov));
    EXPECT_GT(largest, 0.3 * std::tan(0.5 * c.yfov));
}

TEST(Features, FlatDiffuseSceneNeedsNothing)
{
    SceneBuilder b;
    b.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, b.material(lambert(glm::vec3(0.5f))));
    b.material(glossy(glm::vec3(1), 1, 0));  // not used by any mesh
    const auto world = b.world();
    EXPECT_EQ(world->features, 0u);
    EXPECT_TRUE(world->attributes.empty());
    EXPECT_TRUE(world->extra.empty());
    EXPECT_TRUE(world->triangleEmitter.empty());
    EXPECT_EQ(core::featureList(world->features, true).size(), 0u);
    EXPECT_EQ(core::featureList(world->features, false).size(), core::featureNames().size());
}

TEST(Features, EachBitComesFromItsMaterial)
{
    using namespace shared;
    const auto featuresOf = [](const core::Material& m) {
        SceneBuilder b;
        b.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, b.material(m));
        return b.world()->features;
    };
    EXPECT_EQ(featuresOf(glossy(glm::vec3(1), 0, 0.5f)), kFeatureSpecular);
    EXPECT_EQ(featuresOf(glossy(glm::vec3(1), 1, 0.5f)), kFeatureSpecular | kFeatureMetal);
    EXPECT_EQ(featuresOf(glossy(glm::vec3(1), 1, 0.0f)),
              kFeatureSpecular | kFeatureMetal | kFeatureDelta);
    core::Material m = glossy(glm::vec3(1), 0, 0.0f);
    m.data.transmission = 1;
    EXPECT_EQ(featuresOf(m),
              kFeatureSpecular | kFeatureTransmission | kFeatureDelta | kFeaturePanes);
    m.data.flags = kMaterialVolume;
    m.data.absorption = glm::vec3(0, 1, 0);
    EXPECT_EQ(featuresOf(m),
              kFeatureSpecular | kFeatureTransmission | kFeatureDelta | kFeatureVolume);
    m = lambert(glm::vec3(1));
    m.data.clearcoat = 1;
    m.data.clearcoatRoughness = 0.3f;
    EXPECT_EQ(featuresOf(m), kFeatureSpecular | kFeatureClearcoat);
    EXPECT_EQ(featuresOf(emitter(glm::vec3(1))), kFeatureEmissiveTriangles | kFeatureManyEmitters);
    m = lambert(glm::vec3(1));
    m.data.flags |= kMaterialAlphaBlend;
    EXPECT_EQ(featuresOf(m), 0u);  // alpha is one everywhere
    m.data.alpha = 0.5f;
    EXPECT_EQ(featuresOf(m), kFeatureAlpha);
}

/// Lights without a surface do not shine through smooth solids, which nobody would guess.
TEST(Features, LightThroughSmoothSolidsIsWarnedOf)
{
    core::Material solid = glossy(glm::vec3(1), 0, 0);
    solid.data.transmission = 1;
    solid.data.flags = shared::kMaterialVolume;
    core::Material thin = solid, rough = solid, opaque = solid, metal = solid;
    thin.data.flags = 0;
    rough.data.roughness = 0.5f;
    opaque.data.transmission = 0;
    metal.data.metallic = 1;
    const auto warnings = [](const core::Material& m, bool lamp) {
        SceneBuilder b;
        b.box({-1, -1, -1}, {1, 1, 1}, b.material(m), false);
        b.constantEnvironment(glm::vec3(1));
        core::PunctualLight light;
        light.kind = shared::kEmitterPoint;
        light.color = glm::vec3(1);
        light.intensity = 1;
        if (lamp) b.light(light, glm::dmat4(1));
        return countOf(b.world()->warnings, "LIGHT_THROUGH_SOLIDS");
    };
    EXPECT_EQ(warnings(solid, true), 1u);
    EXPECT_EQ(warnings(solid, false), 0u);
    for (const core::Material& m : {thin, rough, opaque, metal}) EXPECT_EQ(warnings(m, true), 0u);
}

TEST(Features, NamesAndBitsBelongTogether)
{
    for (size_t bit = 0; bit < core::featureNames().size(); ++bit) {
        EXPECT_EQ(core::featureBit(core::featureNames()[bit]), 1u << bit);
    }
    EXPECT_THROW(core::featureBit("shiny"), core::Error);
}

TEST(Features, MoreUsesOfTexturesThanARecordCanNameAreRefused)
{
    SceneBuilder b;
    b.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, b.material(lambert(glm::vec3(0.5f))));
    b.scene.file = "room.glb";
    b.scene.textureUses.resize(65'535);
    EXPECT_TRUE(b.world());
    b.scene.textureUses.resize(65'536);
    try {
        b.world();
        FAIL() << "accepted";
    } catch (const core::Error& error) {
        const std::string what = error.what();
        EXPECT_TRUE(what.starts_with("room.glb: 65536 ")) << what;
        EXPECT_NE(what.find(" — merge materials"), std::string::npos) << what;
    }
}

/// --no-skip stores what the code that is not skipped reads.
TEST(Features, ForcedOnesHaveTheirData)
{
    SceneBuilder b;
    b.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, b.material(lambert(glm::vec3(0.5f))));
    const auto world = core::makeWorld(std::make_shared<core::Scene>(b.scene), 0, 0xffffffffu);
    EXPECT_EQ(world->attributes.size(), world->positions.size());
    EXPECT_EQ(world->extra.size(), world->positions.size());
    EXPECT_EQ(world->triangleEmitter.size(), world->triangles.size());
    EXPECT_EQ(world->attributes[0].normal, shared::kNoNormal);
}

}  // namespace

// M8. The surfaces of virtual lights send what paths would see of them from the other end, wherever
// shading and geometric normals differ.
#include "core/many_lights/light_paths.h"

#include <random>

#include <gtest/gtest.h>

#include "core/methods/method.h"
#include "core/trace/scene_view.h"
#include "tests/support/methods/bsdf_cases.h"
#include "tests/support/scenes/test_scenes.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

/// What light sends is what paths see of it, by the same surface from the other end: wherever
/// shading and geometric normals differ, and through glass.
TEST(VirtualLights, SendWhatPathsSeeOfThem)
{
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const auto draw = [&] {
        return glm::normalize(vec3(normal(random), normal(random), normal(random)));
    };
    BsdfInputs painted = plastic(0.6f), coated = glass(0.3f, Wall::outside);
    painted.baseColor = vec3(0.5f);
    coated.clearcoat = 1;
    coated.clearcoatRoughness = 0.7f;
    size_t bent = 0;
    for (const BsdfInputs& m : {matte(), metal(0.4f), painted, coated, glass(0.3f, Wall::thin),
                                glass(0.3f, Wall::outside), glass(0.3f, Wall::inside)})
        for (int i = 0; i < 3000; ++i) {
            LightSurface light;
            const vec3 n = draw(), out = draw(), incident = draw();
            light.frame = shared::makeFrame(n);
            light.normal = glm::normalize(n + draw() * 0.7f);
            light.incident = shared::toLocal(light.frame, incident);
            if (glm::dot(incident, light.normal) < 0.02f) continue;
            light.bsdf = shared::makeBsdf(m);
            light.lobes = shared::lobesAt(light.bsdf, light.incident);
            const vec3 sent = light.scattered(out) * shared::heldCosine(light.incident);

            const float up = glm::dot(out, light.normal) < 0 ? -1.0f : 1.0f;
            const glm::mat3 frame = shared::makeFrame(shared::ensureVisible(up * n, out));
            const vec3 wo = shared::toLocal(frame, out), wi = shared::toLocal(frame, incident);
            BsdfInputs seen = m;
            if (up < 0 && (m.flags & shared::kMaterialVolume) != 0) seen.backFace = 1 - m.backFace;
            vec3 expected(0);
            if (wi.z * up > 0) expected = evalBsdf(shared::makeBsdf(seen), wo, wi) * std::abs(wi.z);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(sent[c], expected[c], 2e-3f * expected[c] + 1e-4f) << i;
            if (glm::dot(out, n) * up <= 0 && expected.x > 0.01f) ++bent;
        }
    EXPECT_GT(bent, 300u);
}

/// What a path that comes from `out` sees of a place lit from `in`, for the flux that arrives: BSDF
/// times shading's cosine over the geometric one.
vec3 seenByPath(const core::Accel& accel, const shared::SceneView& scene, const vec3& place,
                const vec3& out, const vec3& in, bool& bent)
{
    const core::Ray ray{place + 0.05f * out, shared::kInfinity, -out, 0};
    shared::Hit hit;
    accel.closest({&ray, 1}, &hit);
    shared::SurfacePoint s = shared::makeSurfacePoint(scene, hit, -out);
    const shared::Bsdf bsdf = shared::makeBsdf(shared::evaluateMaterial(scene, s, -out).inputs);
    const vec3 wo = shared::toLocal(s.frame, out), wi = shared::toLocal(s.frame, in);
    bent = wo.z < 0.02f;
    if (!(wi.z > 0)) return vec3(0);
    return shared::evalBsdf(bsdf, wo, wi) * (wi.z / std::abs(glm::dot(in, s.normal)));
}

/// The lights that a narrow spot makes on an octahedron with the normals of a ball, wherever it
/// stands: some are lit from behind the horizons of their shading normals, and some are seen from
/// there.
TEST(VirtualLights, StandForWhatPathsSeeOnRims)
{
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    const auto draw = [&] {
        return glm::normalize(vec3(normal(random), normal(random), normal(random)));
    };
    size_t litBehind = 0, seenBehind = 0;
    for (int i = 0; i < 300; ++i) {
        SceneBuilder b;
        const float metallic = i % 3 == 2 ? 1 : 0;
        const core::Material m =
            i % 3 == 0 ? lambert(vec3(0.9f)) : glossy(vec3(0.9f), metallic, 0.6f);
        b.sphere(vec3(0), 0.8f, 0, b.material(m), false, true);
        core::PunctualLight spot;
        spot.kind = shared::kEmitterSpot;
        spot.innerCone = 0.0999f;
        spot.outerCone = 0.1f;
        const glm::dvec3 from = 3.0f * draw(), at = 0.5f * draw();
        b.light(spot, glm::inverse(glm::lookAt(from, at, glm::dvec3(draw()))));
        b.camera({0, 0, 3}, {0, 0, 0}, 1);
        const auto world = b.world();
        const core::Accel accel(world);
        const shared::SceneView scene = core::sceneView(*world);
        const shared::Emitter e = shared::fetchEmitter(scene, 0);
        constexpr uint32_t kPaths = 50;
        const vec3 flux = e.radiance / (shared::pdfCone(1 + e.offset / e.scale) * kPaths);
        shared::PathSettings settings = core::worldSettings(*world);
        settings.maxDepth = settings.rouletteDepth = 2;
        settings.seed = 5;
        settings.samplerKind = shared::kSamplerIndependent;
        const LightSet set = *traceVirtualLights(accel, settings, 0, kPaths);
        for (const VirtualLight& light : set.lights) {
            const vec3 out = draw(), in = glm::normalize(e.a - light.position);
            const bool inside = shared::spotFalloff(e.scale, e.offset, -glm::dot(in, e.b)) >= 1;
            if (light.kind != LightKind::surface || !inside) continue;
            if (glm::dot(out, light.normal) < 0.02f || glm::dot(in, light.normal) < 0.02f) continue;
            bool bent = false;
            const vec3 expected = flux * seenByPath(accel, scene, light.position, out, in, bent);
            // Diffuse ones whose normals hardly differ send the same to all.
            if (light.detail == shared::kNone && bent) continue;
            vec3 sent = light.intensity;
            if (light.detail != shared::kNone) {
                sent *= set.surfaces[light.detail].scattered(out);
                litBehind += set.surfaces[light.detail].incident.z < 0;
            }
            seenBehind += bent && expected.x > 0 ? 1 : 0;
            EXPECT_NEAR(sent.x, expected.x, 0.01f * expected.x + 2e-4f * flux.x) << i;
        }
    }
    EXPECT_GT(litBehind, 100u);
    EXPECT_GT(seenBehind, 100u);
}

}  // namespace
}  // namespace core::many_lights

// M24. Light that virtual lights cannot bring: the mean over frames is the path tracer's behind
// panes of glass.
#include <gtest/gtest.h>

#include "tests/support/methods/many_lights_means.h"

namespace {

using namespace tests;
using core::LostLight, core::ManyLightsParams;
using glm::vec3;

/// Light of every kind that comes through a roof of glass, and past it, which covers a half; what
/// the glass mirrors of lights without extent goes to where nothing is, as paths cannot find it.
TEST(ManyLightsBehindPanes, AgreeWithThePathTracer)
{
    SceneBuilder b;
    const int walls = b.material(lambert(vec3(0.6f)));
    b.quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, walls);
    b.quad({-1, 0, -1}, {2, 0, 0}, {0, 1, 0}, walls);
    b.quad({-1, 0, 1}, {0, 0, -2}, {0, 1, 0}, walls);
    core::Material pane = lambert(vec3(0.8f, 0.9f, 0.7f));
    pane.data.transmission = pane.data.specular = 1;
    pane.data.roughness = 0;
    pane.data.ior = 1.5f;
    b.quad({-1, 1, -1}, {1.2f, 0, 0}, {0, 0, 2}, b.material(pane));
    b.quad({-0.4f, 1.6f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}, b.material(emitter(vec3(2))));
    core::PunctualLight light;
    light.intensity = 1;
    glm::dmat4 at(1);
    at[3] = {-0.5, 1.5, 0.6, 1};
    b.light(light, at);
    light.kind = shared::kEmitterDirectional;  // which shines along -Z: turned down
    b.light(light, glm::dmat4({1, 0, 0, 0}, {0, 0, -1, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}));
    b.camera({0.6, 0.8, 0.9}, {-0.3, 0.2, -0.5}, 1.2);
    const auto world = b.world();
    const Quarters expected = pathsOf(world, 5, 16);
    ManyLightsParams params = fewClusters();
    params.lights = 1000;
    params.maxDepth = 5;
    for (const float clamp : {0.1f, 1.0f}) {
        params.clamp = clamp;
        expectAgree(manyLights(world, params, 12, 3), expected, 0.08, "panes");
    }
    params.lost = LostLight::dropped;
    const Quarters dropped = manyLights(world, params, 3, 3);
    EXPECT_LT(dropped.means[0].mean(), 0.8 * expected.means[0].mean());
}

}  // namespace

// A camera that comes to rest in the window's own loop: its first sample is the renderer's.
#include "app/bench/guiding/guiding_window.h"

#include <gtest/gtest.h>

#include "app/methods/methods.h"
#include "core/gltf/load.h"
#include "core/methods/method.h"

namespace app::guiding {
namespace {

const std::filesystem::path kBox =
    std::filesystem::path(REKINDLE_SOURCE_DIR) / "assets" / "cornell-diffuse.gltf";
constexpr glm::uvec2 kPicture(40, 32);

TEST(GuidingWindow, TheFirstSampleIsTheRenderers)
{
    const auto world = core::makeWorld(core::loadGltf(kBox));
    const auto way = flight::Flight::around(world, world->cameras.front(), kPicture, 25);
    SceneOptions scene;
    scene.file = kBox;
    const Target cpu{.device = DeviceKind::cpu};
    core::PathParams params;
    params.seed = 7;
    WindowArrivals window(scene, cpu, params, kPicture, flight::lastSeconds(way, 25, 1), {});
    const auto renderer = makeRenderer(core::PathParams::kMethod, cpu);
    renderer->setWorld(world, {});
    for (const uint32_t before : {1u, 16u}) {
        const std::optional<core::Image> shown = window.arrive(params, before);
        ASSERT_TRUE(shown);
        renderer->setView({way.end(), kPicture, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
        EXPECT_EQ(shown->pixels, renderer->read(core::Reading::mean).mean.pixels) << before;
        ++params.seed;  // and other parameters are taken
    }
    std::stop_source stop;
    stop.request_stop();
    WindowArrivals stopped(scene, cpu, params, kPicture, flight::lastSeconds(way, 25, 1),
                           stop.get_token());
    EXPECT_FALSE(stopped.arrive(params, 1));
}

}  // namespace
}  // namespace app::guiding

// Micro-benchmark of what columns bring to the rows of a slice: weights, and light on diffuse and
// glossy surfaces, by the box and its glossy twin in assets/. Time per light and row.
// Run: ninja -C build micro_benchmarks && build/micro_benchmarks --benchmark_filter=Columns
#include <benchmark/benchmark.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "core/gltf/gltf.h"
#include "core/many_lights/light_paths.h"
#include "core/many_lights/slice_rows.h"
#include "core/scene/world.h"
#include "core/trace/scene_view.h"

namespace {

using namespace core::many_lights;

constexpr uint32_t kSize = 256, kRows = 2000, kColumns = 256;

/// The receivers around the middle of a picture, and lights.
struct Room {
    explicit Room(const char* name)
    {
        const std::string file = std::string(REKINDLE_SOURCE_DIR) + "/assets/" + name + ".gltf";
        world = core::makeWorld(core::loadGltf(file));
        accel = std::make_unique<core::Accel>(world);
        ReceiverJob job;
        job.accel = accel.get();
        job.settings = core::worldSettings(*world);
        job.settings.maxDepth = 8;
        job.settings.rouletteDepth = 8;
        job.settings.samplerKind = shared::kSamplerIndependent;
        job.settings.imageWidth = job.settings.imageHeight = kSize;
        job.camera = core::cameraData(world->cameras.at(0), kSize, kSize);
        std::vector<glm::vec3> direct(size_t(kSize) * kSize);
        std::vector<Receiver> receivers;
        traceReceivers(job, {64, 128, 128, 192}, receivers, direct);
        std::vector<uint32_t> chosen(std::min(kRows, uint32_t(receivers.size())));
        std::iota(chosen.begin(), chosen.end(), 0u);
        rows.reset(core::sceneView(*world), receivers, chosen);
        lights = *traceVirtualLights(*accel, job.settings, 0, 4 * kColumns);
        for (uint32_t j = 0; j < kColumns; ++j)
            columns.push_back(columnOf(lights.lights.at(j * 7 % lights.lights.size()), 1, j, 0));
    }

    std::shared_ptr<const core::World> world;
    std::unique_ptr<core::Accel> accel;
    SliceRows rows;
    LightSet lights;
    std::vector<Column> columns;
};

void note(benchmark::State& state, const Room& room)
{
    state.counters["per row"] =
        benchmark::Counter(double(state.iterations()) * double(room.rows.count()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void weighColumns(benchmark::State& state, const char* name)
{
    const Room room(name);
    std::vector<float> weights(room.rows.count());
    size_t j = 0;
    for (auto _ : state) {
        room.rows.weigh(room.columns[j++ % kColumns], {8, 0.01f}, weights);
        benchmark::DoNotOptimize(weights.data());
    }
    note(state, room);
}

void addColumns(benchmark::State& state, const char* name)
{
    Room room(name);
    std::vector<std::vector<float>> weights(kColumns);
    for (size_t j = 0; j < kColumns; ++j) {
        weights[j].resize(room.rows.count());
        room.rows.weigh(room.columns[j], {8, 0.01f}, weights[j]);
    }
    size_t j = 0;
    for (auto _ : state) {
        const size_t k = j++ % kColumns;
        room.rows.add(room.columns[k], room.lights, weights[k]);
    }
    benchmark::DoNotOptimize(room.rows.radiance(0));
    note(state, room);
}

BENCHMARK_CAPTURE(weighColumns, diffuse, "cornell-diffuse");
BENCHMARK_CAPTURE(addColumns, diffuse, "cornell-diffuse");
BENCHMARK_CAPTURE(addColumns, glossy, "cornell-glossy");

}  // namespace

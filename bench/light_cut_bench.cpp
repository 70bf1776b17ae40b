// Micro-benchmark of the cut that every slice takes through the light tree. Goal: .15 ms for 1000
// clusters. Run: ninja -C build micro_benchmarks && build/micro_benchmarks --benchmark_filter=Cut
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/base/pcg32.h"
#include "core/many_lights/light_cut.h"

namespace {

using namespace core::many_lights;
using core::Pcg32;
using glm::vec3;

/// A point of the walls of a room of two metres, and the normal there.
void pointOnWall(Pcg32& random, vec3& position, vec3& normal)
{
    const auto number = [&random] { return static_cast<float>(2 * random() - 1); };
    const auto axis = static_cast<int>(3 * random());
    const float side = random() < 0.5 ? -1.0f : 1.0f;
    position = {number(), number(), number()};
    position[axis] = side;
    normal = vec3(0);
    normal[axis] = -side;
}

std::vector<VirtualLight> lightsOfARoom(size_t count)
{
    Pcg32 random(1);
    std::vector<VirtualLight> lights(count);
    for (VirtualLight& light : lights) {
        pointOnWall(random, light.position, light.normal);
        light.importance = static_cast<float>(std::exp(3 * random()));
        light.intensity = vec3(light.importance);
    }
    return lights;
}

/// Clusters of a slice, of lights in hundreds of thousands.
void lightCut(benchmark::State& state)
{
    const std::vector<VirtualLight> lights = lightsOfARoom(100000);
    const LightTree tree = *makeLightTree(lights, {0.02f, 1});
    const auto clusters = static_cast<uint32_t>(state.range(0));
    Pcg32 random(2);
    std::vector<CutQuery> queries(64);
    for (CutQuery& query : queries) {
        pointOnWall(random, query.position, query.normal);
        query.clampDistance = 0.1f;
    }
    CutMemory memory;
    std::vector<LightCluster> cut;
    size_t i = 0;
    for (auto _ : state) {
        cutLightTree(tree, queries[i++ % queries.size()], clusters, memory, cut);
        benchmark::DoNotOptimize(cut.data());
    }
    double bound = 0;  // of the worst cluster, summed over queries: what another order would lose
    for (const CutQuery& query : queries) {
        cutLightTree(tree, query, clusters, memory, cut);
        float worst = 0;
        for (const LightCluster& c : cut)
            if (!tree.nodes[c.node].isLeaf())
                worst =
                    std::max(worst, clusterBound(tree.nodes[c.node], LightKind::surface, query));
        bound += double(worst);
    }
    state.counters["worst"] = bound;
}
BENCHMARK(lightCut)->Arg(250)->Arg(1000)->Arg(4000)->Unit(benchmark::kMicrosecond);

}  // namespace

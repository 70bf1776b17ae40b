// When to refit, when to look in the cache and when to build. See world_bvh.h.
#include "core/trace/world_bvh.h"

#include <exception>

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/scene/world_parts.h"

namespace core {
namespace {

// Looseness from which on the moving triangles' tree is built anew. Measured on 64 balls of a
// thousand triangles that fly apart: at 1.05 tracing takes 11 % longer than through a new tree, at
// 1.16 22 %, at 1.5 48 %; Sponza turned as a whole: at 1.09 48 %. A new tree over 64 thousand
// triangles takes 35 ms of processor time (a refit 4), a sample of Sponza in 320 x 180 pixels 390:
// from a tenth of that on, it pays with the first sample.
constexpr double kMostLoose = 1.05;

BvhOptions optionsFor(const World& world)
{
    BvhOptions options;
    options.moving = world.movingTriangles;
    options.prototypes = {world.prototypes.data(), world.prototypes.size()};
    options.instances = {world.instances.data(), world.instances.size()};
    if (!options.moving.empty()) {
        options.reachLow = world.reachLow;
        options.reachHigh = world.reachHigh;
    }
    return options;
}

Bvh build(const World& world, const BvhOptions& options,
          const std::function<void(double)>& progress, std::stop_token stop)
{
    std::stop_source ended;
    const std::stop_callback passOn(std::move(stop), [&] { ended.request_stop(); });
    std::exception_ptr thrown;  // by `progress`
    const auto report = [&](double fraction) {
        if (!progress || thrown) return;
        try {
            progress(fraction);
        } catch (...) {
            thrown = std::current_exception();
            ended.request_stop();
        }
    };
    Bvh bvh = buildBvh(world.positions, world.triangles, options, report, ended.get_token());
    if (thrown) std::rethrow_exception(thrown);
    if (ended.stop_requested())
        throw Error("building the hierarchy was cancelled", ExitCode::interrupted);
    return bvh;
}

/// From the cache, where an animation does not make another one for every pose; else built.
Bvh findOrBuild(const World& world, BvhCache* cache, const std::function<void(double)>& progress,
                std::stop_token stop)
{
    const BvhOptions options = optionsFor(world);
    if (cache == nullptr || (world.topology && world.topology->ofLaterPose))
        return build(world, options, progress, std::move(stop));
    if (auto found = cache->find(world.positions, world.triangles, options))
        return *std::move(found);
    const Clock::time_point start = Clock::now();
    Bvh bvh = build(world, options, progress, std::move(stop));
    cache->keep(bvh, secondsSince(start));
    return bvh;
}

std::optional<Bvh> fitted(const Bvh& previous, const World& world)
{
    std::optional<Bvh> bvh = refitBvh(previous, world.positions, world.triangles);
    if (!bvh || looseness(*bvh) <= kMostLoose) return bvh;
    return rebuildMoving(previous, world.positions, world.triangles, optionsFor(world));
}

}  // namespace

std::shared_ptr<const Bvh> bvhOf(const World& world, const std::function<void(double)>& progress,
                                 std::stop_token stop, BvhCache* cache)
{
    const auto make = [&](const std::shared_ptr<const Bvh>& previous) {
        std::optional<Bvh> bvh;
        if (previous) bvh = fitted(*previous, world);
        if (!bvh) bvh = findOrBuild(world, previous ? nullptr : cache, progress, stop);
        return std::make_shared<const Bvh>(*std::move(bvh));
    };
    if (!world.bvh) return make(nullptr);  // made by hand, not by makeWorld
    return world.bvh->get(
        world.positions,
        [&](const auto& positions) { return positions.sharesWith(world.positions); }, make);
}

std::shared_ptr<const Bvh> bvhIfMade(const World& world)
{
    if (!world.bvh) return nullptr;
    return world.bvh->find(
        [&](const auto& positions) { return positions.sharesWith(world.positions); });
}

}  // namespace core

// Memory of the device that sample reuse takes: only what the strategy reads, and no more after a
// change of strategy.
#include "core/methods/reuse_params.h"
#include "tests/support/methods/reuse_flights.h"

namespace {

using namespace tests;

constexpr glm::uvec2 kSize{256, 192};
// Bytes. A store's places, arriving light and connections are made of such words.
constexpr uint64_t kWord = 16;

/// The most memory that the device has held after one picture by each strategy, in turn.
uint64_t peakBytes(std::initializer_list<ReuseParams> strategies)
{
    const auto renderer = app::makeRenderer("reuse", {.device = app::DeviceKind::vulkan});
    const auto world = asset("cornell-diffuse");
    renderer->setWorld(world, {});
    for (const ReuseParams& params : strategies) {
        renderer->setView({world->cameras.at(0), kSize, params}, core::Start::anew);
        renderer->advance({.samples = 1}, {});
    }
    return renderer->stats().peakDeviceBytes;
}

TEST(ReuseMemory, StoresHoldOnlyWhatTheStrategyReads)
{
    const ReuseParams all = with(ReuseStrategy::ra, 1);
    ReuseParams dropping = all;
    dropping.remainder = core::ReuseRemainder::drop;
    const uint64_t stores = 2 * kWord * kSize.x * kSize.y;  // of one word per pixel, both of them
    const uint64_t discard = peakBytes({with(ReuseStrategy::discard, 1)});
    const uint64_t samples = peakBytes({dropping});
    const uint64_t whole = peakBytes({all});
    // Device memory is handed out in pieces: a word per pixel may cost a little more than itself.
    EXPECT_NEAR(double(whole - samples), double(stores), .1 * double(stores));
    const double words = all.records + all.lights;
    EXPECT_NEAR(double(samples - discard), words * double(stores), .05 * words * double(stores));
    // Samples that are evaluated anew hold what arrives at their places, too.
    ReuseParams bounded = all;
    bounded.bias = core::ReuseBias::bounded;
    const double arriving = double(all.records) * double(stores);
    EXPECT_NEAR(double(peakBytes({bounded}) - whole), arriving, .05 * arriving);
    EXPECT_EQ(peakBytes({all, with(ReuseStrategy::naive, 1), all}), whole)
        << "something is kept twice";
}

}  // namespace

// M10. Slices of receivers: what every partition must hold, and the sets that are hard to split.
#include "core/many_lights/slices.h"

#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace core::many_lights {
namespace {

using glm::vec3;

std::vector<Receiver> receiversOnSphere(size_t count, uint32_t seed)
{
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    std::vector<Receiver> receivers(count);
    for (Receiver& r : receivers) {
        r.normal = glm::normalize(vec3(normal(random), normal(random), normal(random)));
        r.position = 3.0f * r.normal;
    }
    return receivers;
}

/// Every receiver in one slice, in its order, and no slice of another size than allowed.
void expectPartition(const Slices& slices, size_t count, const SliceSettings& settings)
{
    std::vector<uint32_t> sorted = slices.order;
    std::sort(sorted.begin(), sorted.end());
    std::vector<uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(sorted, all);
    uint32_t at = 0;
    for (const core::IndexRange& range : slices.ranges) {
        EXPECT_EQ(range.begin, at);
        at = range.end;
        EXPECT_LE(range.size(), 2 * settings.threshold);
        EXPECT_GE(range.size(), std::min<size_t>(settings.smallest, count));
        EXPECT_TRUE(
            std::is_sorted(slices.order.begin() + range.begin, slices.order.begin() + range.end));
    }
    EXPECT_EQ(at, count);
}

TEST(Slices, HoldEveryReceiverOnce)
{
    for (const size_t count : {size_t(1), size_t(9), size_t(1000), size_t(30000)}) {
        const std::vector<Receiver> receivers = receiversOnSphere(count, 1);
        for (const SliceSettings& settings :
             {SliceSettings{0.05f, 1000, 10}, SliceSettings{2.0f, 100, 10},
              SliceSettings{0.05f, 20, 10}, SliceSettings{0.05f, 1, 1}})
            expectPartition(makeSlices(receivers, settings), count, settings);
    }
}

TEST(Slices, ThereAreNoneWithoutReceivers)
{
    EXPECT_TRUE(makeSlices({}, {}).ranges.empty());
}

/// Nothing to split by: halves, by order.
TEST(Slices, CoincidentReceiversAreHalved)
{
    std::vector<Receiver> receivers(10000);
    const SliceSettings settings{1, 1000, 10};
    const Slices slices = makeSlices(receivers, settings);
    expectPartition(slices, receivers.size(), settings);
    EXPECT_EQ(slices.ranges.size(), 8u);
}

/// One receiver far away from all others must not have a slice of its own, nor keep them together.
TEST(Slices, OutliersDoNotMakeSlicesOfTheirOwn)
{
    std::vector<Receiver> receivers = receiversOnSphere(5000, 2);
    receivers[1234].position = vec3(1e6f, 0, 0);
    const SliceSettings settings{0.05f, 500, 10};
    expectPartition(makeSlices(receivers, settings), receivers.size(), settings);
}

/// The two sides of a thin wall face different lights.
TEST(Slices, OppositeNormalsAreParted)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform;
    std::vector<Receiver> receivers(4000);
    for (size_t i = 0; i < receivers.size(); ++i) {
        receivers[i].position = {uniform(random), uniform(random), 0};
        receivers[i].normal = {0, 0, i % 2 == 0 ? 1 : -1};
    }
    const Slices slices = makeSlices(receivers, {1, 1000, 10});
    for (const core::IndexRange& range : slices.ranges)
        for (uint32_t i = range.begin; i < range.end; ++i)
            ASSERT_EQ(slices.order[i] % 2, slices.order[range.begin] % 2);
}

}  // namespace
}  // namespace core::many_lights

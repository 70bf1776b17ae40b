// Loops over all cores: every item once, stopping, exceptions, and results that do not depend on
// the thread count.
#include "core/base/parallel.h"

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

namespace core {
namespace {

TEST(Parallel, everyItemOnceInFixedBlocks)
{
    for (const size_t count : {size_t(0), size_t(1), size_t(64), size_t(1000), size_t(1001)})
        for (const size_t grain : {size_t(0), size_t(1), size_t(7), size_t(5000)}) {
            std::vector<std::atomic<int>> visits(count);
            std::atomic<bool> aligned{true};
            const size_t step = std::max<size_t>(grain, 1);
            const bool complete = parallelFor(count, grain, [&](size_t begin, size_t end) {
                if (begin % step != 0 || end != std::min(count, begin + step)) aligned = false;
                for (size_t i = begin; i < end; ++i) ++visits[i];
            });
            EXPECT_TRUE(complete);
            EXPECT_TRUE(aligned);
            for (const std::atomic<int>& v : visits) ASSERT_EQ(v, 1);
        }
}

TEST(Parallel, tilesCoverTheImage)
{
    std::vector<std::atomic<int>> visits(101 * 67);
    parallelTiles(101, 67, 16, [&](const Tile& tile) {
        EXPECT_LE(tile.x1 - tile.x0, 16u);
        EXPECT_LE(tile.y1 - tile.y0, 16u);
        for (uint32_t y = tile.y0; y < tile.y1; ++y)
            for (uint32_t x = tile.x0; x < tile.x1; ++x) ++visits[y * 101 + x];
    });
    for (const std::atomic<int>& v : visits) ASSERT_EQ(v, 1);
    EXPECT_TRUE(parallelTiles(0, 10, 16, [](const Tile&) { FAIL(); }));
}

TEST(Parallel, stopLeavesOutBlocks)
{
    std::stop_source source;
    std::atomic<size_t> done{0};
    const auto body = [&](size_t, size_t) {
        if (++done == 10) source.request_stop();
    };
    EXPECT_FALSE(parallelFor(100000, 1, body, source.get_token()));
    EXPECT_LT(done, 1000u);
    done = 100;
    EXPECT_FALSE(parallelFor(1000, 1, body, source.get_token()));
    EXPECT_EQ(done, 100u);
}

TEST(Parallel, exceptionsReachTheCaller)
{
    const auto body = [](size_t begin, size_t) {
        if (begin == 57) throw std::runtime_error("57");
    };
    EXPECT_THROW(parallelFor(1000, 1, body), std::runtime_error);
}

TEST(Parallel, sumsAreTheSameForAnyNumberOfThreads)
{
    const auto term = [](size_t i) { return std::sin(double(i)) * 1e3 / (1.0 + double(i)); };
    const double all = parallelSum(300000, term);
    for (const size_t threads : {size_t(1), size_t(2)}) {
        const ThreadLimit limit(threads);
        EXPECT_LE(threadCount(), threads);
        for (int repeat = 0; repeat < 5; ++repeat) EXPECT_EQ(parallelSum(300000, term), all);
    }
    long double serial = 0;
    for (size_t i = 0; i < 300000; ++i) serial += static_cast<long double>(term(i));
    EXPECT_NEAR(all, double(serial), 1e-9);
    EXPECT_EQ(parallelSum(0, term), 0.0);
}

}  // namespace
}  // namespace core

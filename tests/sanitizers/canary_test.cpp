// Faults planted for the sanitizers: tests/sanitizers/run.sh runs each alone and demands that it be
// reported. Disabled everywhere else.
#include <atomic>
#include <chrono>
#include <limits>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/parallel.h"

namespace {

/// What the optimiser must not see through.
template <class T> T opaque(T value)
{
    volatile T hidden = value;
    return hidden;
}

TEST(DISABLED_Canary, WritesPastItsArray)
{
    std::vector<int> numbers(8);
    int* data = opaque(numbers.data());
    data[opaque(8)] = 1;
    EXPECT_EQ(data[0], 0);
}

TEST(DISABLED_Canary, LosesMemory)
{
    for (int i = 0; i < 10; ++i) opaque(new int[100]);
}

TEST(DISABLED_Canary, OverflowsASignedNumber)
{
    EXPECT_LT(opaque(std::numeric_limits<int>::max()) + opaque(1), 0);
}

TEST(DISABLED_Canary, RacesForANumber)
{
    int number = 0;
    int* shared = opaque(&number);
    std::jthread other([shared] {
        for (int i = 0; i < 100000; ++i) *shared = *shared + opaque(1);
    });
    for (int i = 0; i < 100000; ++i) *shared = *shared + opaque(1);
    other.join();
    EXPECT_GT(number, 0);
}

/// One body of a loop writes and ends; then another thread begins a body that writes. What
/// core/base/handoff.h tells of TBB must not order the two.
TEST(DISABLED_Canary, RacesInALoop)
{
    int number = 0;
    int* shared = opaque(&number);
    static thread_local int bodies = 0;  // of this thread; its address stands for the thread
    // Relaxed, so that they order nothing either.
    constexpr auto kRelaxed = std::memory_order_relaxed;
    std::atomic<const int*> writer{nullptr};
    std::atomic<bool> written{false}, again{false};
    const auto wait = [](const std::atomic<bool>& flag) {
        for (int i = 0; i < 20000 && !flag.load(kRelaxed); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    core::parallelFor(64, 1, [&](size_t, size_t) {
        const bool isFirst = bodies++ == 0;
        const int* who = nullptr;
        if (writer.compare_exchange_strong(who, &bodies, kRelaxed)) {
            *shared = *shared + opaque(1);
            written.store(true, kRelaxed);
        } else if (who == &bodies) {
            wait(again);  // leaves other bodies to other threads
        } else if (isFirst) {
            wait(written);  // it may have begun before the writer's ended, the next one does not
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        } else {
            *shared = *shared + opaque(1);
            again.store(true, kRelaxed);
        }
    });
    EXPECT_GT(number, 0);
}

}  // namespace

// Faults planted for the sanitizers: tests/sanitizers/run.sh runs each alone and demands that it be
// reported. Disabled everywhere else.
#include <limits>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

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

}  // namespace

// Speeds that are measured in turns: what counts, and how often.
#include "app/bench/throughput/bench_figures.h"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "app/bench/bench_clock.h"

namespace {

/// Work that takes `first` seconds when kernels are compiled, and `later` ever after.
app::BenchFigure figure(const char* name, double first, double later)
{
    int runs = 0;
    return {name, 10, [=]() mutable { return runs++ == 0 ? first : later; }, {}};
}

TEST(BenchFigures, CompilingDecidesNothing)
{
    std::vector<app::BenchFigure> figures{figure("a", 100, 0.01), figure("b", 0.5, 0.02)};
    std::vector<double> progress;
    app::measureInTurns(figures, 0.5, [&](double done) { progress.push_back(done); });
    for (const app::BenchFigure& f : figures) EXPECT_EQ(f.seconds.size(), 25u) << f.name;
    EXPECT_NEAR(figures[0].rate(), 1000, 1e-9);
    EXPECT_NEAR(figures[1].rate(), 500, 1e-9);
    ASSERT_EQ(progress.size(), 25u);
    EXPECT_EQ(progress.back(), 1);
}

TEST(BenchFigures, RoundsAreNeitherFewNorEndless)
{
    const auto rounds = [](double seconds, double each) {
        std::vector<app::BenchFigure> figures{figure("a", 0, each)};
        app::measureInTurns(figures, seconds, [](double) {});
        return figures[0].seconds.size();
    };
    EXPECT_EQ(rounds(1, 10), 5u);
    EXPECT_EQ(rounds(1, 0), 101u);
}

/// What a graphics card does first after a pause is not counted.
TEST(BenchFigures, ACardIsMeasuredAwake)
{
    using namespace std::chrono;
    int runs = 0;
    const auto start = steady_clock::now();
    const double seconds = app::onCard([&runs] {
        std::this_thread::sleep_for(milliseconds(1));
        return ++runs;
    });
    EXPECT_GE(steady_clock::now() - start, milliseconds(100));
    EXPECT_GT(runs, 1);
    EXPECT_EQ(seconds, runs) << "not those of the last run";
}

}  // namespace

// See bench_figures.h.
#include "app/bench/throughput/bench_figures.h"

#include <algorithm>

#include "app/bench/bench_clock.h"

namespace app {

static constexpr int kMinRounds = 5, kMaxRounds = 101;

double BenchFigure::rate() const
{
    return amount / median(seconds);
}

void measureInTurns(std::vector<BenchFigure>& figures, double seconds,
                    const std::function<void(double)>& progress)
{
    for (BenchFigure& f : figures) f.run();
    double slowest = 0;
    int rounds = kMinRounds;
    for (int round = 0; round < rounds; ++round) {
        for (BenchFigure& f : figures) {
            f.seconds.push_back(f.run());
            if (round == 0) slowest = std::max(slowest, f.seconds.back());
        }
        if (round == 0)
            rounds = std::clamp(static_cast<int>(seconds / std::max(slowest, 1e-4)), kMinRounds,
                                kMaxRounds);
        progress((round + 1.0) / rounds);
    }
}

}  // namespace app

// Speeds that are measured in turns: interleaved rounds and medians, so that other work on the
// machine affects all alike.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace app {

/// One figure: `run` does `amount` of work and returns the seconds.
struct BenchFigure {
    std::string name;
    double amount = 0;
    std::function<double()> run;
    std::vector<double> seconds;  // of the rounds that count

    /// Work per second, of the median round.
    double rate() const;
};

/// Runs all figures in turns, at least five times and until the slowest had `seconds`, but no more
/// than 101 times. What comes before, in which drivers compile, does not count. `progress` gets the
/// fraction done.
void measureInTurns(std::vector<BenchFigure>& figures, double seconds,
                    const std::function<void(double)>& progress);

}  // namespace app

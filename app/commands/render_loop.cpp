// The loop of every headless render. See render_loop.h.
#include "app/commands/render_loop.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/image/metrics.h"

namespace app {

namespace {

constexpr double kLoopStepSeconds = 0.25, kGrowthBetweenMeasurements = 1.2;
constexpr uint64_t kMaxStep = 4096;

/// Samples of the next step: what takes a quarter of a second at the speed so far, never more than
/// double the last.
uint64_t nextStep(uint64_t last, uint64_t samples, double seconds)
{
    if (samples == 0) return 1;
    const double perSample = seconds / static_cast<double>(samples);
    const double wanted =
        perSample > 0 ? kLoopStepSeconds / perSample : static_cast<double>(kMaxStep);
    return std::clamp<uint64_t>(static_cast<uint64_t>(std::min(wanted, 1e9)), 1,
                                std::min(2 * last, kMaxStep));
}

/// Fewer samples where a whole step would run past the time limit.
uint64_t withinTime(uint64_t step, uint64_t samples, double seconds, double limit)
{
    if (limit <= 0 || samples == 0 || seconds <= 0) return step;
    const double left = (limit - seconds) / (seconds / static_cast<double>(samples));
    return std::clamp<uint64_t>(static_cast<uint64_t>(std::max(left, 1.0)), 1, step);
}

/// How many more samples a budget allows, from what the last step has taken.
class BudgetWatch {
public:
    BudgetWatch(const core::Renderer& renderer, const Goal& goal)
        : renderer_(renderer), goal_(goal), raysBefore_(rays())
    {}

    void step(uint64_t samples, double seconds)
    {
        if (samples == 0) return;
        const double now = rays();
        secondsEach_ = seconds / static_cast<double>(samples);
        raysEach_ = (now - raysBefore_ - raysSpent_) / static_cast<double>(samples);
        raysSpent_ = now - raysBefore_;
        secondsSpent_ += seconds;
    }

    uint64_t samplesLeft() const
    {
        return std::min(whole(goal_.budgetSeconds, secondsSpent_, secondsEach_),
                        whole(goal_.budgetRays, raysSpent_, raysEach_));
    }

private:
    static constexpr uint64_t kMany = 1ull << 40;

    double rays() const
    {
        return goal_.budgetRays > 0 ? static_cast<double>(renderer_.stats().rays) : 0;
    }

    static uint64_t whole(double budget, double spent, double each)
    {
        if (budget <= 0 || each <= 0) return kMany;
        return static_cast<uint64_t>(std::clamp((budget - spent) / each, 0.0, 1e12));
    }

    const core::Renderer& renderer_;
    const Goal& goal_;
    double raysBefore_, raysSpent_ = 0, secondsSpent_ = 0, raysEach_ = 0, secondsEach_ = 0;
};

/// Measures what the goal asks for. Too few samples have no noise yet.
void measure(core::Renderer& renderer, const Goal& goal, Outcome& outcome)
{
    const core::Estimate estimate =
        renderer.read(goal.noise > 0 ? core::Reading::everything : core::Reading::mean);
    if (goal.rmse > 0) outcome.rmse = core::imageErrors(estimate.mean, *goal.reference).rmse;
    if (goal.noise > 0 && estimate.samples >= core::kFewestForNoise)
        outcome.noise = core::noiseOf(estimate.variance);
}

}  // namespace

Outcome renderUntil(core::Renderer& renderer, const Goal& goal, const std::stop_token& stop,
                    const LoopProgress& progress)
{
    CHECK(goal.spp >= 1);
    Outcome outcome;
    BudgetWatch budget(renderer, goal);
    uint64_t step = 1, first = renderer.progress().samples;
    double nextMeasurement = 1;
    const bool measures = goal.rmse > 0 || goal.noise > 0;
    outcome.samples = first;
    while (true) {
        if (stop.stop_requested()) {
            // What is kept has whole samples, so that it can be rendered again.
            if (outcome.samples > 0) renderer.advance({.samples = 0}, {});
            outcome.samples = renderer.progress().samples;
            outcome.ended = Ended::stopped;
            return outcome;
        }
        const uint64_t left = goal.spp - std::min(goal.spp, outcome.samples);
        if (left > 0) {
            step = nextStep(step, outcome.samples - first, outcome.seconds);
            // A step longer than the samples between two measurements would overshoot a target.
            if (measures) step = std::min(step, std::max<uint64_t>(1, outcome.samples / 5));
            const uint64_t taken = std::min(
                {left, withinTime(step, outcome.samples - first, outcome.seconds, goal.seconds),
                 std::max<uint64_t>(budget.samplesLeft(), 1)});
            const core::Clock::time_point start = core::Clock::now();
            const uint64_t had = outcome.samples;
            renderer.advance({.samples = static_cast<uint32_t>(taken)}, stop);
            const double seconds = core::secondsSince(start);
            outcome.seconds += seconds;
            outcome.samples = renderer.progress().samples;
            budget.step(outcome.samples - had, seconds);
        }
        const bool enough = outcome.samples >= goal.spp;
        const bool late = goal.seconds > 0 && outcome.seconds >= goal.seconds;
        if (measures && outcome.samples > 0 &&
            (enough || late || static_cast<double>(outcome.samples) >= nextMeasurement)) {
            measure(renderer, goal, outcome);
            nextMeasurement =
                std::ceil(static_cast<double>(outcome.samples) * kGrowthBetweenMeasurements);
        }
        if (progress) progress(outcome);
        if ((outcome.rmse && *outcome.rmse <= goal.rmse) ||
            (outcome.noise && *outcome.noise <= goal.noise))
            outcome.ended = Ended::target;
        else if (enough)
            outcome.ended = Ended::spp;
        else if (late && outcome.samples > 0)
            outcome.ended = Ended::time;
        else if (outcome.samples > first && budget.samplesLeft() == 0)
            outcome.ended = Ended::budget;
        else
            continue;
        return outcome;
    }
}

}  // namespace app

// When the render loop stops, on a renderer whose samples and speed are known.
#include "app/commands/render_loop.h"

#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/image/metrics.h"
#include "tests/support/methods/fake_estimate.h"

namespace {

/// Every sample of every pixel adds (-1)^k: after n samples the mean is 0 or 1/n, so the error
/// against black is known.
class FakeRenderer : public core::Renderer {
public:
    std::chrono::microseconds perSample{0};
    std::stop_source* stopAfterStep = nullptr;
    std::vector<uint32_t> steps;

    void setWorld(std::shared_ptr<const core::World>, const core::Progress&) override {}
    void setView(const core::View&, core::Start) override {}
    void setPace(const core::Pace&) override {}
    void advance(const core::Budget& budget, std::stop_token) override
    {
        steps.push_back(budget.samples);
        std::this_thread::sleep_for(perSample * budget.samples);
        samples_ += budget.samples;
        if (stopAfterStep) stopAfterStep->request_stop();
    }
    core::RenderProgress progress() const override { return {samples_, samples_, 0}; }
    core::Estimate read(core::Reading) override
    {
        const double n = double(std::max<uint64_t>(samples_, 1));
        const double mean = samples_ % 2 ? 1 / n : 0;
        return tests::flatEstimate({2, 2}, static_cast<float>(mean),
                                   static_cast<float>(samples_ > 1 ? 1 / (n - 1) : 0), samples_);
    }
    core::Aovs aovs() override { return {}; }
    core::RenderStats stats() const override
    {
        core::RenderStats stats;
        stats.rays = kRays * samples_;
        return stats;
    }
    static constexpr uint64_t kRays = 7;  // of a sample

private:
    uint64_t samples_ = 0;
};

TEST(RenderLoop, TakesExactlyTheSamplesAskedFor)
{
    for (const uint64_t spp : {1ull, 2ull, 3ull, 64ull, 1000ull, 100000ull}) {
        FakeRenderer renderer;
        const app::Outcome outcome = app::renderUntil(renderer, {.spp = spp}, {}, {});
        EXPECT_EQ(outcome.samples, spp);
        EXPECT_EQ(renderer.progress().samples, spp);
        EXPECT_EQ(outcome.ended, app::Ended::spp);
        EXPECT_EQ(renderer.steps.front(), 1u) << "the first step finds out how long a sample takes";
    }
}

TEST(RenderLoop, StepsStayShort)
{
    FakeRenderer renderer;
    renderer.perSample = std::chrono::milliseconds(20);
    app::renderUntil(renderer, {.spp = 40}, {}, {});
    for (const uint32_t step : renderer.steps) EXPECT_LE(step, 13u);  // a quarter of a second
    EXPECT_LE(renderer.steps.size(), 12u);
}

TEST(RenderLoop, StopsInTimeButNotBeforeTheFirstSample)
{
    FakeRenderer renderer;
    renderer.perSample = std::chrono::milliseconds(5);
    const app::Outcome outcome =
        app::renderUntil(renderer, {.spp = 1000000, .seconds = 0.2}, {}, {});
    EXPECT_EQ(outcome.ended, app::Ended::time);
    EXPECT_GE(outcome.seconds, 0.2);
    EXPECT_GE(outcome.samples, 2u);
    EXPECT_LE(outcome.samples, 41u);

    FakeRenderer slow;
    slow.perSample = std::chrono::milliseconds(10);
    EXPECT_EQ(app::renderUntil(slow, {.spp = 100, .seconds = 1e-9}, {}, {}).samples, 1u);
}

TEST(RenderLoop, ABudgetOfRaysIsSpentAndNoMore)
{
    for (const auto& [rays, samples] :
         {std::pair{50.0, 7u}, {49.0, 7u}, {48.9, 6u}, {7e5, 100000u}, {3.0, 1u}}) {
        FakeRenderer renderer;
        const app::Outcome outcome =
            app::renderUntil(renderer, {.spp = 1u << 30u, .budgetRays = rays}, {}, {});
        EXPECT_EQ(outcome.ended, app::Ended::budget);
        EXPECT_EQ(outcome.samples, samples) << rays;
    }
    FakeRenderer renderer;
    EXPECT_EQ(app::renderUntil(renderer, {.spp = 4, .budgetRays = 1e6}, {}, {}).ended,
              app::Ended::spp);
}

TEST(RenderLoop, ABudgetOfTimeIsNotRunPast)
{
    FakeRenderer renderer;
    renderer.perSample = std::chrono::milliseconds(10);
    const app::Outcome outcome =
        app::renderUntil(renderer, {.spp = 1u << 30u, .budgetSeconds = 0.105}, {}, {});
    EXPECT_EQ(outcome.ended, app::Ended::budget);
    EXPECT_GE(outcome.samples, 1u);
    EXPECT_LE(outcome.samples, 10u) << "eleven take longer than that";

    FakeRenderer slow;
    slow.perSample = std::chrono::milliseconds(20);
    EXPECT_EQ(app::renderUntil(slow, {.spp = 9, .budgetSeconds = 1e-9}, {}, {}).samples, 1u);
}

TEST(RenderLoop, StopsAtTheTarget)
{
    FakeRenderer renderer;
    const core::Image black(2, 2, 3);
    const app::Outcome outcome =
        app::renderUntil(renderer, {.spp = 1000000, .reference = &black, .rmse = 0.01}, {}, {});
    EXPECT_EQ(outcome.ended, app::Ended::target);
    ASSERT_TRUE(outcome.rmse.has_value());
    EXPECT_LE(*outcome.rmse, 0.01);
    EXPECT_LE(outcome.samples, 125u);  // the error is 1/n or 0: reached at 100 at the latest

    // A target that cannot be reached: the other limit ends it, with the error measured at the very
    // end.
    FakeRenderer other;
    core::Image three(2, 2, 3);
    for (float& value : three.pixels) value = 3;
    const app::Outcome missed =
        app::renderUntil(other, {.spp = 99, .reference = &three, .rmse = 0.01}, {}, {});
    EXPECT_EQ(missed.ended, app::Ended::spp);
    EXPECT_NEAR(missed.rmse.value_or(0), 3 - 1.0 / 99, 1e-6);
}

TEST(RenderLoop, StopsWhenTheNoiseIsSmall)
{
    FakeRenderer renderer;  // whose noise is 1 / sqrt(n - 1)
    const app::Outcome outcome = app::renderUntil(renderer, {.spp = 1000000, .noise = 0.1}, {}, {});
    EXPECT_EQ(outcome.ended, app::Ended::target);
    EXPECT_LE(outcome.noise.value_or(1), 0.1);
    EXPECT_GE(outcome.samples, 101u);
    EXPECT_LE(outcome.samples, 130u);
    EXPECT_FALSE(outcome.rmse);

    // So few samples that agree by chance say nothing.
    FakeRenderer few;
    EXPECT_EQ(app::renderUntil(few, {.spp = 1000, .noise = 10}, {}, {}).samples,
              core::kFewestForNoise);
    FakeRenderer fewer;
    const app::Outcome missed = app::renderUntil(fewer, {.spp = 7, .noise = 10}, {}, {});
    EXPECT_EQ(missed.ended, app::Ended::spp);
    EXPECT_FALSE(missed.noise);
}

TEST(RenderLoop, StopsWhenAsked)
{
    std::stop_source source;
    FakeRenderer renderer;
    renderer.stopAfterStep = &source;
    const app::Outcome outcome = app::renderUntil(renderer, {.spp = 1000}, source.get_token(), {});
    EXPECT_EQ(outcome.ended, app::Ended::stopped);
    EXPECT_EQ(outcome.samples, 1u);
    EXPECT_EQ(renderer.steps, (std::vector<uint32_t>{1, 0})) << "what was cut is completed";
}

TEST(RenderLoop, SeesAStopThatComesWithTheLastSample)
{
    std::stop_source source;
    FakeRenderer renderer;
    renderer.stopAfterStep = &source;
    // All samples are there: nothing was lost, so this is a finished render.
    EXPECT_EQ(app::renderUntil(renderer, {.spp = 1}, source.get_token(), {}).ended,
              app::Ended::spp);
}

}  // namespace

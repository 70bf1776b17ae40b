// What the render command does when the renderer behind it fails: partial results are saved and
// reported.
#include "app/commands/render_command.h"
#include "app/commands/render_words.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "core/base/check.h"
#include "core/image/image.h"
#include "tests/support/methods/fake_estimate.h"

namespace {

/// Constant radiance 2, 0.3 seconds a sample, and a device that is lost after `life` samples.
class MortalRenderer : public core::Renderer {
public:
    explicit MortalRenderer(uint64_t life) : life_(life) {}
    void setWorld(std::shared_ptr<const core::World>, const core::Progress&) override {}
    void setView(const core::View& view, core::Start) override
    {
        size_ = view.size;
        samples_ = 0;
    }
    void setPace(const core::Pace&) override {}
    void advance(const core::Budget& budget, std::stop_token) override
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(300) * budget.samples);
        samples_ += budget.samples;
        if (samples_ > life_) throw core::Error("the device was lost", core::ExitCode::deviceLost);
    }
    core::RenderProgress progress() const override { return {samples_, samples_, 0}; }
    core::Estimate read(core::Reading) override
    {
        EXPECT_LE(samples_, life_) << "a lost device was read";
        core::Estimate estimate = tests::flatEstimate(size_, 2, 0, samples_);
        estimate.counters.nan = 3;
        return estimate;
    }
    core::Aovs aovs() override { return {}; }
    core::RenderStats stats() const override { return {}; }

private:
    uint64_t life_, samples_ = 0;
    glm::uvec2 size_{0};
};

class RenderCommand : public testing::Test {
protected:
    RenderCommand()
    {
        folder_ = std::filesystem::path(testing::TempDir()) /
                  ("rekindle-command-" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
        options_.scene.file =
            std::filesystem::path(REKINDLE_SOURCE_DIR) / "assets" / "cornell-diffuse.gltf";
        options_.output = folder_ / "x.exr";
        options_.stats = folder_ / "stats.json";
        options_.size = glm::uvec2(6, 5);
        options_.quiet = true;
    }
    ~RenderCommand() override { std::filesystem::remove_all(folder_); }

    int render(uint64_t life)
    {
        return app::renderWith(options_, {},
                               [life] { return std::make_unique<MortalRenderer>(life); });
    }

    app::RenderOptions options_;
    std::filesystem::path folder_;
};

TEST_F(RenderCommand, ALostDeviceLeavesWhatWasCopied)
{
    options_.spp = 100;
    try {
        render(5);
        FAIL() << "the loss went unnoticed";
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::deviceLost);
        EXPECT_NE(std::string(error.what()).find("x.exr"), std::string::npos) << error.what();
    }
    const core::ImageFile file = core::readExr(options_.output);
    EXPECT_EQ(file.metadata.at("ended"), "device lost");
    EXPECT_GE(std::stoi(file.metadata.at("spp")), 1);
    EXPECT_LE(std::stoi(file.metadata.at("spp")), 5);
    for (const float value : file.layer("").pixels) EXPECT_EQ(value, 2.0f);
}

TEST_F(RenderCommand, ALossBeforeAnythingWasCopiedLeavesNothing)
{
    options_.spp = 100;
    EXPECT_THROW(render(0), core::Error);
    EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

TEST_F(RenderCommand, DroppedSamplesAreCounted)
{
    options_.spp = 2;
    EXPECT_EQ(render(100), 0);
    std::ifstream stream(options_.stats);
    const nlohmann::json stats = nlohmann::json::parse(stream);
    EXPECT_EQ(stats.at("counters").at("nan"), 3);
    EXPECT_EQ(stats.at("spp"), 2);
}

/// Builds a hierarchy in a second for each world, and takes another to read each view.
class SteadyRenderer : public MortalRenderer {
public:
    SteadyRenderer() : MortalRenderer(1000) {}
    void setWorld(std::shared_ptr<const core::World>, const core::Progress&) override
    {
        build_ = 1;
    }
    void setView(const core::View& view, core::Start start) override
    {
        MortalRenderer::setView(view, start);
        readback_ = 0;
    }
    void advance(const core::Budget& budget, std::stop_token stop) override
    {
        MortalRenderer::advance(budget, stop);
        readback_ = 1;
    }
    core::RenderStats stats() const override
    {
        core::RenderStats stats;
        stats.buildSeconds = build_;
        stats.readbackSeconds = readback_;
        return stats;
    }

private:
    double build_ = 0, readback_ = 0;
};

TEST_F(RenderCommand, SecondsAreThoseOfAllFrames)
{
    options_.scene.file = std::filesystem::path(REKINDLE_SOURCE_DIR) / "assets" / "animated.gltf";
    options_.output = folder_ / "x-%02d.exr";
    options_.frames = {{2, 4}};
    options_.spp = 1;
    EXPECT_EQ(app::renderWith(options_, {}, [] { return std::make_unique<SteadyRenderer>(); }), 0);
    std::ifstream stream(options_.stats);
    const nlohmann::json seconds = nlohmann::json::parse(stream).at("seconds");
    EXPECT_EQ(seconds.at("build"), 4) << "of the scene as it is loaded, and of three poses";
    EXPECT_EQ(seconds.at("readback"), 3);
}

TEST_F(RenderCommand, AnInterruptionTellsWhatIsSaved)
{
    app::RenderReport report;
    report.options = &options_;
    const auto addFrame = [&](uint32_t index, uint64_t spp) {
        report.frames.emplace_back();
        report.frames.back().index = index;
        report.frames.back().spp = spp;
    };
    addFrame(7, 0);
    EXPECT_EQ(app::interruptedText(report), "interrupted before the first sample: nothing saved");
    report.frames.back().spp = 2;
    EXPECT_EQ(app::interruptedText(report), "interrupted: what was rendered so far is saved");
    options_.frames = {{7, 20}};
    addFrame(8, 0);
    EXPECT_EQ(app::interruptedText(report), "interrupted: 1 whole frame is saved");
    report.frames.back().spp = 3;
    addFrame(9, 1);
    EXPECT_EQ(app::interruptedText(report),
              "interrupted: 2 whole frames are saved, and what was rendered of frame 9");
}

/// Of several frames the worst is told, not the last.
TEST_F(RenderCommand, AMissedTargetIsThatOfTheWorstFrame)
{
    app::RenderReport report;
    report.options = &options_;
    options_.untilNoise = 0.02;
    app::MissedFrames missed;
    const auto frame = [&](uint32_t index, std::optional<double> noise, bool misses) {
        report.frames.emplace_back();
        report.frames.back().index = index;
        report.noise = noise;
        if (misses) missed.add(report);
    };
    frame(7, 0.031, true);
    EXPECT_EQ(app::missedText(report, missed), "noise 0.031 is above --until-noise 0.02");
    options_.frames = {{7, 20}};
    frame(8, 0.04, true);
    frame(9, 0.03, true);
    frame(10, 0.01, false);
    EXPECT_EQ(app::missedText(report, missed),
              "frame 8: noise 0.04 is above --until-noise 0.02; 3 of 4 frames missed it");
    frame(11, {}, true);
    frame(12, 0.5, true);
    EXPECT_EQ(app::missedText(report, missed),
              "frame 11: there are too few samples to tell their noise; 5 of 6 frames missed it");
    app::MissedFrames one;
    options_.frames.reset();
    options_.untilRmse = 0.1;
    report.rmse = 0.3;
    one.add(report);
    EXPECT_EQ(app::missedText(report, one),
              "RMSE 0.3 is above --until-rmse 0.1, noise 0.5 is above --until-noise 0.02");
}

/// Two rays for each path, ten in the third world that it is given; a sample takes no time.
class DearRenderer : public core::Renderer {
public:
    explicit DearRenderer(int& worlds) : worlds_(worlds) {}
    void setWorld(std::shared_ptr<const core::World>, const core::Progress&) override { ++worlds_; }
    void setView(const core::View& view, core::Start) override
    {
        size_ = view.size;
        samples_ = 0;
    }
    void setPace(const core::Pace&) override {}
    void advance(const core::Budget& budget, std::stop_token) override
    {
        samples_ += budget.samples;
        const uint64_t paths = budget.samples * size_.x * size_.y;
        stats_.paths += paths;
        stats_.rays += (worlds_ == 3 ? 10 : 2) * paths;
    }
    core::RenderProgress progress() const override { return {samples_, samples_, 0}; }
    core::Estimate read(core::Reading) override
    {
        return tests::flatEstimate(size_, 1, 0, samples_);
    }
    core::Aovs aovs() override { return {}; }
    core::RenderStats stats() const override { return stats_; }

private:
    int& worlds_;
    uint64_t samples_ = 0;
    core::RenderStats stats_;
    glm::uvec2 size_{0};
};

/// Of an animation as of a path: the last instant is the most expensive, and decides.
TEST_F(RenderCommand, ABudgetOfRaysHoldsAtEveryInstant)
{
    options_.scene.file = std::filesystem::path(REKINDLE_SOURCE_DIR) / "assets" / "animated.gltf";
    options_.output = folder_ / "x-%02d.exr";
    options_.frames = {{0, 4}};
    options_.budgetRays = 4;
    options_.params = core::ReuseParams();
    int worlds = 0;
    EXPECT_EQ(
        app::renderWith(options_, {}, [&worlds] { return std::make_unique<DearRenderer>(worlds); }),
        0);
    EXPECT_EQ(worlds, 8) << "as it is loaded, two that are tried, five frames";
    std::ifstream stream(options_.stats);
    const nlohmann::json stats = nlohmann::json::parse(stream);
    EXPECT_NEAR(stats.at("params").at("rays").get<double>(), (4 - 1) / 9.0, 1e-6);
}

TEST_F(RenderCommand, TheReferenceIsMeasuredWithoutATarget)
{
    core::Image reference(6, 5, 3);
    for (float& value : reference.pixels) value = 1.5f;
    options_.reference = folder_ / "ref.exr";
    core::writeExr(options_.reference, {{{"", reference}}, {}});
    options_.spp = 1;
    EXPECT_EQ(render(100), 0);
    std::ifstream stream(options_.stats);
    EXPECT_NEAR(nlohmann::json::parse(stream).at("rmse").get<double>(), 0.5, 1e-6);
}

}  // namespace

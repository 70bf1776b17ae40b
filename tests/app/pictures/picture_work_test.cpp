// Pictures in motion with the detail of those before, by the renderer that they are for: the
// picture at rest, then small ones of a camera that has begun to move.
#include "app/pictures/picture_work.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/methods/many_lights_params.h"
#include "core/methods/path_params.h"
#include "core/methods/reuse_params.h"
#include "tests/support/methods/reuse_flights.h"

namespace {

using namespace tests;

class PictureWorkInMotion : public testing::TestWithParam<app::DeviceKind> {
protected:
    void SetUp() override
    {
        world_ = asset("cornell-diffuse");
        request_.world = world_;
        request_.size = {64, 64};
        request_.movingShows = app::Moving::filled;
        request_.movingDetail = true;
        setMethod(core::ReuseParams{});
    }

    void setMethod(const core::AnyParams& params)
    {
        request_.params.method = params;
        renderer_ = &sharedRenderer(std::string(params.id()), GetParam());
        renderer_->setWorld(world_, {});
    }

    std::shared_ptr<const app::Picture> show(app::Coarse coarse, core::Start start, double degrees,
                                             uint64_t samples)
    {
        // One that has seen nothing yet chooses a quarter of the sides.
        app::ResolutionControl control;
        request_.camera = swung(*world_, degrees);
        request_.params.sppLimit = samples;
        request_.moving = coarse == app::Coarse::moving;
        work_.begin(*renderer_, request_, coarse, start, control, 1);
        while (work_.samples() < samples) work_.advance(*renderer_, request_, control, {});
        return work_.make(*renderer_, request_);
    }

    /// The first picture of a flight after so many samples at rest.
    std::shared_ptr<const app::Picture> firstInMotion(uint64_t samplesAtRest)
    {
        work_.discard();
        show(app::Coarse::no, core::Start::anew, 0, samplesAtRest);
        return show(app::Coarse::moving, core::Start::moved, 0.5, 1);
    }

    double error(const app::Picture& picture) const
    {
        double sum = 0;
        for (size_t i = 0; i < truth_.pixels.size(); ++i)
            sum += std::pow(std::min(double(picture.mean.pixels.at(i)), 1.0) -
                                std::min(double(truth_.pixels[i]), 1.0),
                            2);
        return sum / double(truth_.pixels.size());
    }

    std::shared_ptr<const core::World> world_;
    core::Renderer* renderer_ = nullptr;
    app::RenderRequest request_;
    app::PictureWork work_;
    core::Image truth_;
};

TEST_P(PictureWorkInMotion, AFlightBeginsWithThePictureAtRest)
{
    truth_ = show(app::Coarse::no, core::Start::anew, 0.5, 512)->mean;
    const auto few = firstInMotion(4), many = firstInMotion(64);
    for (const auto& picture : {few, many}) {
        EXPECT_TRUE(picture->preview);
        EXPECT_EQ(app::sampledSize(*picture), glm::uvec2(16));
        ASSERT_EQ(glm::uvec2(picture->mean.width, picture->mean.height), request_.size);
        EXPECT_EQ(picture->camera, request_.camera) << "without its shift";
    }
    EXPECT_LT(error(*many), 0.15 * error(*few)) << "the lamp is smaller than a pixel";

    request_.movingDetail = false;
    const auto alone = firstInMotion(64);
    EXPECT_EQ(alone->mean.width, 16u);
    EXPECT_EQ(alone->sampledGuide, nullptr);
}

TEST_P(PictureWorkInMotion, WhatIsSeenAtRestAgainHasNothingOfTheSmallPictures)
{
    firstInMotion(64);
    const auto rested = show(app::Coarse::no, core::Start::moved, 0.5, 1);
    EXPECT_FALSE(rested->preview);
    EXPECT_EQ(rested->sampledGuide, nullptr);
    EXPECT_EQ(rested->mean.pixels, renderer_->read(core::Reading::mean).mean.pixels);
    EXPECT_EQ(rested->camera.shift, glm::dvec2(0));
}

TEST_P(PictureWorkInMotion, PathsAloneHaveNone)
{
    setMethod(core::PathParams{});
    const auto picture = firstInMotion(64);
    EXPECT_EQ(picture->mean.width, 16u);
    EXPECT_EQ(picture->sampledGuide, nullptr);
    EXPECT_NE(picture->guide, nullptr);
}

/// Few pixels are averaged over surfaces while the camera moves and when it rests, for who does not
/// want paths alone, and where pictures have no detail of their own.
TEST_P(PictureWorkInMotion, CoarsePicturesShowLightByItsSurfaces)
{
    const auto asItHasCome = [&](const app::Picture& picture) {
        return picture.mean.pixels == renderer_->read(core::Reading::mean).mean.pixels;
    };
    setMethod(core::PathParams{});
    for (const app::Coarse coarse : {app::Coarse::moving, app::Coarse::first, app::Coarse::half}) {
        request_.movingShows = app::Moving::filled;
        const auto filled = show(coarse, core::Start::anew, 0.5, 1);
        EXPECT_FALSE(asItHasCome(*filled));
        EXPECT_NE(filled->guide, nullptr);
        EXPECT_TRUE(filled->preview);
        request_.movingShows = app::Moving::path;
        EXPECT_TRUE(asItHasCome(*show(coarse, core::Start::anew, 0.5, 1)));
    }
    request_.movingShows = app::Moving::filled;
    EXPECT_TRUE(asItHasCome(*show(app::Coarse::no, core::Start::anew, 0.5, 1)));
    setMethod(core::ReuseParams{});
    EXPECT_TRUE(asItHasCome(*show(app::Coarse::first, core::Start::anew, 0.5, 1)));
}

/// Over those around, but for who wants paths alone; the light of many lights has no grain.
TEST_P(PictureWorkInMotion, KeptSamplesAreAveragedOverAFewPixels)
{
    truth_ = show(app::Coarse::no, core::Start::anew, 0.5, 512)->mean;
    const auto first = [&](app::Moving shows) {
        request_.movingShows = shows;
        return firstInMotion(4);
    };
    const auto kept = first(app::Moving::path), averaged = first(app::Moving::filled);
    EXPECT_NE(averaged->mean.pixels, kept->mean.pixels);
    EXPECT_LT(error(*averaged), error(*kept));
    core::ManyLightsParams lights;
    lights.lights = 200;
    lights.clusters = 20;
    setMethod(lights);
    EXPECT_EQ(first(app::Moving::filled)->mean.pixels, first(app::Moving::path)->mean.pixels);
}

INSTANTIATE_TEST_SUITE_P(Device, PictureWorkInMotion,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace

// Small pictures in motion, by the renderers that they are for: light on finer surfaces, averaged.
#include "app/pictures/picture_work.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/image/display.h"
#include "core/methods/guided_params.h"
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
        request_.targetFrameSeconds = 10;  // surfaces are as fine as can be on any machine
        setMethod(core::ReuseParams{});
    }

    void setMethod(const core::AnyParams& params)
    {
        request_.params.method = params;
        renderer_ = &sharedRenderer(std::string(params.id()), GetParam());
        renderer_->setWorld(world_, {});
    }

    std::shared_ptr<const app::Picture> show(app::Coarse coarse, core::Start start, double degrees,
                                             uint64_t samples, const core::Camera* ahead = nullptr)
    {
        // Ones that have seen nothing yet choose a quarter of the sides, and surfaces as fine as
        // can be.
        if (start == core::Start::anew) work_.discard();
        app::ResolutionControl control;
        request_.camera = swung(*world_, degrees);
        request_.params.sppLimit = samples;
        request_.moving = coarse == app::Coarse::moving;
        work_.begin(*renderer_, request_, coarse, start, control, 1);
        while (work_.samples() < samples) work_.advance(*renderer_, request_, control, {});
        return work_.make(*renderer_, request_, ahead != nullptr ? *ahead : request_.camera);
    }

    /// The first picture of a flight after so many samples at rest.
    std::shared_ptr<const app::Picture> firstInMotion(uint64_t samplesAtRest)
    {
        work_.discard();
        show(app::Coarse::no, core::Start::anew, 0, samplesAtRest);
        return show(app::Coarse::moving, core::Start::moved, 0.5, 1);
    }

    double error(const core::Image& image) const
    {
        double sum = 0;
        for (size_t i = 0; i < truth_.pixels.size(); ++i)
            sum += std::pow(std::min(double(image.pixels.at(i)), 1.0) -
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

TEST_P(PictureWorkInMotion, SurfacesAreFinerThanTheirLight)
{
    for (const core::AnyParams& method :
         {core::AnyParams(core::ReuseParams{}), core::AnyParams(core::PathParams{})}) {
        setMethod(method);
        truth_ = show(app::Coarse::no, core::Start::anew, 0.5, 512)->mean;
        request_.movingDetail = true;
        const auto fine = firstInMotion(4);
        EXPECT_TRUE(fine->preview);
        EXPECT_EQ(app::sampledSize(*fine), glm::uvec2(16));
        ASSERT_EQ(glm::uvec2(fine->mean.width, fine->mean.height), request_.size);
        EXPECT_EQ(fine->guide->width, 64u);
        request_.movingDetail = false;
        const auto coarse = firstInMotion(4);
        EXPECT_EQ(coarse->mean.width, 16u);
        EXPECT_EQ(app::sampledSize(*coarse), glm::uvec2(16));
        EXPECT_LT(error(fine->mean), 0.6 * error(core::stretched(coarse->mean, request_.size)))
            << method.id();
    }
}

/// What the camera sees by now has the light that it saw before.
TEST_P(PictureWorkInMotion, TheyAreThoseOfACameraThatHasMovedOn)
{
    for (const core::AnyParams& method :
         {core::AnyParams(core::ReuseParams{}), core::AnyParams(core::PathParams{})}) {
        setMethod(method);
        // Many samples: noise would hide where edges are.
        truth_ = show(app::Coarse::moving, core::Start::anew, 6, 64)->mean;
        const core::Camera there = request_.camera;
        const auto stays = show(app::Coarse::moving, core::Start::anew, 0.5, 64);
        const double late = error(stays->mean);
        const auto picture = show(app::Coarse::moving, core::Start::anew, 0.5, 64, &there);
        EXPECT_EQ(picture->camera, there);
        EXPECT_LT(error(picture->mean), 0.1 * late) << method.id();
        // Made again it is the same.
        const auto again = work_.make(*renderer_, request_, request_.camera);
        EXPECT_EQ(again->camera, there);
        EXPECT_EQ(again->mean.pixels, picture->mean.pixels);
    }
}

/// While the light of a picture is on its way, that of the one before is shown on them.
TEST_P(PictureWorkInMotion, TheyNeedNotWaitForLight)
{
    truth_ = show(app::Coarse::moving, core::Start::anew, 6, 64)->mean;
    const core::Camera there = request_.camera;
    const auto before = show(app::Coarse::moving, core::Start::moved, 0.5, 64);
    const double late = error(before->mean);
    app::ResolutionControl control;
    const auto next = [&](core::Start start, bool slow = true) {
        control.forget();
        if (slow) control.observe(1, 1, 1, true);
        request_.camera = swung(*world_, 1);
        work_.begin(*renderer_, request_, app::Coarse::moving, start, control, 1);
    };
    next(core::Start::moved);
    const auto ahead = work_.makeAhead(*renderer_, request_, there);
    ASSERT_NE(ahead, nullptr);
    EXPECT_EQ(ahead->camera, there);
    EXPECT_TRUE(ahead->preview);
    EXPECT_EQ(app::sampledSize(*ahead), app::sampledSize(*before));
    EXPECT_EQ(ahead->guide->width, 64u);
    EXPECT_LT(error(ahead->mean), 0.1 * late);
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, there), nullptr) << "it is on show";

    // With the light of its own, and no way back.
    while (work_.samples() == 0) work_.advance(*renderer_, request_, control, {});
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, request_.camera), nullptr);
    const auto picture = work_.make(*renderer_, request_, request_.camera);
    EXPECT_EQ(picture->camera, there);
    EXPECT_NE(picture->mean.pixels, ahead->mean.pixels);

    request_.wantAovs = true;
    next(core::Start::moved);
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, request_.camera), nullptr);
    request_.wantAovs = false;
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, there), nullptr) << "still on show";
    EXPECT_NE(work_.makeAhead(*renderer_, request_, request_.camera), nullptr);
    next(core::Start::moved, false);
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, there), nullptr) << "light is quick";
    next(core::Start::anew);
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, there), nullptr) << "nothing of before counts";
    show(app::Coarse::no, core::Start::moved, 0.5, 1);
    next(core::Start::moved);
    EXPECT_EQ(work_.makeAhead(*renderer_, request_, there), nullptr) << "after a rest";
}

/// Before a full picture, too, whether or not its light is averaged.
TEST_P(PictureWorkInMotion, SoAreThoseOfAFirstLook)
{
    core::ManyLightsParams lights;
    lights.lights = 200;
    lights.clusters = 20;
    for (const core::AnyParams& method :
         {core::AnyParams(core::GuidedParams{}), core::AnyParams(lights)}) {
        setMethod(method);
        const auto first = show(app::Coarse::first, core::Start::anew, 0, 1);
        EXPECT_EQ(app::sampledSize(*first), glm::uvec2(16)) << method.id();
        EXPECT_EQ(first->mean.width, 64u) << method.id();
        EXPECT_EQ(show(app::Coarse::half, core::Start::anew, 0, 1)->mean.width, 32u);
    }
}

/// A picture may be made more than once.
TEST_P(PictureWorkInMotion, MadeAgainItIsTheSame)
{
    request_.wantAovs = true;
    const std::shared_ptr<const app::Picture> once = firstInMotion(4),
                                              again =
                                                  work_.make(*renderer_, request_, request_.camera);
    EXPECT_EQ(again->mean.pixels, once->mean.pixels);
    EXPECT_EQ(again->guide->pixels, once->guide->pixels);
    EXPECT_EQ(again->aovs->depth.width, 64u) << "views of first hits are as fine";
    EXPECT_EQ(again->sampled, once->sampled);
}

TEST_P(PictureWorkInMotion, WhatIsSeenAtRestAgainHasNothingOfTheSmallPictures)
{
    firstInMotion(64);
    const auto rested = show(app::Coarse::no, core::Start::moved, 0.5, 1);
    EXPECT_FALSE(rested->preview);
    EXPECT_EQ(app::sampledSize(*rested), request_.size);
    EXPECT_EQ(rested->mean.pixels, renderer_->read(core::Reading::mean).mean.pixels);
}

/// Few pixels are averaged over surfaces while the camera moves and when it rests, for who does not
/// want paths alone, and where each pixel has light of its own.
TEST_P(PictureWorkInMotion, CoarsePicturesShowLightByItsSurfaces)
{
    const auto asItHasCome = [&](const app::Picture& picture) {
        return picture.mean.pixels == renderer_->read(core::Reading::mean).mean.pixels;
    };
    request_.movingDetail = false;
    core::ManyLightsParams lights;
    lights.lights = 200;
    lights.clusters = 20;
    for (const core::AnyParams& method :
         {core::AnyParams(core::PathParams{}), core::AnyParams(core::ReuseParams{}),
          core::AnyParams(lights)}) {
        setMethod(method);
        const bool shares = method.id() == "manylights";
        for (const app::Coarse coarse : {app::Coarse::moving, app::Coarse::first}) {
            request_.movingShows = app::Moving::filled;
            const auto filled = show(coarse, core::Start::anew, 0.5, 1);
            EXPECT_TRUE(shares || !asItHasCome(*filled)) << method.id();
            EXPECT_TRUE(shares || filled->guide != nullptr) << method.id();
            EXPECT_TRUE(filled->preview);
            request_.movingShows = app::Moving::path;
            EXPECT_TRUE(asItHasCome(*show(coarse, core::Start::anew, 0.5, 1)));
        }
        request_.movingShows = app::Moving::filled;
        EXPECT_TRUE(asItHasCome(*show(app::Coarse::no, core::Start::anew, 0.5, 1)));
    }
}

INSTANTIATE_TEST_SUITE_P(Device, PictureWorkInMotion,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace

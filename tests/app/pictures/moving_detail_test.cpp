// Which pictures of a moving camera get detail, of which size, and what of before counts.
#include "app/pictures/moving_detail.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "app/pictures/preview_shading.h"
#include "core/image/display.h"
#include "core/methods/first_hits.h"
#include "core/methods/many_lights_params.h"
#include "core/methods/path_params.h"
#include "core/methods/reuse_params.h"

namespace {

constexpr glm::uvec2 kWindow{64, 48}, kInMotion{16, 12};

/// First hits of a wall two metres away that faces the camera.
core::Aovs wall(glm::uvec2 size)
{
    core::Aovs aovs = core::emptyAovs(size.x, size.y);
    for (uint32_t y = 0; y < size.y; ++y)
        for (uint32_t x = 0; x < size.x; ++x) {
            *aovs.depth.at(x, y) = 2;
            aovs.normal.at(x, y)[2] = 1;
            aovs.ids.at(x, y)[1] = 0;
        }
    return aovs;
}

/// Every other pixel is `radiance`, the others nothing.
core::Image stripes(glm::uvec2 size, float radiance)
{
    core::Image image(size.x, size.y, 3);
    for (size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = (i / 3 % size.x) % 2 == 0 ? radiance : 0;
    return image;
}

app::RenderRequest request()
{
    app::RenderRequest r;
    r.world = std::make_shared<core::World>();
    r.size = kWindow;
    r.params.method = core::ReuseParams{};
    r.moving = r.movingDetail = true;
    r.movingShows = app::Moving::filled;
    return r;
}

/// The picture that is made of stripes.
app::Picture made(app::MovingDetail& detail, const app::RenderRequest& r, float radiance,
                  bool follows = true, glm::uvec2 small = kInMotion)
{
    EXPECT_TRUE(detail.next(r, small, follows));
    app::Picture picture;
    picture.mean = stripes(small, radiance);
    const core::Aovs aovs = wall(small);
    picture.guide = std::make_shared<core::Image>(app::surfaceGuide(aovs));
    detail.addTo(picture, aovs);
    return picture;
}

/// The same by one that has seen nothing before, at the same points.
app::Picture alone(const app::RenderRequest& r, float radiance, int before)
{
    app::MovingDetail detail;
    for (int i = 0; i < before; ++i) detail.next(r, kInMotion, false);
    return made(detail, r, radiance, false);
}

TEST(MovingDetail, IsForPicturesWhosePointsAreKnown)
{
    app::RenderRequest r = request();
    EXPECT_TRUE(app::MovingDetail::wanted(r));
    r.params.method = core::ManyLightsParams{};
    EXPECT_TRUE(app::MovingDetail::wanted(r));
    r.params.method = core::PathParams{};
    EXPECT_FALSE(app::MovingDetail::wanted(r)) << "each sample lies anywhere in its pixel";
    core::ReuseParams reuse;
    reuse.jitter = core::PixelJitter::always;
    r.params.method = reuse;
    EXPECT_FALSE(app::MovingDetail::wanted(r));
    reuse = {};
    reuse.reuse = core::ReuseStrategy::discard;
    r.params.method = reuse;
    EXPECT_FALSE(app::MovingDetail::wanted(r)) << "nothing is to be kept";
    r = request();
    r.movingDetail = false;
    EXPECT_FALSE(app::MovingDetail::wanted(r));
    r = request();
    r.movingShows = app::Moving::shaded;
    EXPECT_FALSE(app::MovingDetail::wanted(r));
    r = request();
    r.camera.orthographic = true;
    EXPECT_FALSE(app::MovingDetail::wanted(r));
}

TEST(MovingDetail, PicturesAreOfTheFullSize)
{
    app::MovingDetail detail;
    const app::Picture picture = made(detail, request(), 1);
    EXPECT_EQ(glm::uvec2(picture.mean.width, picture.mean.height), kWindow);
    EXPECT_EQ(app::sampledSize(picture), kInMotion);
    EXPECT_EQ(picture.guide, nullptr) << "each pixel of the window has one of the picture";
}

TEST(MovingDetail, WhatWouldTakeTooLongIsMadeSmaller)
{
    app::MovingDetail detail;
    app::RenderRequest r = request();
    r.size = {4096, 3072};
    r.targetFrameSeconds = 0.01;
    const app::Picture picture = made(detail, r, 1);
    EXPECT_LT(picture.mean.width, 1024u);
    EXPECT_GT(picture.mean.width, 64u);
    EXPECT_NEAR(picture.mean.width * 3.0 / 4, picture.mean.height, 1);
    ASSERT_NE(picture.guide, nullptr) << "shown smooth";
    // One light is shown in one colour, to the border.
    core::Image one(picture.mean.width, picture.mean.height, 3);
    std::ranges::fill(one.pixels, 0.25f);
    shared::DisplaySettings settings{};
    settings.width = 640;
    settings.height = 480;
    settings.show = shared::kShowPreview;
    const std::vector<uint8_t> shown = core::displayImage(&one, picture.guide.get(), settings);
    for (size_t i = 0; i < shown.size(); ++i) ASSERT_EQ(shown[i], shown[i % 4]) << i;
    EXPECT_EQ(picture.guide->width, picture.mean.width);
    EXPECT_EQ(app::sampledSize(picture), kInMotion);
    EXPECT_GT(detail.seconds(), 0);
    EXPECT_FALSE(detail.next(r, {1024, 768}, true)) << "as many pixels are there already";
    EXPECT_EQ(detail.seconds(), 0);
    EXPECT_TRUE(detail.next(r, kInMotion, true));
}

TEST(MovingDetail, PicturesComeAtLeastThirtyTimesASecond)
{
    app::RenderRequest r = request();
    for (const double asked : {0.01, 1.0 / 30, 0.1, 1.0}) {
        r.targetFrameSeconds = asked;
        EXPECT_EQ(app::MovingDetail::secondsOfPicture(r), std::min(asked, 1.0 / 30));
    }
}

TEST(MovingDetail, WhatWasSeenCountsInTheSameSceneAlone)
{
    const app::RenderRequest r = request();
    const auto afterDark = [&](const app::RenderRequest& next, bool follows) {
        app::MovingDetail detail;
        for (int i = 0; i < 5; ++i) made(detail, r, 0);
        return made(detail, next, 1, follows).mean.pixels;
    };
    const std::vector<float> fresh = alone(r, 1, 5).mean.pixels;
    EXPECT_NE(afterDark(r, true), fresh) << "it is darker than the stripes alone";
    EXPECT_EQ(afterDark(r, false), fresh);
    app::RenderRequest other = r;
    other.world = std::make_shared<core::World>();
    EXPECT_EQ(afterDark(other, true), fresh);
    core::ReuseParams params;
    params.maxDepth = 2;
    other = r;
    other.params.method = params;
    EXPECT_EQ(afterDark(other, true), fresh);
    other = r;
    other.size = kWindow + 2u;
    EXPECT_NE(afterDark(other, true).size(), fresh.size());
}

TEST(MovingDetail, AFlightBeginsWithThePictureAtRest)
{
    const app::RenderRequest r = request();
    auto rest = std::make_shared<app::Picture>();
    rest->mean = stripes(kWindow, 1);
    rest->world = r.world;
    rest->params = r.params;
    rest->camera = r.camera;
    const auto hits = std::make_shared<const core::Aovs>(wall(kWindow));
    const auto contrast = [](const core::Image& image) {
        double sum = 0;
        for (size_t i = 3; i < image.pixels.size(); i += 3)
            sum += std::abs(static_cast<double>(image.pixels[i] - image.pixels[i - 3]));
        return sum / static_cast<double>(image.pixels.size() / 3);
    };
    app::MovingDetail detail;
    detail.settle(rest, hits);
    EXPECT_GT(contrast(made(detail, r, 1).mean), 0.3);
    EXPECT_LT(contrast(alone(r, 1, 0).mean), 0.2);
    app::RenderRequest other = r;
    other.world = std::make_shared<core::World>();
    detail.settle(rest, hits);
    EXPECT_LT(contrast(made(detail, other, 1).mean), 0.2) << "it shows another scene";
}

}  // namespace

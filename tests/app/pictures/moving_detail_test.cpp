// Which small pictures have surfaces finer than their light, and how fine these are.
#include "app/pictures/moving_detail.h"

#include <gtest/gtest.h>

#include "core/methods/ao_params.h"
#include "core/methods/first_hits.h"
#include "core/methods/many_lights_params.h"
#include "core/methods/path_params.h"
#include "core/methods/reuse_params.h"
#include "tests/support/session/desk.h"

namespace {

app::RenderRequest request()
{
    app::RenderRequest r;
    r.params.method = core::ReuseParams{};
    r.moving = r.movingDetail = true;
    r.movingShows = app::Moving::filled;
    return r;
}

TEST(MovingDetail, IsForLightOnSurfacesUnlessPathsAreWantedAsTheyCome)
{
    app::RenderRequest r = request();
    for (const core::AnyParams& method :
         {core::AnyParams(core::PathParams{}), core::AnyParams(core::ReuseParams{}),
          core::AnyParams(core::ManyLightsParams{})}) {
        r.params.method = method;
        EXPECT_TRUE(app::MovingDetail::wanted(r)) << method.id();
    }
    r.params.method = core::AoParams{};
    EXPECT_FALSE(app::MovingDetail::wanted(r)) << "nothing that albedo is a factor of";
    for (const app::Moving shows : {app::Moving::path, app::Moving::shaded}) {
        r = request();
        r.movingShows = shows;
        EXPECT_FALSE(app::MovingDetail::wanted(r));
    }
    r = request();
    r.movingDetail = false;
    EXPECT_FALSE(app::MovingDetail::wanted(r));
    r = request();
    r.camera.apertureRadius = 0.01;
    EXPECT_FALSE(app::MovingDetail::wanted(r)) << "what is out of focus has no edges";
    r.camera.orthographic = true;
    EXPECT_TRUE(app::MovingDetail::wanted(r)) << "its rays are parallel all the same";
}

TEST(MovingDetail, TakesAPartOfTheTimeButNoLessThanAQuarterOfTheSides)
{
    const app::MovingDetail detail;
    const glm::uvec2 full(1280, 720);
    glm::uvec2 last(0);
    for (const double seconds : {1e-6, 0.005, 0.02, 0.05, 0.1, 0.3, 1e6}) {
        const glm::uvec2 size = detail.affordable(full, seconds);
        EXPECT_GE(size.x, last.x);
        EXPECT_NEAR(size.x * 9.0 / 16, size.y, 1);
        if (size != full / 4u) {
            EXPECT_LT(detail.seconds(size), 0.5 * seconds);
        }
        if (size != full) {
            EXPECT_GT(detail.seconds(2u * size), 0.5 * seconds) << "the root of two finer, too";
        }
        last = size;
    }
    EXPECT_EQ(detail.affordable(full, 1e-6), full / 4u);
    EXPECT_EQ(detail.affordable(full, 1e6), full);
    EXPECT_EQ(detail.affordable({1, 1}, 1e-6), glm::uvec2(1));
}

TEST(MovingDetail, LearnsWhatSurfacesTake)
{
    app::MovingDetail detail;
    const glm::uvec2 size(100, 100);
    const double before = detail.seconds(size);
    detail.observe({50, 50}, 5 * before);
    const double once = detail.seconds(size);
    EXPECT_DOUBLE_EQ(once, 20 * before) << "slow ones count at once";
    for (int i = 0; i < 20; ++i) detail.observe(size, 0);
    EXPECT_LT(detail.seconds(size), once / 4);
}

}  // namespace

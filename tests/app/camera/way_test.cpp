// Where cameras have gone by hand: lines whose corners are known.
#include "app/camera/way.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "app/camera/navigation.h"

namespace {

using glm::dvec3;

TEST(Way, ALongOneKeepsItsEndsAndFewCorners)
{
    app::Way way;
    way.begin({0, 0, 0});
    for (int i = 1; i <= 1000; ++i) {
        way.go({i, 0, 0});
        way.go({i, 0, 0});  // standing still is no way
        EXPECT_LE(way.points().size(), app::Way::kMostPoints);
        EXPECT_EQ(way.points().front(), dvec3(0, 0, 0));
        EXPECT_EQ(way.points().back(), dvec3(i, 0, 0));
    }
    EXPECT_GT(way.points().size(), app::Way::kMostPoints / 4);
    for (size_t i = 1; i < way.points().size(); ++i)
        EXPECT_GT(way.points()[i].x, way.points()[i - 1].x);
}

TEST(Way, OfAnOrbitIsAnArc)
{
    app::Navigation navigation;
    navigation.set(core::lookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.8), 5);
    navigation.setPivot({0, 0, 0});
    navigation.orbit(0.5, 0);  // a quarter turn
    const std::vector<dvec3> points = navigation.way().points();
    ASSERT_GE(points.size(), 9u);
    EXPECT_EQ(points.front(), dvec3(0, 0, 4));
    EXPECT_EQ(points.back(), navigation.camera().position);
    EXPECT_NEAR(std::abs(points.back().x), 4, 1e-9);
    for (size_t i = 1; i < points.size(); ++i) {
        EXPECT_NEAR(glm::length(points[i]), 4, 1e-9);
        EXPECT_LE(glm::distance(points[i], points[i - 1]), 4 * std::numbers::pi / 16 + 1e-9);
    }
}

TEST(Way, JumpsAreNone)
{
    app::Navigation navigation;
    navigation.set(core::lookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 0.8), 5);
    const auto atRest = [&] {
        return navigation.way().points() == std::vector<dvec3>{navigation.camera().position};
    };
    EXPECT_TRUE(atRest());
    const app::Viewpoint before = navigation.viewpoint();
    const auto moved = [&] {
        navigation.dolly(1);
        navigation.pan(0.1, 0.1);
        navigation.fly({.forward = 1}, 0.1);
        return navigation.way().points().size() == 4;
    };
    EXPECT_TRUE(moved());
    navigation.go(before);
    EXPECT_TRUE(atRest() && moved());
    navigation.frame({0, 0, 0}, 3);
    EXPECT_TRUE(atRest() && moved());
    navigation.stand({1, 2, 3}, {0, 0, 0});
    EXPECT_TRUE(atRest() && moved());
    navigation.beginWay();
    EXPECT_TRUE(atRest());
    navigation.look(0.1, 0.1);
    EXPECT_TRUE(atRest()) << "the eye stays";
}

}  // namespace

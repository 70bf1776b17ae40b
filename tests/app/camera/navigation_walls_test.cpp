// Cameras moved by hand where something is in the way: how far they go, and that orbits go on
// turning.
#include "app/camera/navigation.h"
#include "tests/support/session/cameras.h"
#include "tests/support/statistics/no_numbers.h"

#include <cmath>

#include <gtest/gtest.h>

namespace {

using app::Navigation;
using glm::dvec2, glm::dvec3;
using tests::kDoubleNan, tests::someCamera, tests::shown, tests::axisError;

/// A wall at x = .5 stops what comes from below.
double beforeTheWall(const dvec3& from, const dvec3& to)
{
    return to.x > 0.5 && from.x <= 0.5 ? (0.5 - from.x) / (to.x - from.x) : 1;
}

TEST(NavigationWalls, AWallStopsAnOrbitWhichGoesOnTurning)
{
    for (const double roll : {0.0, 0.6}) {
        core::Camera camera = core::lookAt({0, 0, 4}, {0, 0, 0}, {std::sin(roll), 1, 0}, 0.8);
        Navigation free, stopped;
        for (Navigation* n : {&free, &stopped}) {
            n->set(camera, 5);
            n->setPivot({0, 0, 0});
        }
        const dvec2 seen = shown(camera, {0, 0, 0});
        for (const double dx : {-0.3, -0.02, 0.3, 0.6}) {
            const double x = stopped.camera().position.x;
            const bool was = stopped.orbit(dx, 0.05, beforeTheWall);
            EXPECT_FALSE(free.orbit(dx, 0.05));
            const core::Camera& now = stopped.camera();
            EXPECT_LE(now.position.x, 0.5 + 1e-12);
            if (was) {
                EXPECT_NEAR(now.position.x, 0.5, 1e-12) << "from " << x;
            }
            EXPECT_LE(axisError(now), 1e-12);
            EXPECT_LE(glm::distance(now.forward, free.camera().forward), 1e-12) << "turns alike";
            EXPECT_LE(glm::distance(shown(now, stopped.pivot()), seen), 1e-12);
            EXPECT_NEAR(glm::distance(now.position, stopped.pivot()), 4, 1e-12);
        }
        EXPECT_GT(glm::distance(free.camera().position, stopped.camera().position), 0.5);
    }
}

TEST(NavigationWalls, AWallStopsPansAndTheWheel)
{
    for (const double part : {0.25, 1.0}) {
        const auto reach = [part](const dvec3&, const dvec3&) { return part; };
        Navigation free;
        free.set(someCamera(), 5);
        Navigation stopped = free;
        const dvec3 from = free.camera().position, pivot = free.pivot();
        const auto goesAsFar = [&](bool was) {
            EXPECT_EQ(was, part < 1);
            const auto along = [part](const dvec3& a, const dvec3& b) {
                return a + part * (b - a);
            };
            EXPECT_LE(glm::distance(stopped.camera().position, along(from, free.camera().position)),
                      1e-9);
            EXPECT_LE(glm::distance(stopped.pivot(), along(pivot, free.pivot())), 1e-9);
            EXPECT_LE(axisError(stopped.camera()), 1e-12);
            free.go({someCamera(), pivot});
            stopped = free;
        };
        EXPECT_FALSE(free.pan(0.3, -0.2));
        goesAsFar(stopped.pan(0.3, -0.2, reach));
        EXPECT_FALSE(free.dolly(-3));
        goesAsFar(stopped.dolly(-3, reach));
        EXPECT_FALSE(free.dollyTo({1, 2, 0}, -3));
        goesAsFar(stopped.dollyTo({1, 2, 0}, -3, reach));
        EXPECT_FALSE(stopped.pan(kDoubleNan, 0, reach));
        EXPECT_FALSE(stopped.dollyTo({1, 2, 0}, kDoubleNan, reach));
        EXPECT_EQ(stopped.camera(), free.camera());
    }
}

}  // namespace

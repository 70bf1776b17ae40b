// Cameras moved by hand: what follows the cursor does so exactly, what is undone is undone, and
// nothing breaks the axes.
#include "app/camera/navigation.h"
#include "tests/support/session/cameras.h"
#include "tests/support/statistics/no_numbers.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace {

using app::Navigation;
using glm::dvec2, glm::dvec3;
using std::numbers::pi;
using tests::kDoubleNan, tests::someCamera, tests::shown, tests::axisError;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Turned about its direction of view, to the right.
core::Camera rolled(core::Camera camera, double angle)
{
    const dvec3 right = glm::cross(camera.forward, camera.up);
    camera.up = std::sin(angle) * right + std::cos(angle) * camera.up;
    return camera;
}

Navigation navigation(const core::Camera& camera, double radius = 5)
{
    Navigation n;
    n.set(camera, radius);
    return n;
}

void expectSame(const core::Camera& a, const core::Camera& b, double tolerance)
{
    EXPECT_LE(glm::distance(a.position, b.position), tolerance);
    EXPECT_LE(glm::distance(a.forward, b.forward), tolerance);
    EXPECT_LE(glm::distance(a.up, b.up), tolerance);
    EXPECT_NEAR(a.ymag, b.ymag, tolerance);
    EXPECT_NEAR(a.focusDistance, b.focusDistance, tolerance);
}

double elevation(const core::Camera& camera)
{
    return std::asin(camera.forward.y);
}

/// The cameras that people have: upright, lying, upside down, from below, straight up and down.
std::vector<core::Camera> manyCameras()
{
    std::vector<core::Camera> cameras;
    for (const double roll : {0.0, 0.4, -1.2, 0.5 * pi, 3.0})
        for (const dvec3 from :
             {dvec3(3, 1.5, 4), dvec3(-2, -4, 1), dvec3(0.01, 6, 0), dvec3(1, 0, 0)})
            cameras.push_back(rolled(core::lookAt(from, {0, 0, 0}, {0, 1, 0}, 0.8), roll));
    for (const double down : {-1.0, 1.0})
        cameras.push_back(core::lookAt({0, -4 * down, 0}, {0, 0, 0}, {1, 0, 0.3}, 0.8));
    return cameras;
}

TEST(Navigation, TakesACameraToTheBit)
{
    for (const core::Camera& camera : manyCameras()) {
        Navigation n = navigation(camera);
        EXPECT_EQ(n.camera(), camera);
        n.orbit(0, 0);
        n.look(0, 0);
        EXPECT_EQ(n.camera(), camera);
    }
}

TEST(Navigation, BrokenCamerasAreRepaired)
{
    core::Camera broken;
    broken.position = {kDoubleNan, 0, 0};
    broken.forward = {0, 0, 0};
    broken.up = {kInfinity, 0, 0};
    for (const double radius : {5.0, 0.0, -1.0, kDoubleNan, kInfinity}) {
        Navigation n = navigation(broken, radius);
        EXPECT_LE(axisError(n.camera()), 1e-12);
        n.orbit(0.1, 0.1);
        n.dolly(1);
        EXPECT_TRUE(std::isfinite(n.camera().position.x));
        EXPECT_GT(n.speed(), 0);
    }
}

TEST(Navigation, PivotIsWhereALensFocusesOrElseNearTheMiddle)
{
    const core::Camera camera = core::lookAt({0, 0, 8}, {0, 0, 0}, {0, 1, 0}, 0.8);
    EXPECT_LE(glm::length(navigation(camera).pivot()), 1e-12);
    core::Camera away = camera;
    away.forward = {0, 0, 1};
    EXPECT_LE(glm::distance(navigation(away).pivot(), dvec3(0, 0, 13)), 1e-12);  // a radius ahead
    core::Camera lens = camera;
    lens.apertureRadius = 0.1;
    lens.focusDistance = 2;
    EXPECT_LE(glm::distance(navigation(lens).pivot(), dvec3(0, 0, 6)), 1e-12);
    lens.focusDistance = 0;  // no lens focuses there
    EXPECT_LE(glm::distance(navigation(lens).pivot(), dvec3(0, 0, 3)), 1e-12);
}

TEST(Navigation, OrbitTurnsHalfARoundPerHeightAboutThePivot)
{
    const core::Camera camera = core::lookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.8);
    Navigation n = navigation(camera);
    n.orbit(0.5, 0);  // to the right by a quarter turn: the eye goes to the left of what it saw
    EXPECT_LE(glm::distance(n.camera().position, dvec3(-5, 0, 0)), 1e-12);
    EXPECT_LE(glm::distance(n.camera().forward, dvec3(1, 0, 0)), 1e-12);
    n.orbit(0, 0.25);  // down by an eighth: the eye rises
    EXPECT_NEAR(n.camera().position.y, 5 * std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(glm::length(n.camera().position), 5, 1e-12);
}

TEST(Navigation, OrbitKeepsThePivotInItsPlaceInThePicture)
{
    Navigation n = navigation(someCamera());
    n.setPivot({0.7, 0.9, 0.4});  // beside the middle
    const dvec2 before = shown(n.camera(), n.pivot());
    ASSERT_GT(glm::length(before), 0.05);
    n.orbit(0.3, -0.1);
    n.orbit(-1.1, 0.2);
    EXPECT_LE(glm::distance(shown(n.camera(), n.pivot()), before), 1e-12);
    EXPECT_LE(glm::distance(n.pivot(), dvec3(0.7, 0.9, 0.4)), 0);
}

TEST(Navigation, OrbitMovesWhatIsNearTheWayOfTheHandHoweverTheCameraIsRolled)
{
    for (const core::Camera& camera : manyCameras()) {
        if (std::abs(camera.forward.y) > 0.99) continue;  // at the poles only half of this holds
        for (const dvec2 drag : {dvec2(0.01, 0), dvec2(0, 0.01), dvec2(-0.007, 0.007)}) {
            Navigation n = navigation(camera);
            const dvec3 nearer = n.pivot() - 0.1 * n.pivotDepth() * camera.forward;
            const dvec2 before = shown(n.camera(), nearer);
            n.orbit(drag.x, drag.y);
            const dvec2 moved = shown(n.camera(), nearer) - before;
            EXPECT_GT(glm::dot(moved, drag), 0.3 * glm::length(moved) * glm::length(drag));
            EXPECT_GT(glm::length(moved), 0);
        }
    }
}

TEST(Navigation, OrbitStopsShortOfThePoles)
{
    for (const core::Camera& camera : manyCameras())
        for (const double dy : {0.02, -0.02}) {
            Navigation n = navigation(camera);
            const double distance = glm::distance(n.camera().position, n.pivot());
            const double before = std::abs(elevation(camera));
            for (int i = 0; i < 300; ++i) n.orbit(0.003, dy);
            // One that began steeper than the limit does not become steeper.
            EXPECT_LE(std::abs(elevation(n.camera())), std::max(before, glm::radians(89.5)) + 1e-7);
            EXPECT_LE(axisError(n.camera()), 1e-12);
            EXPECT_NEAR(glm::distance(n.camera().position, n.pivot()), distance, 1e-9);
        }
    Navigation n = navigation(someCamera());
    for (int i = 0; i < 300; ++i) n.orbit(0, 0.02);
    EXPECT_NEAR(elevation(n.camera()), -glm::radians(89.5), 1e-6);
    EXPECT_GT(n.camera().up.y, 0);  // and not over the top
}

TEST(Navigation, PanHasThePointUnderTheCursorFollowIt)
{
    for (const bool orthographic : {false, true}) {
        Navigation n = navigation(someCamera(orthographic));
        const core::Camera before = n.camera();
        // Any point at the pivot's depth, not the pivot alone.
        const dvec3 right = glm::cross(before.forward, before.up);
        const dvec3 point = n.pivot() + 0.6 * right - 0.4 * before.up;
        const dvec2 from = shown(before, point);
        n.pan(0.31, -0.17);
        EXPECT_LE(glm::distance(shown(n.camera(), point), from + dvec2(0.31, -0.17)), 1e-12);
        EXPECT_EQ(n.camera().forward, before.forward);
    }
}

TEST(Navigation, DollyComesNearerButNeverThrough)
{
    Navigation n = navigation(someCamera());
    const double before = n.pivotDepth();
    n.dolly(1);
    EXPECT_NEAR(n.pivotDepth(), 0.9 * before, 1e-12);
    const dvec3 forward = n.camera().forward;
    for (int i = 0; i < 2000; ++i) n.dolly(3);
    EXPECT_GT(glm::dot(n.pivot() - n.camera().position, forward), 0);
    n.dolly(-10);
    EXPECT_GT(n.pivotDepth(), 1e-4);  // and out again
    for (int i = 0; i < 2000; ++i) n.dolly(-3);
    EXPECT_LT(glm::length(n.camera().position), 1e6 * 5);
}

/// The height of a camera's own frame is the whole picture's, or its width is.
TEST(Navigation, ACamerasOwnFrameIsSeenWhole)
{
    for (const bool orthographic : {false, true}) {
        core::Camera camera = someCamera(orthographic);
        camera.aspect = 2;
        const dvec3 right = glm::cross(camera.forward, camera.up);
        const double half = orthographic ? camera.ymag : std::tan(0.5 * camera.yfov);
        const dvec3 corner =
            camera.position + camera.forward + half * (2.0 * right + 1.0 * camera.up);
        for (const double aspect : {0.5, 1.0, 1.5, 2.0, 3.0}) {
            const core::Camera view = app::framed(camera, aspect);
            const dvec2 at = shown(view, corner);
            EXPECT_NEAR(std::max(at.x / (0.5 * aspect), -at.y / 0.5), 1, 1e-9) << aspect;
            EXPECT_EQ(view.position, camera.position);
            if (aspect >= 2) {
                EXPECT_EQ(view, camera) << "wider pictures show more at the sides";
            }
            EXPECT_EQ(app::framed(view, aspect), view) << "once is enough: " << aspect;
        }
        EXPECT_EQ(app::framed(camera, 0), camera);
        EXPECT_EQ(app::framed(camera, kDoubleNan), camera);
        EXPECT_EQ(app::framed(camera, 1.9999), camera) << "a picture has whole pixels";
    }
}

TEST(Navigation, TheWheelKeepsWhatIsUnderTheCursorThere)
{
    for (const bool orthographic : {false, true})
        for (const double aspect : {0.0, 0.6, 1.8}) {
            Navigation n = navigation(someCamera(orthographic));
            n.setAspect(aspect);
            const dvec2 cursor(0.8, 0.3);
            const dvec3 point = n.pointAt(cursor);
            const double shape = aspect > 0 ? aspect : 1;
            const dvec2 there = (cursor - 0.5) * dvec2(shape, 1);
            EXPECT_LE(glm::distance(shown(n.view(), point), there), 1e-9);
            const core::Camera before = n.camera();
            const dvec3 pivot = n.pivot();
            for (const double steps : {1.0, 3.0, -2.5, 5.0}) {
                n.dollyTo(point, steps);
                EXPECT_LE(glm::distance(shown(n.view(), point), there), 1e-9);
            }
            n.dollyTo(point, -6.5);
            expectSame(n.camera(), before, 1e-9);
            EXPECT_LE(glm::distance(n.pivot(), pivot), 1e-9);
            for (int i = 0; i < 500; ++i) n.dollyTo(point, 10);
            EXPECT_GT(glm::dot(point - n.camera().position, before.forward), 0) << "never through";
            n.dollyTo({kDoubleNan, 0, 0}, 1);
            n.dollyTo(point, kDoubleNan);
            EXPECT_LE(axisError(n.camera()), 1e-9);
        }
}

TEST(Navigation, GoesBackToAViewAndStandsWhereItIsTold)
{
    Navigation n = navigation(someCamera());
    const app::Viewpoint before = n.viewpoint();
    n.orbit(0.2, 0.1);
    n.dolly(4);
    n.go(before);
    EXPECT_EQ(n.viewpoint(), before);
    n.stand({1, 2, 3}, {1, 2.5, -1});
    EXPECT_EQ(n.camera().position, dvec3(1, 2, 3));
    EXPECT_LE(glm::length(shown(n.camera(), {1, 2.5, -1})), 1e-9);
    EXPECT_NEAR(glm::cross(n.camera().forward, n.camera().up).y, 0, 1e-9) << "upright";
    n.stand({1, 2, 3}, {1, 2, 3});
    n.stand({1, kDoubleNan, 3}, {1, 2, 3});
    EXPECT_EQ(n.camera().position, dvec3(1, 2, 3));
}

TEST(Navigation, DollyMagnifiesOrthographicCameras)
{
    Navigation n = navigation(someCamera(true));
    const core::Camera before = n.camera();
    n.dolly(2);
    EXPECT_NEAR(n.camera().ymag, 0.81 * before.ymag, 1e-12);
    EXPECT_EQ(n.camera().position, before.position);
    for (int i = 0; i < 2000; ++i) n.dolly(5);
    EXPECT_GT(n.camera().ymag, 0);
}

TEST(Navigation, AFocusedLensStaysOnThePivotAPinholeIsLeftAlone)
{
    core::Camera lens = someCamera();
    lens.apertureRadius = 0.05;
    lens.focusDistance = 3;
    Navigation n = navigation(lens);
    n.dolly(2);
    EXPECT_NEAR(n.camera().focusDistance, 3 * 0.81, 1e-12);
    n.setPivot({0, 0, 0});
    EXPECT_NEAR(n.camera().focusDistance, glm::dot(-n.camera().position, n.camera().forward),
                1e-12);
    n.edit().focusDistance = 1;  // chosen otherwise: it stays
    n.dolly(1);
    EXPECT_EQ(n.camera().focusDistance, 1);

    Navigation pinhole = navigation(someCamera());
    const core::Camera before = pinhole.camera();
    pinhole.setPivot({0, 0, 0});
    EXPECT_EQ(pinhole.camera(), before);
}

TEST(Navigation, LookTurnsAboutTheEyeToWhereTheDragPoints)
{
    Navigation n = navigation(core::lookAt({1, 2, 3}, {1, 2, 0}, {0, 1, 0}, 0.8));
    const dvec2 pivot = shown(n.camera(), n.pivot());
    n.look(0.5, 0);
    EXPECT_EQ(n.camera().position, dvec3(1, 2, 3));
    EXPECT_NEAR(std::atan2(n.camera().forward.x, -n.camera().forward.z), 0.8, 1e-12);
    n.look(0, 0.25);
    EXPECT_NEAR(elevation(n.camera()), -0.4, 1e-12);
    EXPECT_LE(glm::distance(shown(n.camera(), n.pivot()), pivot), 1e-12);
    for (int i = 0; i < 300; ++i) n.look(0.01, -0.1);
    EXPECT_NEAR(elevation(n.camera()), glm::radians(89.5), 1e-6);
}

TEST(Navigation, FlyingHasTheSpeedThatItSays)
{
    Navigation n = navigation(core::lookAt({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.8), 8);
    EXPECT_EQ(n.speed(), 2);  // a quarter of the radius
    n.fly({.forward = 1}, 0.5);
    EXPECT_LE(glm::distance(n.camera().position, dvec3(1, 0, 0)), 1e-12);
    n.fly({.right = 1, .fast = true}, 0.5);
    EXPECT_LE(glm::distance(n.camera().position, dvec3(1, 0, 4)), 1e-12);
    n.fly({.up = -1, .slow = true}, 1);
    EXPECT_LE(glm::distance(n.camera().position, dvec3(1, -0.5, 4)), 1e-12);
    const dvec3 before = n.camera().position;
    n.fly({.right = 1, .up = 1, .forward = 1}, 0.25);  // not faster across
    EXPECT_NEAR(glm::distance(n.camera().position, before), 0.5, 1e-12);
    n.setSpeed(1e9);
    EXPECT_EQ(n.speed(), 800);
    n.setSpeed(0);
    EXPECT_GT(n.speed(), 0);
    const double speed = n.speed();
    n.setSpeed(kDoubleNan);
    EXPECT_EQ(n.speed(), speed);
    n.set(someCamera(), 8);  // another camera of the same scene
    EXPECT_EQ(n.speed(), speed);
    n.set(someCamera(), 4);  // another scene
    EXPECT_EQ(n.speed(), 1);
}

TEST(Navigation, FramingShowsAllOfASphere)
{
    const dvec3 centre(1, -2, 0.5);
    constexpr double radius = 1.3;
    for (const bool orthographic : {false, true})
        for (const double aspect : {0.0, 0.5, 1.7}) {
            Navigation n = navigation(someCamera(orthographic));
            const dvec3 forward = n.camera().forward;
            n.setAspect(aspect);
            n.frame(centre, radius);
            const core::Camera& c = n.camera();
            EXPECT_EQ(c.forward, forward);
            EXPECT_EQ(n.pivot(), centre);
            const dvec3 right = glm::cross(c.forward, c.up);
            const double halfWidth = 0.5 * (aspect > 0 ? aspect : 1);
            double widest = 0, highest = 0;
            for (int i = 0; i < 720; ++i)
                for (int j = 1; j < 90; ++j) {  // points of the near half
                    const double a = i * pi / 360, b = j * pi / 180;
                    const dvec3 p =
                        centre +
                        radius * (std::cos(b) * (std::cos(a) * right + std::sin(a) * c.up) -
                                  std::sin(b) * c.forward);
                    widest = std::max(widest, std::abs(shown(c, p).x));
                    highest = std::max(highest, std::abs(shown(c, p).y));
                }
            EXPECT_LE(widest, halfWidth + 1e-9);
            EXPECT_LE(highest, 0.5 + 1e-9);
            EXPECT_GT(std::max(widest / halfWidth, highest / 0.5), 0.97);  // and fills it
        }
}

TEST(Navigation, NonsenseIsIgnored)
{
    Navigation n = navigation(someCamera());
    const core::Camera before = n.camera();
    const dvec3 pivot = n.pivot();
    for (const double bad : {kDoubleNan, kInfinity, -kInfinity, 1e300, -1e12}) {
        n.orbit(bad, 0);
        n.orbit(0, bad);
        n.pan(bad, 0.1);
        n.pan(0.1, bad);
        n.look(0.1, bad);
        n.dolly(bad);
        n.fly({.right = 1}, bad);
        n.setPivot({0, bad * 1e300, 0});
        n.frame({bad * 1e300, 0, 0}, 1);
    }
    n.fly({.right = kDoubleNan}, 0.1);
    n.fly({.up = kInfinity}, 0.1);
    n.fly({.right = 1}, -1);
    n.frame({0, 0, 0}, kDoubleNan);
    n.setPivot(n.camera().position);
    EXPECT_EQ(n.camera(), before);
    EXPECT_EQ(n.pivot(), pivot);
}

TEST(Navigation, WhatIsDoneAndUndoneLeavesNoTrace)
{
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> some(-0.4, 0.4);
    int tried = 0;
    for (const core::Camera& camera : manyCameras()) {
        // What begins beyond the limits cannot be brought back there, and a camera that lies on its
        // side meets the poles when dragged sideways.
        const double level = std::sqrt(1 - camera.forward.y * camera.forward.y);
        if (level < 0.01 || std::abs(camera.up.y) < 0.9 * level) continue;
        ++tried;
        for (int repeat = 0; repeat < 20; ++repeat) {
            Navigation n = navigation(camera);
            const double x = some(engine), y = 0.1 * some(engine), steps = 10 * some(engine);
            const double levelling = 0.3 * std::copysign(1.0, camera.forward.y * camera.up.y);
            const app::FlyInput there{.right = x, .up = y, .forward = 1};
            const app::FlyInput back{.right = -x, .up = -y, .forward = -1};
            n.orbit(0.3 * x, y + levelling);
            n.pan(x, y);
            n.dolly(steps);
            n.look(0.1 * y, 0.1 * x);
            n.fly(there, 0.7);
            n.fly(back, 0.7);
            n.look(-0.1 * y, -0.1 * x);
            n.dolly(-steps);
            n.pan(-x, -y);
            n.orbit(-0.3 * x, -y - levelling);
            expectSame(n.camera(), camera, 1e-9);
        }
    }
    EXPECT_GE(tried, 8);
}

TEST(Navigation, AMillionRandomStepsKeepTheAxes)
{
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> some(-1, 1);
    std::uniform_int_distribution<int> which(0, 5);
    Navigation n = navigation(rolled(someCamera(), 0.3));
    const double roll = 0.3;
    double worst = 0;
    for (int i = 0; i < 1000000; ++i) {
        const double x = some(engine), y = some(engine);
        switch (which(engine)) {
        case 0:
            n.orbit(x, y);
            break;
        case 1:
            n.pan(x, y);
            break;
        case 2:
            n.dolly(5 * x);
            break;
        case 3:
            n.look(x, y);
            break;
        case 4:
            n.fly({x, y, some(engine), x > 0, y > 0}, 0.1);
            break;
        default:
            if (i % 100 == 0) n.frame({x, y, 0}, 5 + y);
        }
        worst = std::max(worst, axisError(n.camera()));
        if (i % 1000 == 0) {
            ASSERT_TRUE(glm::length(n.camera().position) < 1e7 && glm::length(n.pivot()) < 1e7);
        }
    }
    EXPECT_LE(worst, 1e-12);
    // What the hand cannot turn has not turned by itself.
    const dvec3 f = n.camera().forward;
    const dvec3 level = glm::normalize(glm::cross(f, dvec3(0, 1, 0)));
    EXPECT_NEAR(
        std::atan2(glm::dot(n.camera().up, level), glm::dot(n.camera().up, glm::cross(level, f))),
        roll, 1e-6);
}

}  // namespace

// Cameras: axes, angles, sizes, and that no input makes rays that are not finite.
#include "core/scene/camera.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "shared/camera.h"

namespace core {
namespace {

struct CameraRay {
    glm::vec3 origin, direction;
};

CameraRay rayThrough(const shared::CameraData& data, float x, float y, float width, float height,
                     glm::vec2 lens = glm::vec2(0.5f))
{
    CameraRay ray{};
    shared::cameraRay(data, {x, y}, {width, height}, lens, ray.origin, ray.direction);
    return ray;
}

void expectOrthonormal(const shared::CameraData& data)
{
    for (const glm::vec3 axis : {data.right, data.up, data.forward})
        EXPECT_NEAR(glm::length(axis), 1, 1e-6);
    EXPECT_NEAR(glm::dot(data.right, data.up), 0, 1e-6);
    EXPECT_NEAR(glm::dot(data.up, data.forward), 0, 1e-6);
    EXPECT_LT(glm::distance(glm::cross(data.right, data.up), -data.forward), 1e-6);
}

TEST(Camera, looksWhereItIsTold)
{
    const Camera camera = lookAt({1, 2, 3}, {4, -1, 0}, {0, 1, 0}, 0.8);
    const shared::CameraData data = cameraData(camera, 300, 200);
    expectOrthonormal(data);
    const CameraRay middle = rayThrough(data, 150, 100, 300, 200);
    EXPECT_LT(glm::distance(glm::dvec3(middle.direction), glm::normalize(glm::dvec3(3, -3, -3))),
              1e-6);
    EXPECT_EQ(middle.origin, glm::vec3(1, 2, 3));
    EXPECT_GT(data.up.y, 0);
    EXPECT_NEAR(data.right.y, 0, 1e-7);
}

TEST(Camera, keepsTheVerticalAngle)
{
    Camera camera;
    camera.yfov = 1.1;
    for (const auto& [width, height] : {std::pair(640u, 360u), {100u, 400u}, {1u, 1u}}) {
        const shared::CameraData data = cameraData(camera, width, height);
        const float w = float(width), h = float(height);
        const glm::vec3 top = rayThrough(data, w / 2, 0, w, h).direction;
        const glm::vec3 right = rayThrough(data, w, h / 2, w, h).direction;
        EXPECT_NEAR(std::atan2(double(top.y), -double(top.z)), 0.55, 1e-6);
        EXPECT_NEAR(double(right.x) / -double(right.z), std::tan(0.55) * double(w) / double(h),
                    1e-4);
        EXPECT_GT(top.y, 0);  // rows from the top
        EXPECT_GT(right.x, 0);
    }
}

TEST(Camera, thinLensMeetsInThePlaneOfFocus)
{
    Camera camera = lookAt({0, 0, 0}, {1, 0.5, -2}, {0, 1, 0}, 0.9);
    camera.apertureRadius = 0.2;
    camera.focusDistance = 3;
    const shared::CameraData data = cameraData(camera, 64, 48);
    const CameraRay a = rayThrough(data, 10, 40, 64, 48, {0.1f, 0.9f});
    const CameraRay b = rayThrough(data, 10, 40, 64, 48, {0.8f, 0.3f});
    ASSERT_GT(glm::distance(a.origin, b.origin), 0.05f);
    const auto atFocus = [&](const CameraRay& ray) {
        const float along = glm::dot(ray.origin - data.position, data.forward);
        return ray.origin + ray.direction * ((3 - along) / glm::dot(ray.direction, data.forward));
    };
    EXPECT_LT(glm::distance(atFocus(a), atFocus(b)), 2e-6f);
    EXPECT_LE(glm::distance(a.origin, data.position), 0.2f + 1e-6f);
}

TEST(Camera, orthographicRaysAreParallel)
{
    Camera camera;
    camera.orthographic = true;
    camera.ymag = 2.5;
    const shared::CameraData data = cameraData(camera, 20, 10);
    const CameraRay top = rayThrough(data, 20, 0, 20, 10);
    EXPECT_EQ(top.direction, glm::vec3(0, 0, -1));
    EXPECT_LT(glm::distance(top.origin, glm::vec3(5, 2.5f, 3)), 1e-6f);
}

TEST(Camera, anyInputGivesFiniteAxes)
{
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    const glm::dvec3 odd[] = {{0, 0, 0},      {0, 1, 0},     {0, -5, 0},    {kNan, 0, 1},
                              {1e-200, 0, 0}, {1e200, 0, 0}, {0, 1, 1e-12}, {1, 2, 3}};
    for (const glm::dvec3 forward : odd)
        for (const glm::dvec3 up : odd)
            for (const double angle : {-1.0, 0.0, 1e-5, 1.0, 3.1415926, 9.0}) {
                Camera camera;
                camera.forward = forward;
                camera.up = up;
                camera.yfov = angle;
                const shared::CameraData data = cameraData(camera, 7, 5);
                expectOrthonormal(data);
                EXPECT_TRUE(std::isfinite(data.tanHalfHeight) && data.tanHalfHeight > 0);
                const glm::vec3 corner = rayThrough(data, 0, 0, 7, 5).direction;
                EXPECT_NEAR(glm::length(corner), 1, 1e-5);
            }
}

TEST(Camera, heightFollowsTheAspect)
{
    Camera camera;
    camera.aspect = 1.5;
    EXPECT_EQ(sizeForWidth(camera, 300), glm::uvec2(300, 200));
    camera.aspect = 0.5625;
    EXPECT_EQ(sizeForWidth(camera, 360), glm::uvec2(360, 640));
    camera.aspect = 0;
    EXPECT_EQ(sizeForWidth(camera, 640), glm::uvec2(640, 360));
    camera.aspect = 1e6;
    EXPECT_EQ(sizeForWidth(camera, 640), glm::uvec2(640, 1));
    camera.aspect = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(sizeForWidth(camera, 16), glm::uvec2(16, 9));
}

}  // namespace
}  // namespace core

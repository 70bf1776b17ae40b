// Full pictures from small ones, of walls whose light is known everywhere.
#include "app/pictures/temporal_upsampling.h"

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "app/pictures/preview_shading.h"
#include "core/base/pcg32.h"
#include "core/methods/first_hits.h"
#include "shared/camera.h"

namespace {

constexpr glm::uvec2 kFull{128, 72}, kSmall{32, 18};

/// A wall that faces the camera at z = -depth, of one material, and what it radiates at (x, y).
/// `half`: of its sides; it has no end where that is infinite.
struct Wall {
    float depth = 4;
    std::function<float(glm::vec2)> radiance;
    float half = INFINITY;
    int material = 0;
    bool emits = false;
};

using Walls = std::vector<Wall>;

/// A picture of walls, nearest first, with its first hits.
struct Picture {
    core::Image mean;
    core::Aovs aovs;
    core::Camera camera;

    Picture(const Walls& walls, const core::Camera& from, glm::uvec2 size)
        : mean(size.x, size.y, 3), aovs(core::emptyAovs(size.x, size.y)), camera(from)
    {
        const shared::CameraData data = core::cameraData(camera, size.x, size.y);
        for (uint32_t y = 0; y < size.y; ++y)
            for (uint32_t x = 0; x < size.x; ++x) {
                glm::vec3 origin, direction;
                shared::cameraRay(data, glm::vec2(x, y) + 0.5f, size, glm::vec2(0.5f), origin,
                                  direction);
                for (const Wall& wall : walls)
                    if (see(wall, origin, direction, x, y)) break;
            }
    }

    app::TemporalUpsampler::Seen seen(const core::Image& guide) const
    {
        return {mean, aovs, guide, camera};
    }

private:
    bool see(const Wall& wall, glm::vec3 origin, glm::vec3 direction, uint32_t x, uint32_t y)
    {
        const float t = (-wall.depth - origin.z) / direction.z;
        const glm::vec2 at = glm::vec2(origin + t * direction);
        if (!(t > 0) || std::abs(at.x) > wall.half || std::abs(at.y) > wall.half) return false;
        for (int c = 0; c < 3; ++c) mean.at(x, y)[c] = wall.radiance(at);
        *aovs.depth.at(x, y) = t;
        aovs.normal.at(x, y)[2] = 1;
        aovs.ids.at(x, y)[1] = static_cast<float>(wall.material);
        aovs.ids.at(x, y)[2] = wall.emits ? 0 : -1;
        return true;
    }
};

core::Camera cameraAt(glm::dvec3 position)
{
    core::Camera camera;
    camera.position = position;
    return camera;
}

/// A board of squares that are a few pixels of the small picture wide, painted on one wall.
float board(glm::vec2 at)
{
    const auto cell = [](float x) { return static_cast<int>(std::floor(x / 1.3f + 0.3f)); };
    return ((cell(at.x) + cell(at.y)) & 1) != 0 ? 1.5f : 0.5f;
}

float flat(glm::vec2)
{
    return 1;
}

/// What pixels of the full size show on average.
core::Image filtered(const Walls& walls, const core::Camera& camera)
{
    constexpr uint32_t kFine = 4;
    const Picture fine(walls, camera, kFine * kFull);
    core::Image image(kFull.x, kFull.y, 3);
    for (uint32_t y = 0; y < fine.mean.height; ++y)
        for (uint32_t x = 0; x < fine.mean.width; ++x)
            for (int c = 0; c < 3; ++c)
                image.at(x / kFine, y / kFine)[c] += fine.mean.at(x, y)[c] / (kFine * kFine);
    return image;
}

double meanSquare(const core::Image& a, const core::Image& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        const double d = static_cast<double>(a.pixels[i]) - static_cast<double>(b.pixels[i]);
        sum += d * d;
    }
    return sum / static_cast<double>(a.pixels.size());
}

/// Pictures from cameras in turn, and the last of them in full.
class Flight {
public:
    app::TemporalUpsampler upsampler;
    core::Image shown;
    std::vector<double> errors;  // mean square, of each picture

    void see(const Walls& walls, core::Camera camera)
    {
        const core::Image truth = filtered(walls, camera);
        camera.shift = app::TemporalUpsampler::shiftOf(count_++, kSmall);
        const Picture small(walls, camera, kSmall);
        shown = upsampler.add(small.seen(app::surfaceGuide(small.aovs)), kFull);
        errors.push_back(meanSquare(shown, truth));
    }

private:
    uint64_t count_ = 0;
};

TEST(TemporalUpsampling, PointsCoverTheirPixelsEvenly)
{
    std::vector<int> quarters(16);
    for (uint64_t i = 0; i < 64; ++i) {
        const glm::dvec2 shift = app::TemporalUpsampler::shiftOf(i, kSmall) * glm::dvec2(kSmall);
        ASSERT_TRUE(shift.x >= -1 && shift.x < 1 && shift.y >= -1 && shift.y < 1);
        ++quarters[size_t(2 * (shift.x + 1)) + 4 * size_t(2 * (shift.y + 1))];
    }
    for (const int n : quarters) EXPECT_NEAR(n, 4, 2);
}

TEST(TemporalUpsampling, ARestingCameraComesToSeeEveryPixel)
{
    Flight flight;
    for (int i = 0; i < 96; ++i) flight.see({{.radiance = board}}, cameraAt({0, 0, 3}));
    EXPECT_GT(flight.errors.front(), 0.02) << "so much detail small pictures do not have";
    EXPECT_LT(flight.errors.back(), 0.45 * flight.errors.front());
}

TEST(TemporalUpsampling, AMovingCameraKeepsDetail)
{
    Flight flight;
    for (int i = 0; i < 96; ++i) {
        core::Camera camera =
            core::lookAt({0.02 * i, 0.003 * i, 3 - 0.004 * i}, {0.01 * i, 0, -4}, {0, 1, 0}, 0.7);
        flight.see({{.radiance = board}}, camera);
    }
    EXPECT_LT(flight.errors.back(), 0.9 * flight.errors.front());
}

TEST(TemporalUpsampling, EdgesAreSharpAndNothingTrails)
{
    const Walls walls{{.depth = 1, .radiance = [](glm::vec2) { return 3.0f; }, .half = 0.4f},
                      {.depth = 6, .radiance = flat, .material = 1}};
    Flight flight;
    double sum = 0, single = 0;
    for (int i = 0; i < 60; ++i) {
        const core::Camera camera = cameraAt({-0.6 + 0.02 * i, 0.1, 3});
        flight.see(walls, camera);
        if (i >= 30) sum += flight.errors.back();
        Flight alone;
        alone.see(walls, camera);
        if (i >= 30) single += alone.errors.back();
        for (const float value : flight.shown.pixels)
            ASSERT_TRUE(value > 0.999f && value < 3.001f) << "light of neither wall";
    }
    EXPECT_LT(sum, 0.55 * single);
}

TEST(TemporalUpsampling, LightThatChangesIsShownAtOnce)
{
    Flight flight;
    for (int i = 0; i < 20; ++i) flight.see({{.radiance = flat}}, cameraAt({0, 0, 3}));
    flight.see({{.radiance = [](glm::vec2) { return 2.0f; }}}, cameraAt({0, 0, 3}));
    EXPECT_LT(flight.errors.back(), 1e-9);
}

TEST(TemporalUpsampling, ALampDoesNotShineIntoItsWall)
{
    const Walls walls{{.radiance = [](glm::vec2) { return 100.0f; }, .half = 0.5f, .emits = true},
                      {.radiance = flat}};
    Flight flight;
    for (int i = 0; i < 40; ++i) {
        flight.see(walls, cameraAt({0.01 * i, 0, 3}));
        for (const float value : flight.shown.pixels)
            ASSERT_TRUE(std::abs(value - 1) < 1e-3f || std::abs(value - 100) < 0.1f) << value;
    }
}

/// Things between the points of a small picture, on a wall and before it, are seen whenever they
/// have been seen: by the picture at rest, or by any point of before.
TEST(TemporalUpsampling, SmallThingsStayInSight)
{
    const auto red = [](glm::vec2) { return 8.0f; };
    for (const float depth : {4.0f, 2.5f})
        for (const bool atRest : {true, false}) {
            const float half = 0.02f * (3 + depth);  // about three pixels wide
            const Walls walls{{.depth = depth, .radiance = red, .half = half, .material = 2},
                              {.radiance = flat}};
            Flight flight;
            const auto cameraOf = [](int i) { return cameraAt({-0.4 + 0.012 * i, 0.05, 3}); };
            if (atRest) {
                const Picture settled(walls, cameraOf(-1), kFull);
                flight.upsampler.begin(settled.mean, settled.aovs, settled.camera, kFull);
            }
            // Light more than the wall's; squared errors, and those of the wall alone.
            double shown = 0, truth = 0, error = 0, blank = 0;
            for (int i = 0; i < 60; ++i) {
                flight.see(walls, cameraOf(i));
                if (i < 20) continue;
                const core::Image wanted = filtered(walls, cameraOf(i));
                Flight alone;
                alone.see({{.radiance = flat}}, cameraOf(i));
                blank += meanSquare(alone.shown, wanted);
                error += flight.errors.back();
                for (size_t k = 0; k < wanted.pixels.size(); ++k) {
                    shown += double(flight.shown.pixels[k]) - 1;
                    truth += double(wanted.pixels[k]) - 1;
                }
            }
            EXPECT_NEAR(shown, truth, 0.15 * truth) << depth << ", from rest: " << atRest;
            EXPECT_LT(error, 0.4 * blank) << depth << ", from rest: " << atRest;
        }
}

TEST(TemporalUpsampling, NothingHitIsASurfaceOfItsOwn)
{
    const Walls walls{{.radiance = flat, .half = 1}};
    Flight flight;
    for (int i = 0; i < 40; ++i) flight.see(walls, cameraAt({0.02 * i, 0, 3}));
    for (const float value : flight.shown.pixels)
        ASSERT_TRUE(value == 0 || std::abs(value - 1) < 1e-5f) << value;
}

TEST(TemporalUpsampling, APictureAtRestIsWhereAFlightBegins)
{
    const Walls walls{{.radiance = board}};
    const core::Camera camera = cameraAt({0, 0, 3}), next = cameraAt({0.02, 0, 3});
    const Picture settled(walls, camera, kFull);
    Flight with, without;
    with.upsampler.begin(settled.mean, settled.aovs, settled.camera, kFull);
    with.see(walls, next);
    without.see(walls, next);
    EXPECT_LT(with.errors.back(), 0.3 * without.errors.back());
    Flight resized;
    const Picture other(walls, camera, kFull / 2u);
    resized.upsampler.begin(other.mean, other.aovs, other.camera, kFull / 2u);
    resized.see(walls, next);
    EXPECT_EQ(resized.errors.back(), without.errors.back()) << "of another size it is of no use";
}

TEST(TemporalUpsampling, NothingComesFromNumbersThatAreNone)
{
    Flight flight;
    const Walls walls{{.radiance = [](glm::vec2 at) { return at.x > 0 ? 1.0f : NAN; }}};
    flight.see(walls, cameraAt({0, 0, 3}));
    for (int i = 0; i < 10; ++i) flight.see({{.radiance = flat}}, cameraAt({0, 0, 3}));
    for (const float value : flight.shown.pixels) ASSERT_FALSE(std::isnan(value));
}

TEST(TemporalUpsampling, WhatComesInAtOneSideDoesNotComeFromTheOther)
{
    Flight flight;
    const Walls walls{{.radiance = [](glm::vec2 at) { return at.x > 0 ? 2.0f : 1.0f; }}};
    for (int i = 0; i < 40; ++i) {
        flight.see(walls, cameraAt({0.04 * i, 0, 3}));
        for (uint32_t y = 0; y < kFull.y; ++y)
            ASSERT_EQ(flight.shown.at(kFull.x - 1, y)[0], 2) << "picture " << i << ", row " << y;
    }
    for (int i = 40; i > -20; --i) {
        flight.see(walls, cameraAt({0.04 * i, 0, 3}));
        for (uint32_t y = 0; y < kFull.y; ++y)
            ASSERT_EQ(flight.shown.at(0, y)[0], 1) << "picture " << i << ", row " << y;
    }
}

TEST(TemporalUpsampling, NoiseIsAveraged)
{
    core::Pcg32 random(7);
    const auto noisy = [&](glm::vec2) { return static_cast<float>(-std::log(1 - random())); };
    const auto off = [](const Flight& flight) {
        double sum = 0, squares = 0;
        for (const float value : flight.shown.pixels) {
            sum += static_cast<double>(value);
            squares += static_cast<double>(value - 1) * static_cast<double>(value - 1);
        }
        const auto count = static_cast<double>(flight.shown.pixels.size());
        return glm::dvec2(sum, squares) / count;
    };
    Flight flight;
    const Walls walls{{.radiance = noisy}};
    flight.see(walls, cameraAt({0, 0, 3}));
    const double single = off(flight).y;
    double mean = 0, error = 0;
    for (int i = 1; i < 100; ++i) {
        flight.see(walls, cameraAt({0.01 * i, 0.002 * i, 3}));
        if (i < 40) continue;
        mean += off(flight).x / 60;
        error += off(flight).y / 60;
    }
    EXPECT_LT(error, 0.35 * single);
    EXPECT_NEAR(mean, 1, 0.03) << "bounds cut bright samples off, and dark ones";
}

}  // namespace

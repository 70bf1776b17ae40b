// Light of small pictures on finer surfaces, in views whose answer can be told beforehand.
#include "app/pictures/fine_light.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "app/pictures/pixel_rays.h"
#include "core/base/parallel.h"
#include "core/methods/first_hits.h"

namespace {

constexpr glm::uvec2 kSmall(16, 9), kLarge(112, 63);

/// Looks along -Z from the origin.
core::Camera ahead()
{
    core::Camera c;
    c.position = glm::dvec3(0);
    c.yfov = 0.8;
    return c;
}

/// What is seen in a direction: a plane across the view at that distance, or nothing.
struct Seen {
    float distance = 3, material = 0, emission = 0, albedo = 0.5f;
    bool nothing = false;
};
using Scene = std::function<Seen(glm::vec2)>;  // of the direction's x and y for z = -1

/// Of the plane z = -3 from elsewhere: what ahead() sees in the direction of its points.
glm::vec2 planeAt(const core::Camera& camera, const glm::vec3& d)
{
    const glm::vec3 from(camera.position);
    const glm::vec3 point = from - (3 + from.z) / d.z * d;
    return glm::vec2(point) / 3.0f;
}

core::Aovs hits(glm::uvec2 size, const Scene& scene, const core::Camera& camera = ahead())
{
    core::Aovs aovs = core::emptyAovs(size.x, size.y);
    const app::PixelRays rays(camera, size.x, size.y);
    const auto near = static_cast<float>(camera.position.z);
    for (uint32_t y = 0; y < size.y; ++y)
        for (uint32_t x = 0; x < size.x; ++x) {
            const glm::vec3 d = rays.direction(x, y);
            Seen seen = scene(planeAt(camera, d));
            seen.distance += near;
            for (int c = 0; c < 3; ++c) aovs.emission.at(x, y)[c] = seen.emission;
            if (seen.nothing) continue;
            *aovs.depth.at(x, y) = seen.distance / -d.z;
            const glm::vec3 normal(0, 0, 1), ids(0, seen.material, seen.emission > 0 ? 0 : -1);
            for (int c = 0; c < 3; ++c) {
                aovs.normal.at(x, y)[c] = normal[c];
                aovs.albedo.at(x, y)[c] = seen.albedo;
                aovs.ids.at(x, y)[c] = ids[c];
            }
        }
    return aovs;
}

/// Radiance of `light` on the scene's surfaces, and theirs.
core::Image radiance(glm::uvec2 size, const Scene& scene,
                     const std::function<float(glm::vec2)>& light,
                     const core::Camera& camera = ahead())
{
    core::Image image(size.x, size.y, 3);
    const app::PixelRays rays(camera, size.x, size.y);
    for (uint32_t y = 0; y < size.y; ++y)
        for (uint32_t x = 0; x < size.x; ++x) {
            const glm::vec2 at = planeAt(camera, rays.direction(x, y));
            const Seen seen = scene(at);
            const float albedo = seen.nothing ? 0 : seen.albedo;
            for (int c = 0; c < 3; ++c) image.at(x, y)[c] = seen.emission + albedo * light(at);
        }
    return image;
}

core::Image onSurfaces(const core::Image& mean, const Scene& scene, glm::uvec2 large = kLarge)
{
    return app::lightOnSurfaces(mean, {hits({mean.width, mean.height}, scene), ahead()},
                                {hits(large, scene), ahead()});
}

core::Image onSurfaces(const Scene& scene, const std::function<float(glm::vec2)>& light)
{
    return onSurfaces(radiance(kSmall, scene, light), scene);
}

void expectNear(const core::Image& image, const core::Image& expected, float tolerance)
{
    ASSERT_EQ(image.pixels.size(), expected.pixels.size());
    for (size_t i = 0; i < image.pixels.size(); ++i)
        ASSERT_NEAR(image.pixels[i], expected.pixels[i], tolerance)
            << i / 3 % image.width << ", " << i / 3 / image.width;
}

float one(glm::vec2)
{
    return 1;
}

TEST(FineLight, TexturesAreThoseOfTheSurfaces)
{
    const Scene paint = [](glm::vec2 at) {
        return Seen{.albedo = 0.5f + 0.4f * std::sin(90 * at.x) * std::sin(110 * at.y)};
    };
    expectNear(onSurfaces(paint, one), radiance(kLarge, paint, one), 1e-5f);
}

TEST(FineLight, NoneCrossesAnEdge)
{
    // Aslant, so that it is nowhere along pixels: of two materials, and of one at two distances.
    const auto isLeft = [](glm::vec2 at) { return at.x + 0.3f * at.y < 0.07f; };
    const auto light = [&](glm::vec2 at) { return isLeft(at) ? 8.0f : 0.0f; };
    const Scene two = [&](glm::vec2 at) { return Seen{.material = isLeft(at) ? 0.0f : 1.0f}; };
    expectNear(onSurfaces(two, light), radiance(kLarge, two, light), 1e-5f);
    const Scene steps = [&](glm::vec2 at) { return Seen{.distance = isLeft(at) ? 3.0f : 5.0f}; };
    expectNear(onSurfaces(steps, light), radiance(kLarge, steps, light), 1e-5f);
}

/// Whatever the ratio of the small picture's sides, which is of whole pixels.
TEST(FineLight, WhatRisesEvenlyStaysSo)
{
    const Scene wall = [](glm::vec2) { return Seen{}; };
    const auto light = [](glm::vec2 at) { return 2 + at.x - 2 * at.y; };
    for (const glm::uvec2 size : {kSmall, glm::uvec2(17, 9), glm::uvec2(16, 10)}) {
        const core::Image fine = onSurfaces(radiance(size, wall, light), wall),
                          expected = radiance(kLarge, wall, light);
        for (uint32_t y = 8; y < kLarge.y - 8; ++y)  // between the middles of pixels
            for (uint32_t x = 8; x < kLarge.x - 8; ++x)
                ASSERT_NEAR(*fine.at(x, y), *expected.at(x, y), 2e-3f) << size.x << ": " << x;
    }
}

/// The light of what is around, and not its colours.
TEST(FineLight, WhatIsNarrowerThanAPixelIsLitAsWhatIsAround)
{
    const Scene post = [](glm::vec2 at) {
        // Between the middles of two pixels of the small picture
        const bool here = std::abs(at.x) < 0.01f;
        return Seen{.distance = here ? 2.0f : 3.0f,
                    .material = here ? 1.0f : 0.0f,
                    .albedo = here ? 0.9f : 0.2f};
    };
    expectNear(onSurfaces(post, one), radiance(kLarge, post, one), 1e-4f);
}

/// Emission is that of the first hits, whether or not a pixel of the small picture shows a lamp,
/// and there is light on lamps, too.
TEST(FineLight, LampsAndTheOpenShineAsTheyAre)
{
    const Scene scene = [](glm::vec2 at) {
        const bool open = at.x < -0.21f, small = glm::length(at - glm::vec2(0, 0.085f)) < 0.012f;
        return Seen{.material = small ? 1.0f : 0.0f,
                    .emission = open           ? 3.0f
                                : at.x > 0.19f ? 50.0f
                                : small        ? 20.0f
                                               : 0.0f,
                    .nothing = open};
    };
    const core::Aovs small = hits(kSmall, scene), large = hits(kLarge, scene);
    const auto count = [](const core::Aovs& aovs) {
        return std::ranges::count(aovs.emission.pixels, 20.0f);
    };
    ASSERT_EQ(count(small), 0);
    ASSERT_GT(count(large), 0);
    expectNear(onSurfaces(scene, one), radiance(kLarge, scene, one), 1e-4f);
}

/// Not even where all around it are lamps on which no light falls.
TEST(FineLight, BarsBeforeALampAreNotAsDarkAsTheLampItself)
{
    const Scene window = [](glm::vec2 at) {
        const bool bar = std::abs(at.x)<0.01f, wall = std::abs(at.x)> 0.2f;
        return Seen{.material = bar    ? 2.0f
                                : wall ? 1.0f
                                       : 0.0f,
                    .emission = bar || wall ? 0.0f : 16.0f};
    };
    const auto light = [&](glm::vec2 at) { return window(at).emission > 0 ? 0.0f : 1.0f; };
    expectNear(onSurfaces(window, light), radiance(kLarge, window, light), 1e-4f);
}

/// Cameras that have moved on, turned or come nearer see the light where it is.
TEST(FineLight, ACameraThatHasMovedOnSeesItWhereItIs)
{
    const auto isLeft = [](glm::vec2 at) { return at.x + 0.3f * at.y < 0.07f; };
    const auto light = [&](glm::vec2 at) { return (isLeft(at) ? 4.0f : 1.0f) + at.x - at.y; };
    const Scene two = [&](glm::vec2 at) {
        return Seen{.material = isLeft(at) ? 0.0f : 1.0f,
                    .albedo = 0.5f + 0.4f * std::sin(90 * at.x)};
    };
    core::Camera moved = ahead(), turned = ahead(), near = ahead();
    moved.position = {0.3, -0.2, 0};
    turned.forward = glm::normalize(glm::dvec3(0.1, 0.05, -1));
    turned.up = glm::normalize(glm::dvec3(0.1, 1, 0) -
                               glm::dot(glm::dvec3(0.1, 1, 0), turned.forward) * turned.forward);
    near.position.z = -1;
    const core::Aovs coarse = hits(kSmall, two);
    const core::Image mean = radiance(kSmall, two, light);
    const core::Camera before = ahead();
    for (const core::Camera& camera : {moved, turned, near}) {
        const core::Aovs fine = hits(kLarge, two, camera);
        const core::Image seen = app::lightOnSurfaces(mean, {coarse, before}, {fine, camera}),
                          expected = radiance(kLarge, two, light, camera);
        size_t known = 0;
        for (uint32_t y = 0; y < kLarge.y; ++y)
            for (uint32_t x = 0; x < kLarge.x; ++x) {
                const glm::vec2 at =
                    planeAt(camera, app::PixelRays(camera, kLarge.x, kLarge.y).direction(x, y));
                // What the small picture shows, but for half a pixel at its rim, and one beside
                // the edge
                const glm::vec2 rim(0.422f * 16 / 9 * 15 / 16, 0.422f * 8 / 9);
                if (std::abs(at.x) > rim.x || std::abs(at.y) > rim.y) continue;
                if (isLeft(at + glm::vec2(0.1f, 0)) != isLeft(at - glm::vec2(0.1f, 0))) continue;
                ASSERT_NEAR(*seen.at(x, y), *expected.at(x, y), 5e-3f) << x << ", " << y;
                ++known;
            }
        EXPECT_GT(known, 2000u);
        for (const float v : seen.pixels) ASSERT_TRUE(std::isfinite(v));
    }
}

/// Nothing of it may be known: behind where the light was seen from, or far beyond its rim.
TEST(FineLight, WhereNothingHasBeenSeenThereIsSomeLight)
{
    const Scene wall = [](glm::vec2) { return Seen{}; };
    const core::Camera before = ahead();
    core::Camera back = ahead(), far = ahead();
    back.forward = {0, 0, 1};
    far.position.x = 1e6;
    const core::Aovs coarse = hits(kSmall, wall);
    for (const core::Camera& camera : {back, far}) {
        core::Aovs fine = hits(kLarge, wall, far);
        const core::Image seen =
            app::lightOnSurfaces(radiance(kSmall, wall, one), {coarse, before}, {fine, camera});
        for (const float v : seen.pixels) ASSERT_NEAR(v, 0.5f, 1e-5f);
    }
}

TEST(PixelRays, PointsAreSeenWhereTheirRaysBegin)
{
    for (const bool orthographic : {false, true}) {
        core::Camera camera = core::lookAt({1, 2, 3}, {2, 2.5, -4}, {0, 1, 0}, 0.9);
        camera.orthographic = orthographic;
        camera.ymag = 2.5;
        const app::PixelRays rays(camera, 37, 21);
        for (uint32_t y = 0; y < 21; ++y)
            for (uint32_t x = 0; x < 37; ++x)
                for (const float distance : {0.01f, 2.0f, 1e4f}) {
                    const std::optional<glm::vec2> film = rays.film(rays.point(x, y, distance));
                    ASSERT_TRUE(film);
                    const float tolerance = orthographic && distance > 10 ? 0.05f : 1e-3f;
                    ASSERT_NEAR(film->x, float(x), tolerance);
                    ASSERT_NEAR(film->y, float(y), tolerance);
                    if (!orthographic) {
                        ASSERT_FALSE(rays.film(-rays.point(x, y, distance))) << "behind";
                    }
                }
    }
}

TEST(FineLight, WhatIsNoNumberIsNotPassedOn)
{
    const Scene wall = [](glm::vec2) { return Seen{}; };
    core::Image mean = radiance(kSmall, wall, one);
    *mean.at(5, 5) = std::numeric_limits<float>::infinity();
    *mean.at(6, 5) = std::numeric_limits<float>::quiet_NaN();
    for (const float v : onSurfaces(mean, wall).pixels) ASSERT_NEAR(v, 0.5f, 1e-5f);
}

TEST(FineLight, PicturesOfAnySizeAreTakenByAnyNumberOfThreads)
{
    const Scene scene = [](glm::vec2 at) { return Seen{.material = at.y > 0 ? 1.0f : 0.0f}; };
    for (const glm::uvec2 small : {glm::uvec2(1), glm::uvec2(1, 3), glm::uvec2(5, 2)})
        for (const glm::uvec2 large : {glm::uvec2(1), glm::uvec2(7, 3), glm::uvec2(31, 40)}) {
            const core::Image mean = radiance(small, scene, one);
            const core::Image fine = onSurfaces(mean, scene, large);
            for (const float v : fine.pixels) ASSERT_NEAR(v, 0.5f, 1e-5f);
            const core::ThreadLimit limit(1);
            EXPECT_EQ(onSurfaces(mean, scene, large).pixels, fine.pixels);
        }
}

}  // namespace

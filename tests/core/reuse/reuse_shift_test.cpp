// How old samples are carried along, and where their pixels are looked for.
#include "shared/reuse_shift.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "core/base/pcg32.h"
#include "shared/motion.h"
#include "shared/reuse_new.h"

namespace {

using core::Pcg32;
using glm::dvec3, glm::vec2, glm::vec3, glm::vec4;

vec3 randomPoint(Pcg32& random)
{
    const auto next = [&] { return static_cast<float>(2 * random() - 1); };
    const float x = next(), y = next();
    return {x, y, next()};
}

shared::Triangle randomTriangle(Pcg32& random)
{
    return {vec4(randomPoint(random), 0), vec4(randomPoint(random), 0),
            vec4(randomPoint(random), 0)};
}

vec3 areaVector(const shared::Triangle& t)
{
    return glm::cross(vec3(t.v1) - vec3(t.v0), vec3(t.v2) - vec3(t.v0)) / 2.0f;
}

/// Per solid angle what is 1 per area at the end of `way`.
double perSolidAngle(const shared::Triangle& t, vec3 way)
{
    const dvec3 w(way), n = glm::normalize(dvec3(areaVector(t)));
    return std::abs(glm::dot(n, w)) / std::pow(glm::length(w), 3);
}

vec2 uniformBarycentrics(Pcg32& random)
{
    const double root = std::sqrt(random());
    return {static_cast<float>(root * random()), static_cast<float>(1 - root)};
}

/// A place on a triangle as it is stored, and the way to it.
shared::ReuseSample sampleAt(const shared::Triangle& t, vec2 barycentrics, vec3 from, vec3& way)
{
    shared::ReuseSample r = shared::noReuseSample();
    r.slot = 0;
    r.place = shared::packPlace(barycentrics);
    r.u = 1;
    way = shared::pointOn(t, shared::unpackPlace(r.place)) - from;
    return r;
}

/// A sample that slides keeps its direction and its weight per solid angle, lies on its triangle,
/// and a new sample in its place is found to be one that slid there from where it was.
TEST(ReuseShift, SlidingKeepsDirectionAndWeight)
{
    Pcg32 random(53);
    int slid = 0, found = 0;
    for (int i = 0; i < 20000; ++i) {
        const shared::Triangle t = randomTriangle(random);
        const vec3 before = randomPoint(random) * 3.0f;
        const vec3 now = before + randomPoint(random) * 0.1f;
        vec3 way;
        shared::ReuseSample r = sampleAt(t, uniformBarycentrics(random), now, way);
        const vec3 wayBefore = way + (now - before);
        if (!shared::slidePlace(t, now, before, way, r)) {
            EXPECT_EQ(r.u, 1);
            continue;
        }
        ++slid;
        const float flat = std::abs(glm::dot(glm::normalize(areaVector(t)), glm::normalize(way)));
        if (flat < 0.1f || glm::length(wayBefore) < 0.1f) continue;  // float's errors grow there
        ASSERT_GT(glm::dot(glm::normalize(way), glm::normalize(wayBefore)), 1 - 1e-6f);
        ASSERT_NEAR(double(r.u) * perSolidAngle(t, way) / perSolidAngle(t, wayBefore), 1, 1e-3);
        const vec3 place = shared::pointOn(t, shared::unpackPlace(r.place));
        ASSERT_LT(glm::length(place - (now + way)), 1e-3f);
        vec3 from;
        if (!shared::hasSlid(t, now, before, way, from)) continue;  // at the edge
        ++found;
        ASSERT_LT(glm::length(from - wayBefore), 1e-3f);
    }
    EXPECT_GT(slid, 10000);
    EXPECT_GT(found, slid / 2);
}

bool isInside(vec2 b)
{
    return b.x >= 0 && b.y >= 0 && b.x + b.y <= 1;
}

/// In directions in which both first hits see the triangle, what slides covers what hasSlid tells
/// of, no more and no less. Both sides are estimated from places that are uniform over its area.
TEST(ReuseShift, OldAndNewSamplesAgreeOnWhatSlides)
{
    Pcg32 random(54);
    constexpr int kPlaces = 40000;
    double worst = 0;
    for (int k = 0; k < 20; ++k) {
        const shared::Triangle t{vec4(-1, 0, -1, 0), vec4(1, 0, -1, 0), vec4(-1, 0, 1, 0)};
        const vec3 before = randomPoint(random) + vec3(0, 2, 0);
        const vec3 now = before + 0.3f * randomPoint(random);
        std::array<double, 2> sum{}, squares{};
        const auto add = [&](size_t side, double value) {
            sum[side] += value / kPlaces;
            squares[side] += value * value / kPlaces;
        };
        for (int i = 0; i < kPlaces; ++i) {
            vec3 way, unused;
            float distance;
            vec2 from;
            shared::ReuseSample r = sampleAt(t, uniformBarycentrics(random), now, way);
            const bool slid = shared::hasSlid(t, now, before, way, unused) &&
                              shared::meetsPlane(t, before, way, distance, from) && isInside(from);
            add(0, slid ? perSolidAngle(t, way) : 0);
            r = sampleAt(t, uniformBarycentrics(random), now, way);
            const bool slides = shared::slidePlace(t, now, before, way, r) &&
                                isInside(shared::unpackPlace(r.place));
            add(1, slides ? double(r.u) * perSolidAngle(t, way) : 0);
        }
        const double variance = (squares[0] - sum[0] * sum[0] + squares[1] - sum[1] * sum[1]);
        const double z = (sum[0] - sum[1]) / std::sqrt(variance / kPlaces);
        worst = std::max(worst, std::abs(z));
        // Five per cent would be seen on every one of the triangles.
        EXPECT_LT(std::sqrt(variance / kPlaces), 0.01 * sum[0]);
    }
    EXPECT_LT(worst, 4.5);
}

TEST(ReuseShift, NothingSlidesAtRest)
{
    Pcg32 random(55);
    const shared::Triangle t = randomTriangle(random);
    const vec3 at = randomPoint(random) * 3.0f;
    vec3 way, unused;
    shared::ReuseSample r = sampleAt(t, {0.25f, 0.5f}, at, way);
    EXPECT_FALSE(shared::slidePlace(t, at, at, way, r));
    EXPECT_FALSE(shared::hasSlid(t, at, at, way, unused));
}

/// T-34. Over many frames the pixels that histories are taken from move as far as the picture does,
/// to within four pixels of hundreds, however many samples a frame takes; the nearest would not
/// move at all, and one at random would be ten pixels away.
TEST(ReuseShift, HistoriesKeepUpWithTheMotion)
{
    shared::ReuseSettings settings{};
    for (const float motion : {0.03f, 0.2f, 0.37f, 0.499f, 0.5f, 0.73f, 0.96f, 1.31f})
        for (uint32_t stride = 1; stride <= 4; ++stride) {
            double ahead = 0, most = 0;
            for (uint32_t frame = 0; frame < 500; ++frame) {
                shared::SampleStream stream{};
                stream.index = 17 + frame * stride;
                const glm::ivec2 pixel = shared::historyPixel(
                    {40.5f + motion, 40.5f - motion}, shared::tapNumbers(settings, stream, 1));
                ahead += pixel.x - 40 - double(motion);
                ASSERT_LE(std::abs(pixel.y - 40 + double(motion)), 1.001);
                most = std::max(most, std::abs(ahead));
            }
            EXPECT_LT(most, 4) << motion << " pixels a frame of " << stride << " samples";
        }
}

TEST(ReuseShift, WhatHasNotMovedIsItsOwnHistory)
{
    shared::ReuseSettings settings{};
    const auto find = [&](uint32_t index, vec2 film) {
        shared::SampleStream stream{};
        stream.index = index;
        return shared::historyPixel(film, shared::tapNumbers(settings, stream, 1));
    };
    for (uint32_t i = 0; i < 100000; ++i)
        ASSERT_EQ(find(i, {1900.5001f, 3.4999f}), glm::ivec2(1900, 3)) << i;
    settings.flags = shared::kReuseFollows;  // first hits anywhere in the pixel
    for (uint32_t i = 0; i < 1000; ++i) ASSERT_EQ(find(i, {7.01f, 3.99f}), glm::ivec2(7, 3));
}

}  // namespace

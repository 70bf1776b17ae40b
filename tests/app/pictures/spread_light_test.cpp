// Light of few pixels averaged over surfaces, on walls whose answer can be told beforehand.
#include "app/pictures/spread_light.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "app/pictures/preview_shading.h"
#include "core/base/parallel.h"
#include "core/methods/first_hits.h"
#include "shared/tonemap.h"

namespace {

constexpr uint32_t kWide = 96, kHigh = 64;

/// Looks along -Z at what is in front of it.
core::Camera ahead()
{
    core::Camera c;
    c.yfov = 0.8;
    return c;
}

/// A wall of that albedo, in a plane across the view, that a picture shows from x0 on.
void addWall(core::Aovs& aovs, uint32_t x0, float distance, float material, glm::vec3 albedo)
{
    const double half = std::tan(0.5 * ahead().yfov);
    for (uint32_t y = 0; y < kHigh; ++y)
        for (uint32_t x = x0; x < kWide; ++x) {
            const double u = half * kWide / kHigh * (2 * (x + 0.5) / kWide - 1),
                         v = half * (1 - 2 * (y + 0.5) / kHigh);
            *aovs.depth.at(x, y) = distance * static_cast<float>(std::sqrt(1 + u * u + v * v));
            const glm::vec3 normal(0, 0, 1), ids(0, material, -1);
            for (int c = 0; c < 3; ++c) {
                aovs.normal.at(x, y)[c] = normal[c];
                aovs.albedo.at(x, y)[c] = albedo[c];
                aovs.ids.at(x, y)[c] = ids[c];
            }
        }
}

core::Aovs wall(float albedo = 0.5f)
{
    core::Aovs aovs = core::emptyAovs(kWide, kHigh);
    addWall(aovs, 0, 3, 0, glm::vec3(albedo));
    return aovs;
}

void setLight(core::Image& mean, uint32_t x, uint32_t y, float value)
{
    for (int c = 0; c < 3; ++c) mean.at(x, y)[c] = value;
}

/// One pixel of `every` lit, in no order, from x0 to x1.
core::Image fewLit(uint32_t every, uint32_t x0 = 0, uint32_t x1 = kWide)
{
    core::Image mean(kWide, kHigh, 3);
    uint32_t state = 7;
    for (uint32_t y = 0; y < kHigh; ++y)
        for (uint32_t x = x0; x < x1; ++x) {
            state = state * 747796405u + 2891336453u;
            if ((state >> 16) % every == 0) setLight(mean, x, y, static_cast<float>(every));
        }
    return mean;
}

double meanOf(const core::Image& image, uint32_t x0 = 0, uint32_t x1 = kWide)
{
    double sum = 0;
    for (uint32_t y = 0; y < kHigh; ++y)
        for (uint32_t x = x0; x < x1; ++x) sum += double(image.at(x, y)[1]);
    return sum / (double(kHigh) * (x1 - x0));
}

double squaresAbout(double mean, const core::Image& image)
{
    double sum = 0;
    for (const float v : image.pixels) sum += std::pow(double(v) - mean, 2);
    return sum;
}

core::Image spread(core::Image mean, const core::Aovs& aovs)
{
    app::spreadLight(mean, aovs, ahead());
    return mean;
}

TEST(SpreadLight, WhatIsConstantStays)
{
    core::Image mean(kWide, kHigh, 3);
    for (float& v : mean.pixels) v = 0.7f;
    for (const float v : spread(mean, wall()).pixels) ASSERT_NEAR(v, 0.7f, 1e-5f);
}

TEST(SpreadLight, FewLitPixelsBecomeAnEvenWallOfTheSameLight)
{
    const core::Image before = fewLit(16), after = spread(before, wall());
    const double mean = meanOf(before);
    EXPECT_NEAR(meanOf(after), mean, 1e-4 * mean);
    const double was = squaresAbout(mean, before), is = squaresAbout(mean, after);
    EXPECT_LT(is, 0.02 * was) << "a standard deviation of 3.9 times the mean becomes one of 0.5";
}

TEST(SpreadLight, TexturesStay)
{
    core::Aovs aovs = wall();
    core::Image mean = fewLit(8);
    const auto albedo = [](uint32_t x, uint32_t y) { return (x + y) % 2 == 0 ? 0.8f : 0.2f; };
    for (uint32_t y = 0; y < kHigh; ++y)
        for (uint32_t x = 0; x < kWide; ++x)
            for (int c = 0; c < 3; ++c) {
                aovs.albedo.at(x, y)[c] = albedo(x, y);
                mean.at(x, y)[c] = albedo(x, y);
            }
    const core::Image after = spread(mean, aovs);
    for (size_t i = 0; i < after.pixels.size(); ++i)
        ASSERT_NEAR(after.pixels[i], mean.pixels[i], 1e-5f);
}

/// Light on the left wall; the right one is another by its material, its place or its normal.
TEST(SpreadLight, NoLightCrossesAnEdge)
{
    constexpr uint32_t kEdge = kWide / 2;
    for (const int other : {0, 1, 2}) {
        core::Aovs aovs = wall();
        addWall(aovs, kEdge, other == 1 ? 5 : 3, other == 0 ? 1 : 0, glm::vec3(0.5f));
        for (uint32_t y = 0; other == 2 && y < kHigh; ++y)
            for (uint32_t x = kEdge; x < kWide; ++x) {
                aovs.normal.at(x, y)[1] = 0.6f;
                aovs.normal.at(x, y)[2] = 0.8f;
            }
        const core::Image before = fewLit(8, 0, kEdge), after = spread(before, aovs);
        const core::Image lamp = app::litFromCamera(aovs, ahead());
        EXPECT_NEAR(meanOf(after, 0, kEdge), meanOf(before, 0, kEdge), 1e-4) << other;
        const float level = after.at(kEdge, 0)[0] / lamp.at(kEdge, 0)[0];
        for (uint32_t y = 0; y < kHigh; ++y)
            for (uint32_t x = kEdge; x < kWide; ++x)
                ASSERT_NEAR(after.at(x, y)[0], level * lamp.at(x, y)[0], 1e-5f)
                    << other << ": what is added, and nothing else";
        EXPECT_LE(double(level), meanOf(before) * 1.0001);
    }
}

TEST(SpreadLight, AddsNoMoreThanAFillOfUnlitPixels)
{
    for (const uint32_t every : {1u, 4u, 64u, 1024u, 4096u}) {
        core::Image before = fewLit(every), filled = before;
        setLight(before, 3, 3, 1);
        setLight(filled, 3, 3, 1);
        app::fillUnlit(filled, wall(), ahead());
        const double after = meanOf(spread(before, wall())), mean = meanOf(before);
        EXPECT_GE(after, 0.9999 * mean) << every;
        EXPECT_LE(after, 1.0001 * meanOf(filled)) << every;
    }
}

TEST(SpreadLight, QuietLightKeepsItsShadows)
{
    core::Image mean(kWide, kHigh, 3);
    for (uint32_t y = 0; y < kHigh; ++y)
        for (uint32_t x = 0; x < kWide; ++x) setLight(mean, x, y, x < kWide / 2 ? 1.0f : 0.05f);
    const core::Image after = spread(mean, wall());
    EXPECT_NEAR(after.at(kWide / 2 - 8, 9)[0], 1, 0.02f);
    EXPECT_NEAR(after.at(kWide / 2 + 8, 9)[0], 0.05f, 0.02f);
}

TEST(SpreadLight, LampsAndWhatIsBehindEverythingKeepTheirValues)
{
    core::Aovs aovs = wall();
    core::Image mean = fewLit(8);
    for (uint32_t y = 10; y < 20; ++y)
        for (uint32_t x = 10; x < 20; ++x) {
            aovs.ids.at(x, y)[2] = 0;
            setLight(mean, x, y, 40);
            *aovs.depth.at(x + 30, y) = 0;
            setLight(mean, x + 30, y, static_cast<float>(x));  // clouds
        }
    setLight(mean, 10, 15, 0);  // a path through its corner has met the wall
    const core::Image after = spread(mean, aovs);
    for (uint32_t y = 11; y < 19; ++y)
        for (uint32_t x = 10; x < 19; ++x) {
            EXPECT_EQ(after.at(x, y)[0], 40) << "also at its rim";
            if (x > 10) {
                EXPECT_EQ(after.at(x + 30, y)[0], mean.at(x + 30, y)[0]);
            }
        }
    EXPECT_LT(after.at(9, 15)[0], 10) << "no light of it spreads";
}

TEST(SpreadLight, WhatIsNoNumberStaysAlone)
{
    core::Image mean = fewLit(4);
    mean.at(30, 30)[1] = std::numeric_limits<float>::quiet_NaN();
    const core::Image after = spread(mean, wall());
    size_t none = 0;
    for (const float v : after.pixels) none += std::isnan(v);
    EXPECT_EQ(none, 1u);
    const core::Image black(kWide, kHigh, 3);
    EXPECT_EQ(spread(black, wall()).pixels, black.pixels) << "nobody knows how bright it is";
}

TEST(SpreadLight, IsTheSameWithOneThread)
{
    const core::Image many = spread(fewLit(8), wall());
    const core::ThreadLimit limit(1);
    EXPECT_EQ(spread(fewLit(8), wall()).pixels, many.pixels);
}

TEST(SpreadLight, PicturesOfAnySizeAreTaken)
{
    for (const glm::uvec2 size : {glm::uvec2(1, 1), glm::uvec2(1, 40), glm::uvec2(70, 1)}) {
        core::Aovs aovs = core::emptyAovs(size.x, size.y);
        for (float& d : aovs.depth.pixels) d = 1;
        for (float& a : aovs.albedo.pixels) a = 0.5f;
        core::Image mean(size.x, size.y, 3);
        for (float& v : mean.pixels) v = 2;
        app::spreadLight(mean, aovs, ahead());
        for (const float v : mean.pixels) EXPECT_NEAR(v, 2, 1e-5f);
    }
}

}  // namespace

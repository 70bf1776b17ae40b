// What first hits make of coarse pictures: numbers that can be told beforehand.
#include "app/pictures/preview_shading.h"

#include <gtest/gtest.h>

#include "core/methods/first_hits.h"

namespace {

/// Two pixels of a wall that faces the camera, one of a wall that is seen edge on, one emitter, one
/// of nothing.
core::Aovs firstHits()
{
    core::Aovs aovs = core::emptyAovs(5, 1);
    const auto set = [&](uint32_t x, glm::vec3 normal, glm::vec3 albedo, float emitter) {
        *aovs.depth.at(x, 0) = 2;
        for (int c = 0; c < 3; ++c) {
            aovs.normal.at(x, 0)[c] = normal[c];
            aovs.albedo.at(x, 0)[c] = albedo[c];
        }
        aovs.ids.at(x, 0)[2] = emitter;
    };
    set(0, {0, 0, 1}, {0.5f, 0.5f, 0.5f}, -1);
    set(1, {0, 0, -1}, {0.8f, 0.2f, 0}, -1);
    set(2, {0, 1, 0}, {0.5f, 0.5f, 0.5f}, -1);
    set(3, {0, 0, 1}, {0, 0, 0}, 4);
    return aovs;
}

/// Looks along -Z; so narrow that all rays do.
core::Camera camera()
{
    core::Camera c;
    c.yfov = 1e-4;
    return c;
}

TEST(PreviewShading, SurfacesAreLitFromTheCamera)
{
    const core::Aovs aovs = firstHits();
    const core::Image image = app::litFromCamera(aovs, camera());
    EXPECT_NEAR(image.at(0, 0)[0], 0.5f, 1e-3f);
    EXPECT_NEAR(image.at(1, 0)[0], 0.77f, 1e-3f) << "its back as well as its front";
    EXPECT_NEAR(image.at(1, 0)[2], 0.05f, 1e-3f) << "black things are seen, too";
    EXPECT_LT(image.at(2, 0)[0], 0.1f);
    EXPECT_GT(image.at(2, 0)[0], 0.05f);
    EXPECT_GT(image.at(3, 0)[0], 1);
    EXPECT_LT(image.at(4, 0)[0], image.at(2, 0)[0]) << "nothing hit";
}

TEST(PreviewShading, OnlySurfacesWithoutLightAreFilled)
{
    const core::Aovs aovs = firstHits();
    core::Image mean(5, 1, 3);
    for (int c = 0; c < 3; ++c) mean.at(0, 0)[c] = 4;
    core::Image filled = mean;
    app::fillUnlit(filled, aovs, camera());
    EXPECT_EQ(filled.at(0, 0)[0], 4) << "what has light keeps it";
    EXPECT_NEAR(filled.at(1, 0)[0], 0.8f * 0.77f, 1e-3f) << "the mean of the picture is 0.8";
    EXPECT_EQ(filled.at(4, 0)[0], 0) << "nothing hit stays black";
    core::Image black(5, 1, 3);
    app::fillUnlit(black, aovs, camera());
    EXPECT_EQ(black.pixels, core::Image(5, 1, 3).pixels) << "nobody knows how bright it is";
}

TEST(PreviewShading, TheGuideTellsWhichNeighboursAreOfTheSameSurface)
{
    core::Aovs aovs = firstHits();
    for (int c = 0; c < 3; ++c) aovs.normal.at(1, 0)[c] = aovs.normal.at(0, 0)[c];
    const core::Image guide = app::surfaceGuide(aovs);
    const auto alike = [&](uint32_t x, int dx) {
        return (static_cast<uint32_t>(*guide.at(x, 0)) >> (4 + dx) & 1) != 0;
    };
    for (uint32_t x = 0; x < 5; ++x) EXPECT_TRUE(alike(x, 0));
    EXPECT_TRUE(alike(0, 1) && alike(1, -1)) << "one wall";
    EXPECT_FALSE(alike(0, -1)) << "there is no pixel";
    EXPECT_FALSE(alike(1, 1) || alike(2, -1)) << "another normal";
    EXPECT_FALSE(alike(3, 1) || alike(4, -1)) << "nothing hit";
    *aovs.depth.at(1, 0) = 3;
    EXPECT_EQ(static_cast<uint32_t>(*app::surfaceGuide(aovs).at(0, 0)), 16u) << "too far behind";
}

TEST(PreviewShading, WhatIsMissingIsNoticed)
{
    const core::Aovs aovs = firstHits();
    EXPECT_TRUE(app::fits(aovs, core::Image(5, 1, 3)));
    EXPECT_FALSE(app::fits(aovs, core::Image(4, 1, 3)));
    EXPECT_FALSE(app::fits({}, core::Image(4, 1, 3)));
}

}  // namespace

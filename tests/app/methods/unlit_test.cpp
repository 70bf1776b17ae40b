// Surfaces without lighting (KHR_materials_unlit) in every method that renders light, on every
// device: they show their colour, light nothing, and are cut out by their alpha.
#include <array>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/methods/every_picture.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using namespace tests;

core::Material unlit(glm::vec3 colour)
{
    core::Material material = lambert(colour);
    material.data.flags |= shared::kMaterialUnlit | shared::kMaterialDoubleSided;
    return material;
}

TEST(Unlit, SurfacesShowTheirColour)
{
    SceneBuilder b;
    b.quad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.material(unlit({0.6f, 0.3f, 0.9f})));
    b.camera({0, 0, 4}, {0, 0, 0}, 0.6);
    constexpr std::array kColour{0.6f, 0.3f, 0.9f};
    forEachPicture(b.world(), {8, 8}, 4, [&](const PictureTaken& picture) {
        const std::vector<float>& pixels = picture.estimate.mean.pixels;
        for (size_t i = 0; i < pixels.size(); ++i)
            ASSERT_NEAR(pixels[i], kColour[i % 3], 1e-6) << picture.where;
    });
}

TEST(Unlit, SurfacesLightNothing)
{
    SceneBuilder b;
    b.quad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.material(lambert(glm::vec3(0.8f))));
    core::Material shining = unlit(glm::vec3(1));  // whatever else it says
    shining.data.emissive = glm::vec3(3);
    b.quad({-9, -9, 5}, {18, 0, 0}, {0, 18, 0}, b.material(shining));
    b.camera({0, 0, 4}, {0, 0, 0}, 0.6);
    EXPECT_TRUE(b.world()->emitters.empty());
    forEachPicture(b.world(), {8, 8}, 4, [](const PictureTaken& picture) {
        for (const float value : picture.estimate.mean.pixels) ASSERT_EQ(value, 0) << picture.where;
    });
}

/// Nor where paths look for the light that virtual lights near a surface lose: a wall with a board
/// on it that cannot be seen, for the camera lies in its plane, is as if the board were black.
TEST(Unlit, SurfacesLightNothingNearBy)
{
    std::map<std::string, std::vector<float>> found[2];
    for (const bool black : {false, true}) {
        SceneBuilder b;
        b.quad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.material(lambert(glm::vec3(0.8f))));
        const core::Material board = black ? lambert(glm::vec3(0)) : unlit(glm::vec3(1));
        b.quad({0, -9, 0}, {0, 18, 0}, {0, 0, 2}, b.material(board));
        b.quad({-1, -1, 6}, {2, 0, 0}, {0, 2, 0},
               b.material(emitter(glm::vec3(20), glm::vec3(0.3f), true)));
        b.camera({0, 0, 4}, {0, 0, 0}, 0.6);
        forEachPicture(b.world(), {8, 8}, 4, [&](const PictureTaken& picture) {
            if (picture.where.find("manylights") != std::string::npos)
                found[black][picture.where] = picture.estimate.mean.pixels;
        });
    }
    ASSERT_FALSE(found[0].empty());
    EXPECT_GT(found[0].begin()->second[0], 0);
    EXPECT_EQ(found[0], found[1]);
}

TEST(Unlit, SurfacesAreCutOutByTheirAlpha)
{
    SceneBuilder b;
    core::Material hole = unlit(glm::vec3(1));
    hole.data.alpha = 0.2f;
    hole.data.alphaCutoff = 0.5f;
    hole.data.flags |= shared::kMaterialAlphaMask;
    b.quad({-9, -9, 0}, {18, 0, 0}, {0, 18, 0}, b.material(hole));
    b.constantEnvironment(glm::vec3(0.25f));
    b.camera({0, 0, 4}, {0, 0, 0}, 0.6);
    forEachPicture(b.world(), {8, 8}, 4, [](const PictureTaken& picture) {
        for (const float value : picture.estimate.mean.pixels)
            ASSERT_NEAR(value, 0.25, 1e-6) << picture.where;
    });
}

}  // namespace

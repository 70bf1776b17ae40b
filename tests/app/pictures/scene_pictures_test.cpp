// Small pictures of scenes: what of a picture they hold, that they are found again, when a session
// keeps them.
#include "app/pictures/scene_pictures.h"

#include <algorithm>

#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/session_steps.h"

namespace {

using namespace tests;
using app::ScenePictures, app::SmallPicture;

using Rgb = std::array<int, 3>;

Rgb pixel(const SmallPicture& p, uint32_t x, uint32_t y)
{
    const uint8_t* at = &p.bytes.at(3 * (size_t(y) * SmallPicture::kWidth + x));
    return {at[0], at[1], at[2]};
}

core::Image painted(uint32_t width, uint32_t height, const std::function<glm::vec3(glm::vec2)>& of)
{
    core::Image image(width, height, 3);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const glm::vec3 c = of((glm::vec2(x, y) + 0.5f) / glm::vec2(width, height));
            std::copy_n(&c.x, 3, image.at(x, y));
        }
    return image;
}

app::ViewParams linearView(float exposure = 0)
{
    app::ViewParams view;
    view.tone = app::Tone::linear;
    view.exposure = exposure;
    return view;
}

TEST(SmallPictures, HoldTheMiddleInTheProportionsOfATile)
{
    // Outside of the middle 16 : 9 it is red, there it is green on the left and blue on the right.
    for (const glm::uvec2 size : {glm::uvec2(3200, 900), glm::uvec2(800, 900), glm::uvec2(7, 9)}) {
        const double all = static_cast<double>(size.x) / size.y, wanted = 16.0 / 9;
        const glm::vec2 half(0.5 * std::min(1.0, wanted / all), 0.5 * std::min(1.0, all / wanted));
        const SmallPicture small = app::smallPicture(
            painted(size.x, size.y,
                    [&](glm::vec2 p) {
                        const glm::vec2 off = glm::abs(p - 0.5f);
                        if (off.x > half.x + 0.08f || off.y > half.y + 0.08f)
                            return glm::vec3(1, 0, 0);
                        return p.x < 0.5f ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
                    }),
            linearView());
        ASSERT_TRUE(small);
        for (uint32_t y = 0; y < SmallPicture::kHeight; ++y) {
            EXPECT_EQ(pixel(small, 0, y), (Rgb{0, 255, 0})) << size.x;
            EXPECT_EQ(pixel(small, SmallPicture::kWidth - 1, y), (Rgb{0, 0, 255})) << size.x;
        }
    }
}

TEST(SmallPictures, AreAsTheWindowShowsTheScene)
{
    const core::Image grey = painted(128, 72, [](glm::vec2) { return glm::vec3(0.2140411f); });
    EXPECT_EQ(pixel(app::smallPicture(grey, linearView()), 20, 10), (Rgb{127, 127, 127}));
    const int brighter = pixel(app::smallPicture(grey, linearView(1)), 20, 10)[0];
    EXPECT_EQ(brighter, 175);  // twice the radiance: sRGB of .428
    // One very bright pixel of the picture is bright where it is, and nowhere else.
    core::Image spark = grey;
    std::fill_n(spark.at(64, 36), 3, 1e9f);
    const SmallPicture small = app::smallPicture(spark, linearView());
    for (uint32_t y = 0; y < SmallPicture::kHeight; ++y)
        for (uint32_t x = 0; x < SmallPicture::kWidth; ++x) {
            if (x >= 31 && x <= 33 && y >= 17 && y <= 19) continue;
            ASSERT_EQ(pixel(small, x, y)[0], 127) << x << ' ' << y;
        }
}

TEST(SmallPictures, AreFoundByTheirScene)
{
    const TemporaryFolder folder;
    const SmallPicture dark = app::smallPicture(
                           painted(16, 9, [](glm::vec2) { return glm::vec3(0); }), linearView()),
                       light = app::smallPicture(
                           painted(16, 9, [](glm::vec2) { return glm::vec3(1); }), linearView());
    const ScenePictures pictures(folder / "cache");
    EXPECT_FALSE(pictures.find("/a/room.glb"));
    pictures.keep("/a/room.glb", dark);
    pictures.keep("/b/room.glb", dark);
    pictures.keep("/a/room.glb", light);
    EXPECT_EQ(ScenePictures(folder / "cache").find("/a/../a/room.glb").bytes, light.bytes);
    EXPECT_EQ(pictures.find("/b/room.glb").bytes, dark.bytes);
    EXPECT_FALSE(pictures.find("/a/room2.glb"));

    const ScenePictures nowhere{fs::path()};
    nowhere.keep("/a/room.glb", dark);
    EXPECT_FALSE(nowhere.find("/a/room.glb"));
    core::writeFile(folder / "file", "in the way");
    ScenePictures(folder / "file").keep("/a/room.glb", dark);  // says nothing
}

TEST(SmallPictures, ASessionKeepsThatOfAllScenesItLeaves)
{
    const TemporaryFolder folder;
    const ScenePictures pictures(folder / "cache");
    app::SessionOptions o = options("cornell-diffuse.gltf");
    o.cacheFolder = folder / "cache";
    {
        Session session(o);  // keeps no settings, and so nothing else
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
    }
    EXPECT_FALSE(pictures.find(kAssets / "cornell-diffuse.gltf"));
    o.settings = folder / "settings.json";
    {
        Session session(o);
        ASSERT_TRUE(until(session, [&] { return settled(session); }));
        session.load(kAssets / "hall.gltf");
        ASSERT_TRUE(until(session, [&] {
            return settled(session) && session.document()->file.filename() == "hall.gltf";
        }));
        EXPECT_TRUE(pictures.find(kAssets / "cornell-diffuse.gltf"));
        EXPECT_FALSE(pictures.find(kAssets / "hall.gltf"));
    }
    const SmallPicture box = pictures.find(kAssets / "cornell-diffuse.gltf");
    ASSERT_TRUE(pictures.find(kAssets / "hall.gltf"));
    EXPECT_NE(pictures.find(kAssets / "hall.gltf").bytes, box.bytes);
    // A red wall on the left, a green one on the right, beside which there is nothing.
    const Rgb left = pixel(box, 17, 18), right = pixel(box, SmallPicture::kWidth - 18, 18);
    EXPECT_GT(left[0], left[1] + 20);
    EXPECT_GT(right[1], right[0] + 20);
}

}  // namespace

// What is around a scene: its own environment and sun, what is asked for instead, and what is
// refused (B46).
#include <set>

#include "tests/support/scenes/gltf_fixture.h"

namespace {

using test::Json;

TEST(GltfEnvironment, EnvironmentAndSunAreReadFromExtras)
{
    const test::TemporaryFolder folder;
    folder.write("sky.hdr", test::encodeImage("hdr", 4, 2, 3, std::vector<float>(24, 0.5f)));
    test::Document document = test::triangle();
    document.json["scenes"][0]["extras"] = {
        {"environment", {{"uri", "sky.hdr"}, {"mapping", "latlong"}, {"intensity", 2.5}}},
        {"sun",
         {{"directionTowardsSun", {0, 3, 4}}, {"angularRadius", 0.01}, {"radiance", {1, 2, 3}}}}};
    const auto scene = core::loadGltf(folder.write("scene.gltf", document.text()));
    EXPECT_EQ(scene->warnings.total(), 0u);
    ASSERT_TRUE(scene->environment);
    EXPECT_EQ(scene->environment->width, 4u);
    EXPECT_EQ(scene->environment->height, 2u);
    EXPECT_EQ(scene->environment->intensity, 2.5f);
    EXPECT_NEAR(scene->environment->texels.at(7).y, 0.5, 0.01);
    ASSERT_TRUE(scene->sun);
    EXPECT_NEAR(scene->sun->directionTowards.y, 0.6, 1e-6);
    EXPECT_EQ(scene->sun->radiance, glm::vec3(1, 2, 3));
    EXPECT_EQ(scene->sun->angularRadius, 0.01f);
}

/// What is asked for takes the place of environment and sun; a plain sky comes unasked where
/// nothing else shines, and then only where any will do.
TEST(GltfEnvironment, AnotherEnvironmentThanTheScenesOwn)
{
    const test::TemporaryFolder folder;
    folder.write("sky.hdr", test::encodeImage("hdr", 4, 2, 3, std::vector<float>(24, 0.5f)));
    const auto panorama =
        folder.write("room.hdr", test::encodeImage("hdr", 8, 4, 3, std::vector<float>(96, 2.0f)));
    const test::Document dark = test::triangle();
    test::Document outside = dark, shining = dark, unlit = dark;
    outside.json["scenes"][0]["extras"] = {{"environment", {{"uri", "sky.hdr"}}},
                                           {"sun", {{"radiance", {1, 2, 3}}}}};
    shining.json["materials"] = {{{"emissiveFactor", {0, 1, 0}}}};
    shining.json["meshes"][0]["primitives"][0]["material"] = 0;
    unlit.json["materials"] = {{{"extensions", {{"KHR_materials_unlit", Json::object()}}}}};
    unlit.json["extensionsUsed"] = {"KHR_materials_unlit"};
    unlit.json["meshes"][0]["primitives"][0]["material"] = 0;
    const auto load = [&](const test::Document& document, const std::string& environment) {
        core::LoadOptions options;
        options.environment = environment;
        return core::loadGltf(folder.write("scene.gltf", document.text()), options);
    };
    const auto nameOf = [&](const test::Document& document, const std::string& environment) {
        const auto scene = load(document, environment);
        EXPECT_EQ(scene->warnings.total(), 0u);
        return scene->environment ? scene->environment->file : "";
    };
    EXPECT_EQ(nameOf(dark, core::kAnyEnvironment), core::kPlainSky);
    EXPECT_EQ(nameOf(dark, core::kOwnEnvironment), "");
    EXPECT_EQ(nameOf(dark, core::kNoEnvironment), "");
    for (const test::Document* document : {&shining, &unlit}) {
        EXPECT_EQ(nameOf(*document, core::kAnyEnvironment), "");
        EXPECT_EQ(nameOf(*document, core::kPlainSky), core::kPlainSky);
    }
    EXPECT_EQ(nameOf(outside, core::kAnyEnvironment), "sky.hdr");
    EXPECT_TRUE(load(outside, core::kAnyEnvironment)->sun);
    EXPECT_EQ(nameOf(outside, core::kNoEnvironment), "");
    EXPECT_FALSE(load(outside, core::kNoEnvironment)->sun);
    EXPECT_EQ(nameOf(outside, panorama.string()), panorama.string());
    EXPECT_NEAR(load(outside, panorama.string())->environment->texels.at(3).x, 2, 0.05);

    // Pictures of one are no references for another.
    std::set<std::string> hashes;
    for (const std::string& what :
         {std::string(core::kOwnEnvironment), std::string(core::kNoEnvironment),
          std::string(core::kPlainSky), panorama.string()})
        hashes.insert(load(outside, what)->hash);
    EXPECT_EQ(hashes.size(), 4u);
    EXPECT_EQ(load(outside, core::kAnyEnvironment)->hash,
              load(outside, core::kOwnEnvironment)->hash);

    // What is shown counts, not how it was asked for.
    EXPECT_EQ(load(dark, core::kAnyEnvironment)->hash, load(dark, core::kPlainSky)->hash);
    EXPECT_EQ(load(dark, panorama.string())->hash,
              load(dark, (folder.path() / "." / "room.hdr").string())->hash);
    EXPECT_NE(load(dark, panorama.string())->hash,
              load(dark, (folder.path() / "sky.hdr").string())->hash);

    // The scene's own is not looked for where another takes its place, and may be black.
    test::Document lost = outside, black = dark;
    lost.json["scenes"][0]["extras"]["environment"]["uri"] = "lost.hdr";
    EXPECT_EQ(nameOf(lost, core::kPlainSky), core::kPlainSky);
    EXPECT_EQ(nameOf(lost, core::kNoEnvironment), "");
    black.json["scenes"][0]["extras"]["environment"] = {{"uri", "sky.hdr"}, {"intensity", 0}};
    EXPECT_EQ(nameOf(black, core::kAnyEnvironment), core::kPlainSky);

    core::LoadOptions missing;
    missing.environment = (folder.path() / "none.exr").string();
    const std::string refused =
        test::fileRefusal(folder.write("scene.gltf", dark.text()), missing).message;
    EXPECT_NE(refused.find("none.exr"), std::string::npos) << refused;
    EXPECT_TRUE(refused.ends_with(" — give the file of a panorama, or plain, none, own or auto"))
        << refused;
}

/// What has a factor but gives no light: under a black pattern, under one of other colours than the
/// factor's, on lines, which are not shown.
TEST(GltfEnvironment, WhatGivesNoLightDoesNotShine)
{
    core::LoadOptions options;
    options.environment = core::kAnyEnvironment;
    const auto sky = [&](const test::Document& document) {
        const auto scene = test::load(document, options);
        return scene && scene->environment ? scene->environment->file : "";
    };
    const auto patterned = [](const std::vector<uint8_t>& pixel, const std::vector<double>& f) {
        test::Document document = test::texturedTriangle(test::encodeImage("png", 1, 1, 3, pixel));
        document.material() = {{"emissiveFactor", f}, {"emissiveTexture", {{"index", 0}}}};
        return document;
    };
    EXPECT_EQ(sky(patterned({0, 0, 0}, {1, 1, 1})), core::kPlainSky);
    EXPECT_EQ(sky(patterned({0, 255, 0}, {1, 0, 1})), core::kPlainSky);
    EXPECT_EQ(sky(patterned({0, 1, 0}, {1, 1, 1})), "");
    EXPECT_EQ(sky(patterned({0, 1, 0}, {0, 0.5, 0})), "");

    test::Document lines = test::triangle();
    lines.json["materials"] = {{{"emissiveFactor", {1, 1, 1}}},
                               {{"extensions", {{"KHR_materials_unlit", Json::object()}}}}};
    for (const int material : {0, 1}) {
        Json primitive = lines.primitive();
        primitive["mode"] = 1;
        primitive["material"] = material;
        lines.json["meshes"][0]["primitives"].push_back(primitive);
    }
    EXPECT_EQ(sky(lines), core::kPlainSky);
    lines.primitive()["material"] = 0;
    EXPECT_EQ(sky(lines), "");
}

/// glTF lets `extras` hold any value: those of other tools are no faults of the file.
TEST(GltfEnvironment, ExtrasOfOtherToolsAreLeftAlone)
{
    core::LoadOptions strict;
    strict.strict = true;
    for (const Json& extras : {Json(7), Json("forest"), Json(true), Json(), Json::array({1, 2})}) {
        test::Document document = test::triangle();
        document.json["scenes"][0]["extras"] = extras;
        document.json["cameras"] = {{{"type", "perspective"},
                                     {"perspective", {{"yfov", 1}, {"znear", 0.1}}},
                                     {"extras", extras}}};
        document.json["nodes"][0]["camera"] = 0;
        const auto scene = test::load(document, strict);
        ASSERT_TRUE(scene) << extras;
        EXPECT_EQ(scene->cameras.at(0).yfov, 1);
    }
    test::Document document = test::triangle();
    document.json["scenes"][0]["extras"] = {{"environment", {{"fog", 0.5}}},
                                            {"sun", {{"radiance", {1, 2, 3}}}}};
    EXPECT_REPAIRED(scene, document, "UNDEFINED_PROPERTY", "/scenes/0/extras/environment");
    EXPECT_FALSE(scene->environment);
    EXPECT_TRUE(scene->sun);
}

TEST(GltfEnvironment, BrokenEnvironmentsAreRefused)
{
    const test::TemporaryFolder folder;
    test::Document document = test::triangle();
    document.json["scenes"][0]["extras"]["environment"]["uri"] = "sky.hdr";
    const auto file = folder.write("scene.gltf", document.text());
    const std::string pointer = "/scenes/0/extras/environment/uri";
    EXPECT_EQ(test::fileRefusal(file).pointer, pointer) << "missing";
    folder.write("sky.hdr",
                 std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n"));
    EXPECT_EQ(test::fileRefusal(file).code, "IMAGE_UNUSABLE");
    const std::vector<std::byte> exr =
        test::encodeImage("exr", 8, 8, 3, std::vector<float>(192, 1));
    folder.write("sky.hdr", std::span(exr).first(exr.size() / 2));
    EXPECT_EQ(test::fileRefusal(file).pointer, pointer) << "truncated";
}

}  // namespace

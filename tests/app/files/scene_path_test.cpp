// What is meant by the name of a scene: files, folders that hold one, names that are nearly right.
#include "app/files/scene_path.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "app/files/folder_list.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"

namespace {

namespace fs = std::filesystem;

class ScenePath : public testing::Test {
protected:
    void make(const std::string& name)
    {
        fs::create_directories((folder_ / name).parent_path());
        core::writeFile(folder_ / name, "x");
    }

    std::string refusal(const std::string& name) const
    {
        try {
            app::scenePath(folder_ / name);
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::badInput);
            return error.what();
        }
        return {};
    }

    tests::TemporaryFolder folder_;
};

TEST_F(ScenePath, AFolderMeansItsOnlyScene)
{
    make("kitchen/Kitchen.GLB");
    make("kitchen/textures/tile.png");
    make("kitchen/notes.txt");
    EXPECT_EQ(app::scenePath(folder_ / "kitchen"), folder_ / "kitchen" / "Kitchen.GLB");
    EXPECT_EQ(app::scenePath(folder_ / "kitchen" / "Kitchen.GLB"),
              folder_ / "kitchen" / "Kitchen.GLB");
    make("kitchen/attic.gltf");
    EXPECT_EQ(refusal("kitchen"), (folder_ / "kitchen").string() +
                                      ": is a folder with 2 scenes — give one of them: "
                                      "attic.gltf, Kitchen.GLB");
    EXPECT_NE(refusal("kitchen/textures").find("without a scene"), std::string::npos);
}

TEST_F(ScenePath, FilesByTheirExtensionAndFoldersMayBeScenes)
{
    make("kitchen/tile.png");
    for (const char* name : {"a.gltf", "b.GLB", "kitchen"})
        EXPECT_TRUE(app::mayBeScene(folder_ / name)) << name;
    for (const char* name : {"a.exr", "gltf", "nowhere", "kitchen/tile.png"})
        EXPECT_FALSE(app::mayBeScene(folder_ / name)) << name;
}

TEST_F(ScenePath, TheNearestNameIsProposed)
{
    make("staircase.gltf");
    make("sponza.gltf");
    EXPECT_EQ(refusal("stiarcase.gltf"), (folder_ / "stiarcase.gltf").string() +
                                             ": no such file; did you mean " +
                                             (folder_ / "staircase.gltf").string() + "?");
    EXPECT_EQ(refusal("unlike.bin"), (folder_ / "unlike.bin").string() + ": no such file");
    EXPECT_EQ(refusal("none/x.gltf"), (folder_ / "none/x.gltf").string() + ": no such file");
}

TEST_F(ScenePath, WhatIsNeitherFileNorFolderIsLeftToTheLoader)
{
    EXPECT_EQ(app::scenePath("/dev/null"), "/dev/null");
}

TEST_F(ScenePath, ListsSayWhatIsThere)
{
    make("b.glb");
    make("A.gltf");
    make("deep/c.glb");
    make(".hidden.glb");
    make("text.txt");
    const auto entries = app::listFolder(folder_.path(), app::sceneExtensions());
    ASSERT_EQ(entries.size(), 3u);
    EXPECT_EQ(entries[0].name, "A.gltf");
    EXPECT_EQ(entries[0].bytes, 1u);
    EXPECT_EQ(entries[1].name, "b.glb");
    EXPECT_EQ(entries[2].name, "deep");
    EXPECT_TRUE(entries[2].folder && !entries[1].folder);
    const auto hidden =
        app::listFolder(folder_.path(), app::sceneExtensions(), app::HiddenNames::alone);
    ASSERT_EQ(hidden.size(), 1u);
    EXPECT_EQ(hidden[0].name, ".hidden.glb");
    EXPECT_TRUE(app::listFolder(folder_ / "none", {}).empty());
}

}  // namespace

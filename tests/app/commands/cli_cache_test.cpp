// What the program keeps for the next run (N25): a hierarchy that an earlier run has left in the
// user's cache folder is used and gives the same picture to the bit; --no-cache does without; a
// folder that cannot be had is no reason to say anything.
#include "core/gltf/gltf.h"
#include "core/trace/world_bvh.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;

class CliCache : public Cli {
protected:
    CliCache() { fs::create_directories(cache()); }

    fs::path cache() const { return work("cache"); }

    /// As if building had taken long in an earlier run.
    void leaveHierarchy() const
    {
        core::BvhCache files(cache() / "rekindle", 0);
        core::bvhOf(*core::makeWorld(core::loadGltf(kScene)), {}, {}, &files);
    }

    /// Renders on Vulkan; returns its statistics.
    Json render(const Strings& more = {}, const std::string& folder = {})
    {
        const Result result =
            run(smallRender("vulkan", "box.exr") + Strings{"--stats", "stats.json"} + more,
                {"XDG_CACHE_HOME=" + (folder.empty() ? cache().string() : folder)});
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_FALSE(contains(result.err, "cache")) << result.err;
        return Json::parse(readAll(work("stats.json")));
    }
};

TEST_F(CliCache, AHierarchyOfAnEarlierRunGivesTheSamePicture)
{
    EXPECT_FALSE(render()["hierarchy_cached"].get<bool>());
    const core::Image built = core::readExr(work("box.exr")).layer("");
    leaveHierarchy();
    EXPECT_TRUE(render()["hierarchy_cached"].get<bool>());
    EXPECT_EQ(core::readExr(work("box.exr")).layer("").pixels, built.pixels);
    EXPECT_FALSE(render({"--no-cache"})["hierarchy_cached"].get<bool>());
    EXPECT_EQ(core::readExr(work("box.exr")).layer("").pixels, built.pixels);
}

TEST_F(CliCache, ADamagedFileIsRemovedWithoutAWord)
{
    leaveHierarchy();
    const fs::path file = fs::directory_iterator(cache() / "rekindle")->path();
    std::string bytes = readAll(file);
    bytes[bytes.size() / 2] ^= 1;
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_FALSE(render()["hierarchy_cached"].get<bool>());
    EXPECT_FALSE(fs::exists(file));
}

TEST_F(CliCache, AFolderThatCannotBeHadIsNoFailure)
{
    for (const char* folder : {"/proc/nowhere", "/dev/null"})
        EXPECT_FALSE(render({}, folder)["hierarchy_cached"].get<bool>()) << folder;
}

}  // namespace

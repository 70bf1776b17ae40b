// The hierarchies of worlds in a cache (N25): a second run reads what the first one built, whatever
// has become of the file in between it gets a sound one, and neither quick builds nor poses of an
// animation fill the folder.
#include <gtest/gtest.h>

#include <fstream>

#include "core/trace/world_bvh.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"
#include "tests/support/scenes/animated_scenes.h"
#include "tests/support/scenes/meshes.h"

namespace {

namespace fs = std::filesystem;
using core::Bvh;
using core::BvhCache;
using tests::readAll;
using tests::TemporaryFolder;
using Bytes = std::vector<std::byte>;

/// What bvhOf makes of a new world with a cache that keeps everything, and whether it was found.
Bytes made(const fs::path& folder, bool& found, uint32_t seed = 1)
{
    BvhCache cache(folder, 0);
    const auto bvh = core::bvhOf(*tests::worldOf(tests::soupMesh(400, 0.2f, seed)), {}, {}, &cache);
    found = cache.found();
    return core::bvhBytes(*bvh);
}

TEST(BvhCache, ASecondRunReadsWhatTheFirstOneBuilt)
{
    const TemporaryFolder folder;
    bool found = true;
    const Bytes built = made(folder.path(), found);
    EXPECT_FALSE(found);
    EXPECT_EQ(folder.count(), 1u);
    EXPECT_EQ(made(folder.path(), found), built);
    EXPECT_TRUE(found);
    EXPECT_NE(made(folder.path(), found, 2), built);
    EXPECT_FALSE(found) << "other triangles";
    EXPECT_EQ(folder.count(), 2u);
    EXPECT_EQ(made({}, found), built);
    EXPECT_FALSE(found) << "without a folder";
}

TEST(BvhCache, WhateverTheFileHoldsTheHierarchyIsSound)
{
    const TemporaryFolder folder;
    bool found = false;
    const Bytes built = made(folder.path(), found);
    const fs::path file = fs::directory_iterator(folder.path())->path();
    const std::string whole = readAll(file);
    for (size_t i = 0; i <= whole.size(); i += 199) {
        for (const bool cut : {false, true}) {
            std::string damaged = cut ? whole.substr(0, i) : whole;
            if (!cut) damaged[std::min(i, whole.size() - 1)] ^= 0x20;
            std::ofstream(file, std::ios::binary) << damaged << (i == 0 && cut ? "nothing" : "");
            EXPECT_EQ(made(folder.path(), found), built);
            EXPECT_EQ(found, cut && i == whole.size()) << i;
            EXPECT_EQ(readAll(file), whole) << "it is kept anew";
        }
    }
}

/// Right in size, checksum and key, but of other triangles: made so by hand.
TEST(BvhCache, AForeignTreeUnderTheRightKeyIsRemoved)
{
    const TemporaryFolder folder;
    const auto world = tests::worldOf(tests::soupMesh(400, 0.2f, 1));
    const auto other = tests::worldOf(tests::soupMesh(400, 0.2f, 2));
    const core::BvhKey key = core::bvhKey(world->positions, world->triangles, {});
    const core::CacheFolder files(folder.path(), "hierarchy", BvhCache::kMostBytes);
    files.write(std::as_bytes(std::span(&key, 1)), core::bvhBytes(*core::bvhOf(*other)));
    ASSERT_EQ(folder.count(), 1u);
    BvhCache cache(folder.path(), 1e9);
    const auto bvh = core::bvhOf(*world, {}, {}, &cache);
    EXPECT_FALSE(cache.found());
    EXPECT_EQ(core::bvhBytes(*bvh),
              core::bvhBytes(*core::bvhOf(*tests::worldOf(tests::soupMesh(400, 0.2f, 1)))));
    EXPECT_EQ(folder.count(), 0u);
}

TEST(BvhCache, WhatIsBuiltQuicklyIsNotKept)
{
    const TemporaryFolder folder;
    BvhCache cache(folder.path(), 1e9);
    core::bvhOf(*tests::worldOf(tests::soupMesh(400, 0.2f, 1)), {}, {}, &cache);
    EXPECT_EQ(folder.count(), 0u);
}

TEST(BvhCache, PosesAreNotKept)
{
    for (const tests::SceneBuilder& scene : {tests::movingRoom(), tests::vanishingRoom()}) {
        const TemporaryFolder folder;
        BvhCache cache(folder.path(), 0);
        const auto world = scene.world();
        core::bvhOf(*world, {}, {}, &cache);
        EXPECT_EQ(folder.count(), 1u);
        for (const double time : {0.5, 1.5, 2.5}) {
            const auto pose = core::poseWorld(world, time);
            EXPECT_GT(core::bvhOf(*pose, {}, {}, &cache)->nodeCount(), 0u);
        }
        EXPECT_EQ(folder.count(), 1u);
        core::bvhOf(*scene.world(), {}, {}, &cache);
        EXPECT_TRUE(cache.found()) << "the same scene in another run";
    }
}

}  // namespace

// Completion of typed paths.
#include "app/files/path_completion.h"

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/base/files.h"
#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"

namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

const Strings kScenes{".gltf", ".glb"};

class PathCompletion : public testing::Test {
protected:
    PathCompletion()
    {
        fs::create_directories(folder_ / "rooms" / "deep");
        fs::create_directories(folder_ / "Zoo");
        fs::create_directories(folder_ / ".hidden");
        for (const char* name :
             {"room.glb", "rock.gltf", "ROOM2.GLB", "notes.txt", ".secret.glb", "rooms/hall.glb"})
            core::writeFile(folder_ / name, "x");
        fs::create_symlink(folder_ / "nowhere", folder_ / "rolink.glb");
        fs::create_symlink(folder_ / "rooms", folder_ / "rolinked");
    }

    /// Completions below the folder, without its name.
    Strings complete(const std::string& typed, const Strings& extensions = kScenes)
    {
        const std::string base = folder_.path().string() + '/';
        Strings found = app::completePath(base + typed, extensions);
        for (std::string& name : found) {
            EXPECT_EQ(name.rfind(base, 0), 0u) << name;
            name.erase(0, base.size());
        }
        return found;
    }

    tests::TemporaryFolder folder_;
};

TEST_F(PathCompletion, ScenesFirstThenFoldersSorted)
{
    EXPECT_EQ(complete(""),
              (Strings{"rock.gltf", "room.glb", "ROOM2.GLB", "rolinked/", "rooms/", "Zoo/"}));
    EXPECT_EQ(complete("roo"), (Strings{"room.glb", "rooms/"}));
    EXPECT_EQ(complete("room."), (Strings{"room.glb"}));
    EXPECT_EQ(complete("rooms/"), (Strings{"rooms/hall.glb", "rooms/deep/"}));
    EXPECT_EQ(complete("n"), Strings{});
    EXPECT_EQ(complete("n", {}), (Strings{"notes.txt"}));
    EXPECT_EQ(complete("n", {".txt"}), (Strings{"notes.txt"}));
}

TEST_F(PathCompletion, CaseIsIgnoredWhereNothingElseFits)
{
    EXPECT_EQ(complete("ROO"), (Strings{"ROOM2.GLB"}));
    EXPECT_EQ(complete("zo"), (Strings{"Zoo/"}));
    EXPECT_EQ(complete("ROCK"), (Strings{"rock.gltf"}));
}

TEST_F(PathCompletion, HiddenNamesOnlyWhenTyped)
{
    EXPECT_EQ(complete("."), (Strings{".secret.glb", ".hidden/"}));
    EXPECT_EQ(complete(".s"), (Strings{".secret.glb"}));
}

TEST_F(PathCompletion, HomeAndTheCurrentFolder)
{
    const char* old = std::getenv("HOME");
    const std::string kept = old != nullptr ? old : "";
    const std::string home = folder_.path().string();
    setenv("HOME", home.c_str(), 1);
    EXPECT_EQ(app::completePath("~/roc", kScenes), (Strings{home + "/rock.gltf"}));
    EXPECT_EQ(app::completePath("~", kScenes).size(), 6u);
    EXPECT_EQ(app::expandHome("~/x"), home + "/x");
    EXPECT_EQ(app::expandHome("~other/x"), "~other/x");  // somebody else's is not looked for
    EXPECT_EQ(app::expandHome("a~/x"), "a~/x");
    unsetenv("HOME");
    EXPECT_EQ(app::expandHome("~/x"), "~/x");
    EXPECT_EQ(app::completePath("~/", kScenes), Strings{});
    if (old != nullptr) setenv("HOME", kept.c_str(), 1);

    const fs::path before = fs::current_path();
    fs::current_path(folder_.path());
    EXPECT_EQ(app::completePath("roc", kScenes), (Strings{"rock.gltf"}));
    EXPECT_EQ(app::completePath("./roc", kScenes), (Strings{"./rock.gltf"}));
    EXPECT_EQ(app::completePath("rooms/", kScenes), (Strings{"rooms/hall.glb", "rooms/deep/"}));
    fs::current_path(before);
}

TEST_F(PathCompletion, AtMostFiftyAndNothingFromErrors)
{
    for (int i = 0; i < 80; ++i)
        core::writeFile(folder_ / ("many" + std::to_string(100 + i) + ".glb"), "x");
    const Strings many = complete("many");
    ASSERT_EQ(many.size(), 50u);
    EXPECT_EQ(many.front(), "many100.glb");
    EXPECT_EQ(many.back(), "many149.glb");
    EXPECT_EQ(complete("none/"), Strings{});
    EXPECT_EQ(complete("room.glb/"), Strings{});
    const std::string endless(100000, 'a');
    EXPECT_EQ(app::completePath(endless + '/', kScenes), Strings{});
    EXPECT_EQ(app::completePath(std::string("a\0b/", 4), kScenes), Strings{});
}

}  // namespace

// The floor plan holds (cmake/rooms.cmake), and its check (cmake/floors.cmake) sees what breaks it:
// faults planted in a copy of the sources must be refused with the file and the room in the
// message.
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/files/source_folder.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/process/shell.h"

namespace {

using tests::kSource;

namespace fs = std::filesystem;

tests::ShellResult check(const fs::path& tree)
{
    return tests::shell("cmake -DSOURCE=" + tests::quoted(tree.string()) + " -P " +
                        tests::quoted((tree / "cmake/floors.cmake").string()));
}

/// The message without its line breaks: CMake wraps it.
std::string oneLine(const std::string& text)
{
    std::string line;
    for (const char c : text)
        if (c != '\n' && c != ' ')
            line += c;
        else if (!line.empty() && line.back() != ' ')
            line += ' ';
    return line;
}

/// What the check reads of the tree, in a folder where faults may be planted.
class Floors : public testing::Test {
protected:
    Floors()
    {
        const std::set<std::string> kinds{".h", ".cpp", ".glsl", ".comp", ".cmake"};
        for (const char* folder : {"app", "core", "shaders", "assets", "bench", "cmake"})
            for (const fs::directory_entry& entry :
                 fs::recursive_directory_iterator(kSource / folder)) {
                if (!kinds.contains(entry.path().extension().string())) continue;
                const fs::path copy = tree_.path() / fs::relative(entry.path(), kSource);
                fs::create_directories(copy.parent_path());
                fs::copy_file(entry.path(), copy);
            }
    }

    /// Adds `text` to a file, which is new or is not; what the check says then. The file is put
    /// back.
    std::string withPlanted(const std::string& file, const std::string& text)
    {
        const fs::path path = tree_.path() / file, kept = tree_.path() / "kept";
        const bool existed = fs::exists(path);
        if (existed) fs::copy_file(path, kept, fs::copy_options::overwrite_existing);
        fs::create_directories(path.parent_path());
        std::ofstream(path, std::ios::app) << '\n' << text << '\n';
        const tests::ShellResult result = check(tree_.path());
        EXPECT_NE(result.code, 0) << file << ": " << text << " was not refused";
        fs::remove(path);
        if (existed) fs::rename(kept, path);
        return oneLine(result.output);
    }

    void expectRefused(const std::string& file, const std::string& text, const std::string& message)
    {
        const std::string said = withPlanted(file, text);
        EXPECT_NE(said.find(message), std::string::npos)
            << "instead of '" << message << "': " << said;
    }

private:
    tests::TemporaryFolder tree_;
};

TEST_F(Floors, HoldInTheTreeAndInItsCopy)
{
    const tests::ShellResult real = check(kSource);
    EXPECT_EQ(real.code, 0) << real.output;
    const std::string said = withPlanted("core/base/check.h", "#include \"app/base/log.h\"");
    EXPECT_EQ(said.find("core/base/check.h"), said.rfind("core/base/check.h"))
        << "one fault alone: " << said;
}

TEST_F(Floors, AnIncludeUpwardsIsRefused)
{
    expectRefused(
        "core/base/check.h", "#include \"app/base/log.h\"",
        "core/base/check.h: includes app/base/log.h, but core/base does not see app/base");
    expectRefused(
        "core/scene/world.cpp", "#  include \"core/trace/bvh.h\"",
        "core/scene/world.cpp: includes core/trace/bvh.h, but core/scene does not see core/trace");
    expectRefused("shaders/shared/bsdf.h", "#include \"traverse.glsl\"",
                  "shaders/shared/bsdf.h: includes shaders/traverse.glsl, but shaders/shared "
                  "does not see shaders");
}

TEST_F(Floors, AnIncludeSidewaysIsRefused)
{
    expectRefused(
        "app/report/page.cpp", "#include \"app/lab/results.h\"",
        "app/report/page.cpp: includes app/lab/results.h, but app/report does not see app/lab");
    expectRefused("core/guiding/quadtree.h", "#include \"core/scene/scene.h\"",
                  "core/guiding/quadtree.h: includes core/scene/scene.h, but core/guiding does not "
                  "see core/scene");
}

TEST_F(Floors, AForeignHeaderInTheWrongRoomIsRefused)
{
    expectRefused(
        "core/scene/camera.cpp", "#include <vulkan/vulkan.h>",
        "core/scene/camera.cpp: includes <vulkan/vulkan.h>, which core/scene may not name");
    expectRefused(
        "app/bench/throughput/bench_throughput.cpp", "#include <imgui.h>",
        "app/bench/throughput/bench_throughput.cpp: includes <imgui.h>, which app/bench/throughput "
        "may not name");
    expectRefused("core/scene/camera.cpp", "#include <png.h>",
                  "core/scene/camera.cpp: includes <png.h>, which core/scene may not name");
    expectRefused("core/scene/camera.cpp", "#include <emmintrin.h>",
                  "core/scene/camera.cpp: includes <emmintrin.h>, which core/scene may not name");
}

TEST_F(Floors, AFileInNoRoomIsRefused)
{
    expectRefused("core/attic/things.h", "#pragma once",
                  "core/attic/things.h: its folder is not a room of cmake/rooms.cmake");
}

TEST_F(Floors, ARoomAboveIsNoRoomToSee)
{
    expectRefused("cmake/rooms.cmake", "room(core/attic SEES core/cellar)",
                  "core/attic sees core/cellar, which is not below it");
}

}  // namespace

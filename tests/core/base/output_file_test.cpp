// Files that are written whole or not at all; links, devices and pipes (B97).
#include "core/base/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <thread>

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"

namespace {

namespace fs = std::filesystem;
using tests::readAll;
using tests::TemporaryFolder;

std::string writingRefusal(const fs::path& file)
{
    try {
        core::writeFile(file, "text");
    } catch (const core::Error& error) {
        return error.what();
    }
    return {};
}

TEST(OutputFile, ReplacesWholeFilesAndLeavesNothingElse)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "file";
    core::requireWritableFile(file);
    EXPECT_FALSE(fs::exists(file));
    core::writeFile(file, "first");
    core::writeFile(file, "second");
    EXPECT_EQ(readAll(file), "second");
    EXPECT_EQ(folder.count(), 1u);
}

TEST(OutputFile, LinksAreFollowed)
{
    const TemporaryFolder folder;
    core::writeFile(folder / "target", "old");
    fs::create_directory(folder / "sub");
    fs::create_symlink("../target", folder / "sub" / "link");
    fs::create_symlink("sub/link", folder / "link");
    fs::create_symlink("absent", folder / "dangling");
    core::writeFile(folder / "link", "new");
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_TRUE(fs::is_symlink(folder / "sub" / "link"));
    EXPECT_EQ(readAll(folder / "target"), "new");
    core::requireWritableFile(folder / "dangling");
    core::writeFile(folder / "dangling", "made");
    EXPECT_EQ(readAll(folder / "absent"), "made");
    fs::create_symlink("round", folder / "round");
    EXPECT_NE(writingRefusal(folder / "round").find("circle"), std::string::npos);
    EXPECT_TRUE(fs::is_symlink(folder / "round"));
}

TEST(OutputFile, DevicesStayDevices)
{
    const TemporaryFolder folder;
    fs::create_symlink("/dev/null", folder / "nothing");
    core::requireWritableFile("/dev/null");
    core::writeFile("/dev/null", "text");
    core::writeFile(folder / "nothing", "text");
    EXPECT_TRUE(fs::is_character_file("/dev/null"));
    EXPECT_TRUE(fs::is_symlink(folder / "nothing"));
    EXPECT_NE(writingRefusal("/dev/full").find("/dev/full: cannot be written: "),
              std::string::npos);
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

TEST(OutputFile, PipesAndDescriptorsAreWrittenTo)
{
    const TemporaryFolder folder;
    const fs::path pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    core::requireWritableFile(pipe);  // does not wait for a reader
    std::string got;
    std::thread reader([&] { got = readAll(pipe); });
    core::writeFile(pipe, "through the pipe");
    reader.join();
    EXPECT_EQ(got, "through the pipe");
    EXPECT_TRUE(fs::is_fifo(pipe));

    const fs::path file = folder / "file";
    const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT, 0600);
    ASSERT_GE(descriptor, 0);
    const std::string name = "/dev/fd/" + std::to_string(descriptor);
    fs::create_symlink(name, folder / "open");
    core::requireWritableFile(name);
    core::writeFile(name, "one ");
    core::writeFile(folder / "open", "two");
    EXPECT_EQ(::write(descriptor, "!", 1), 1);
    ::close(descriptor);
    EXPECT_EQ(readAll(file), "one two!");  // in place: the descriptor leads to it still
}

TEST(OutputFile, Refusals)
{
    const TemporaryFolder folder;
    const auto demand = [](const fs::path& file, const std::string& text) {
        try {
            core::requireWritableFile(file);
            FAIL() << file;
        } catch (const core::Error& error) {
            EXPECT_NE(std::string(error.what()).find(file.string() + ": "), std::string::npos);
            EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
        }
    };
    demand(folder.path(), "is a folder");
    demand(folder / "absent" / "file", "does not exist");
    EXPECT_NE(writingRefusal(folder / "absent" / "file"), "");
    EXPECT_NE(writingRefusal(folder / std::string(300, 'x')), "");
    EXPECT_EQ(folder.count(), 0u);
}

TEST(OutputFile, TheSameFileByOtherNames)
{
    const TemporaryFolder folder;
    core::writeFile(folder / "a", "");
    fs::create_symlink("a", folder / "b");
    EXPECT_TRUE(core::sameFile(folder / "a", folder / "a"));
    EXPECT_TRUE(core::sameFile(folder / "a", folder / "." / "a"));
    EXPECT_TRUE(core::sameFile(folder / "a", folder / "b"));
    EXPECT_TRUE(core::sameFile(folder / "absent", folder / "." / "absent"));
    EXPECT_FALSE(core::sameFile(folder / "a", folder / "absent"));
    EXPECT_FALSE(core::sameFile("/dev/null", "/dev/null"));
}

}  // namespace

// Files of a cache (N25): what is damaged or foreign counts as absent and is removed, those that
// have not been used for longest make room, nothing fails where nothing can be kept, and processes
// may write at once.
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

#include "core/base/cache_folder.h"
#include "tests/support/files/picture_bytes.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"

namespace {

namespace fs = std::filesystem;
using core::CacheFolder;
using tests::bytesOf;
using tests::readAll;
using tests::TemporaryFolder;
using tests::writeAll;
using Bytes = std::vector<std::byte>;

constexpr uint64_t kPlenty = 1 << 20;
constexpr size_t kHead = 32;  // bytes of a file before its key

fs::path onlyFile(const fs::path& folder)
{
    return fs::directory_iterator(folder)->path();
}

/// As if the file had been used so many minutes ago.
void age(const fs::path& file, int minutes)
{
    fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::minutes(minutes));
}

TEST(CacheFolder, GivesBackWhatItWasGiven)
{
    const TemporaryFolder folder;
    const CacheFolder cache(folder / "deep/deeper", "thing", kPlenty);  // made on demand
    EXPECT_TRUE(cache.read(bytesOf("a")).empty());
    cache.write(bytesOf("a"), bytesOf("first"));
    cache.write(bytesOf("b"), bytesOf("second"));
    EXPECT_EQ(cache.read(bytesOf("a")), bytesOf("first"));
    EXPECT_EQ(cache.read(bytesOf("b")), bytesOf("second"));
    cache.write(bytesOf("a"), bytesOf("newer"));
    EXPECT_EQ(cache.read(bytesOf("a")), bytesOf("newer"));
    EXPECT_TRUE(CacheFolder(folder / "deep/deeper", "other", kPlenty).read(bytesOf("a")).empty());
    cache.remove(bytesOf("a"));
    EXPECT_TRUE(cache.read(bytesOf("a")).empty());
    EXPECT_EQ(cache.read(bytesOf("b")), bytesOf("second"));
}

TEST(CacheFolder, EveryDamageCountsAsAbsenceAndIsRemoved)
{
    const TemporaryFolder folder;
    const CacheFolder cache(folder.path(), "thing", kPlenty);
    const Bytes key = bytesOf("the key"), data = bytesOf("what was dear to make");
    cache.write(key, data);
    const fs::path file = onlyFile(folder.path());
    const std::string whole = readAll(file);
    ASSERT_EQ(whole.size(), kHead + key.size() + data.size());
    const auto expectRefused = [&](const std::string& text, const std::string& what) {
        writeAll(file, text);
        EXPECT_TRUE(cache.read(key).empty()) << what;
        EXPECT_EQ(folder.count(), 0u) << what;
    };
    for (size_t cut = 0; cut < whole.size(); ++cut)
        expectRefused(whole.substr(0, cut), "cut off at " + std::to_string(cut));
    for (size_t i = 0; i < whole.size(); ++i) {
        for (const int bit : {0, 7}) {
            std::string damaged = whole;
            damaged[i] = static_cast<char>(damaged[i] ^ 1 << bit);
            expectRefused(damaged, "another bit in byte " + std::to_string(i));
        }
    }
    expectRefused(whole + "x", "a byte too many");
    expectRefused(std::string(whole.size(), '\0'), "a hole");
    writeAll(file, whole);
    EXPECT_EQ(cache.read(key), data);
}

TEST(CacheFolder, AFileUnderTheNameOfAnotherKeyIsForeign)
{
    const TemporaryFolder folder;
    const CacheFolder cache(folder.path(), "thing", kPlenty);
    cache.write(bytesOf("mine"), bytesOf("m"));
    const fs::path mine = onlyFile(folder.path());
    const std::string content = readAll(mine);
    fs::remove(mine);
    cache.write(bytesOf("your"), bytesOf("y"));
    writeAll(onlyFile(folder.path()), content);
    EXPECT_TRUE(cache.read(bytesOf("your")).empty());
}

TEST(CacheFolder, WhatWasNotUsedForLongestMakesRoom)
{
    const TemporaryFolder folder;
    const Bytes data(1000);
    const uint64_t each = kHead + 1 + data.size();
    const CacheFolder cache(folder.path(), "thing", 3 * each);
    writeAll(folder / "foreign.txt", std::string(5000, 'x'));  // neither counted nor removed
    for (const char* key : {"a", "b", "c"}) {
        cache.write(bytesOf(key), data);
        for (const auto& entry : fs::directory_iterator(folder.path())) age(entry.path(), 10);
    }
    EXPECT_EQ(cache.read(bytesOf("a")), data);  // used just now
    EXPECT_EQ(cache.read(bytesOf("c")), data);
    cache.write(bytesOf("d"), data);
    EXPECT_TRUE(cache.read(bytesOf("b")).empty());
    for (const char* key : {"a", "c", "d"}) EXPECT_EQ(cache.read(bytesOf(key)), data) << key;
    cache.write(bytesOf("d"), Bytes(999));  // in its own place: nobody has to go
    for (const char* key : {"a", "c", "d"}) EXPECT_FALSE(cache.read(bytesOf(key)).empty()) << key;
    cache.write(bytesOf("e"), Bytes(3 * each));  // has no room at all
    for (const char* key : {"a", "c", "d"}) EXPECT_FALSE(cache.read(bytesOf(key)).empty()) << key;
    cache.write(bytesOf("e"), Bytes(3 * each - kHead - 1));  // has all the room
    EXPECT_EQ(folder.count(), 2u);
    EXPECT_TRUE(fs::exists(folder / "foreign.txt"));
}

TEST(CacheFolder, WhatAProcessLeftUnfinishedIsRemovedLater)
{
    const TemporaryFolder folder;
    const CacheFolder cache(folder.path(), "thing", kPlenty);
    for (const char* name : {".0123456789abcdef.thing.77-0.tmp", ".0123456789abcdef.thing.78-0.tmp",
                             ".0123456789abcdef.other.77-0.tmp"})
        writeAll(folder / name, "half of it");
    age(folder / ".0123456789abcdef.thing.77-0.tmp", 90);
    age(folder / ".0123456789abcdef.other.77-0.tmp", 90);
    cache.write(bytesOf("a"), bytesOf("x"));
    EXPECT_FALSE(fs::exists(folder / ".0123456789abcdef.thing.77-0.tmp"));
    EXPECT_TRUE(fs::exists(folder / ".0123456789abcdef.thing.78-0.tmp")) << "may be being written";
    EXPECT_TRUE(fs::exists(folder / ".0123456789abcdef.other.77-0.tmp")) << "of another kind";
}

TEST(CacheFolder, PlacesThatCannotBeWrittenOrReadAreNoError)
{
    const TemporaryFolder folder;
    writeAll(folder / "file", "");
    for (const fs::path& place : {fs::path(), fs::path("/proc/nowhere"), folder / "file",
                                  fs::path("/dev/null"), folder / std::string(5000, 'x')}) {
        const CacheFolder cache(place, "thing", kPlenty);
        EXPECT_EQ(static_cast<bool>(cache), !place.empty());
        cache.write(bytesOf("a"), bytesOf("x"));
        EXPECT_TRUE(cache.read(bytesOf("a")).empty()) << place;
        cache.remove(bytesOf("a"));
    }
    // A folder where the file should be.
    const CacheFolder cache(folder / "deep", "thing", kPlenty);
    cache.write(bytesOf("a"), bytesOf("x"));
    const fs::path file = onlyFile(folder / "deep");
    fs::remove(file);
    fs::create_directories(file / "occupied");
    cache.write(bytesOf("a"), bytesOf("x"));
    EXPECT_TRUE(cache.read(bytesOf("a")).empty());
    cache.remove(bytesOf("a"));
    EXPECT_TRUE(fs::exists(file / "occupied"));
}

TEST(CacheFolder, AFolderWithoutTheRightToWriteIsReadOnly)
{
    if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
    const TemporaryFolder folder;
    const CacheFolder cache(folder.path(), "thing", kPlenty);
    cache.write(bytesOf("a"), bytesOf("x"));
    fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
    cache.write(bytesOf("b"), bytesOf("y"));
    EXPECT_EQ(cache.read(bytesOf("a")), bytesOf("x"));
    EXPECT_TRUE(cache.read(bytesOf("b")).empty());
    fs::permissions(folder.path(), fs::perms::owner_all);
}

TEST(CacheFolder, ProcessesMayWriteReadAndMakeRoomAtOnce)
{
    const TemporaryFolder folder;
    const Bytes a(100'000, std::byte{1}), b(70'000, std::byte{2});
    const uint64_t most = 2 * (kHead + 1 + a.size());
    std::vector<pid_t> children;
    for (int process = 0; process < 4; ++process) {
        const pid_t child = fork();
        if (child == 0) {
            const CacheFolder cache(folder.path(), "thing", most);
            bool good = true;
            for (int i = 0; i < 60; ++i) {
                const Bytes key =
                    bytesOf(std::string(1, static_cast<char>('a' + (process + i) % 3)));
                cache.write(key, (process + i) % 2 == 0 ? a : b);
                const Bytes seen = cache.read(key);  // others may have removed it
                good = good && (seen.empty() || seen == a || seen == b);
            }
            _exit(good ? 0 : 1);
        }
        ASSERT_GT(child, 0);
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, 0), child);
        EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "half a file was read";
    }
    for (const auto& entry : fs::directory_iterator(folder.path()))
        EXPECT_EQ(entry.path().extension(), ".thing") << "something unfinished is left";
}

}  // namespace

// The program as a person or a script starts it: the real binary in a folder of its own, its files,
// streams and exit code.
#pragma once

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/image/image.h"
#include "tests/support/files/source_folder.h"
#include "tests/support/files/text_search.h"
#include "tests/support/files/whole_files.h"
#include "tests/support/process/sanitized.h"

namespace tests {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Strings = std::vector<std::string>;

inline const std::string kScene = (kAssets / "cornell-diffuse.gltf").string();
inline const Strings kDevices{"cpu", "vulkan"};

inline Strings operator+(Strings a, const Strings& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// A picture that takes no time.
inline Strings smallRender(const std::string& device, const std::string& output)
{
    return {"render", kScene, "-o", output, "--device", device, "--size", "40x32", "--spp", "4"};
}

struct Result {
    int code = -1;  // -1: killed, by a signal or because it took too long
    std::string out, err;
    int signal = 0;  // that has ended it
};

#ifdef REKINDLE_SANITIZED
constexpr double kSlowdown = 10;
#else
constexpr double kSlowdown = 1;
#endif

/// An environment in which no window opens, whatever display the tests are run on.
inline const Strings kNoDisplay{"DISPLAY=", "WAYLAND_DISPLAY="};

/// A folder of its own for every test, and the program started in it.
class Cli : public testing::Test {
protected:
    Cli()
    {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::path(testing::TempDir()) /
                  ("rekindle-cli-" + std::to_string(getpid()) + '-' + info->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_ / "work");
    }
    ~Cli() override { fs::remove_all(folder_); }

    fs::path work(const std::string& name = {}) const { return folder_ / "work" / name; }

    /// Starts the program with its working folder in work(); `environment` is added ("NAME=value").
    pid_t start(const Strings& arguments, const Strings& environment = {})
    {
        Strings words = Strings{program} + arguments;
        std::vector<char*> argv, envp;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        Strings added = environment;
        for (std::string& variable : added) envp.push_back(variable.data());
        for (char** variable = environ; *variable; ++variable) envp.push_back(*variable);
        envp.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions, 1, outFile().c_str(),
                                         O_WRONLY | O_CREAT | O_TRUNC, 0600);
        posix_spawn_file_actions_addopen(&actions, 2, errFile().c_str(),
                                         O_WRONLY | O_CREAT | O_TRUNC, 0600);
        posix_spawn_file_actions_addchdir_np(&actions, work().c_str());
        pid_t pid = -1;
        EXPECT_EQ(posix_spawn(&pid, program.c_str(), &actions, nullptr, argv.data(), envp.data()),
                  0);
        posix_spawn_file_actions_destroy(&actions);
        return pid;
    }

    /// Waits for the end, at most `seconds`; under a sanitizer everything takes ten times as long.
    Result finish(pid_t pid, double seconds = 60)
    {
        seconds *= kSlowdown;
        const auto limit =
            std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
        int status = 0;
        bool late = false;
        while (waitpid(pid, &status, WNOHANG) == 0) {
            if (!late && std::chrono::steady_clock::now() > limit) {
                late = true;
                kill(pid, SIGKILL);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        EXPECT_FALSE(late) << "took longer than " << seconds << " s";
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readAll(outFile()),
                readAll(errFile()), WIFSIGNALED(status) ? WTERMSIG(status) : 0};
    }

    Result run(const Strings& arguments, const Strings& environment = {})
    {
        return finish(start(arguments, environment));
    }

    /// Waits until stderr holds `text`.
    void waitForError(const std::string& text)
    {
        for (int i = 0; i < 1500 && !contains(readAll(errFile()), text); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
        ASSERT_TRUE(contains(readAll(errFile()), text)) << readAll(errFile());
    }

    std::set<std::string> files() const
    {
        std::set<std::string> names;
        for (const auto& entry : fs::recursive_directory_iterator(work()))
            if (!entry.is_directory())
                names.insert(entry.path().lexically_relative(work()).string());
        return names;
    }

    /// Runs what must be refused: the exit code, exactly one line on stderr that holds `text`,
    /// nothing on stdout, and no file that was not there before.
    void expectRefused(const Strings& arguments, int code, const std::string& text,
                       const Strings& environment = {})
    {
        std::string shown;
        for (const std::string& argument : arguments) shown += ' ' + argument;
        SCOPED_TRACE("rekindle" + shown);
        const std::set<std::string> before = files();
        const Result result = run(arguments, environment);
        EXPECT_EQ(result.code, code) << result.err;
        EXPECT_EQ(lineCount(result.err), 1u) << result.err;
        EXPECT_TRUE(contains(result.err, text)) << result.err;
        EXPECT_EQ(result.out, "");
        EXPECT_EQ(files(), before);
    }

    void writeFile(const std::string& name, const std::string& text) const
    {
        std::ofstream(work(name), std::ios::binary) << text;
    }

    Json stats(const std::string& name = "stats.json") const
    {
        return Json::parse(readAll(work(name)));
    }

    core::ImageFile exr(const std::string& name) const { return core::readExr(work(name)); }

    std::string program = REKINDLE_BINARY;

private:
    fs::path outFile() const { return folder_ / "stdout"; }
    fs::path errFile() const { return folder_ / "stderr"; }

    fs::path folder_;
};

}  // namespace tests

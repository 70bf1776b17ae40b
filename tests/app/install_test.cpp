// What `cmake --install` makes: a program that runs from its prefix, finds its scenes there and not
// in the sources, and a manual page that names every option.
#include <cstdlib>

#include "tests/support/files/pattern.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;

class Install : public Cli {
protected:
    void SetUp() override
    {
        prefix_ = fs::canonical(work()) / "prefix";
        const std::string command = std::string("'") + REKINDLE_CMAKE + "' --install '" +
                                    REKINDLE_BUILD_DIR + "' --prefix '" + prefix_.string() +
                                    "' >/dev/null 2>&1";
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
        program = prefix_ / "bin" / "rekindle";
        ASSERT_TRUE(fs::exists(program));
    }

    /// Stops a program that would go on, once stderr holds `text`.
    void expectError(const Strings& arguments, const std::string& text, const Strings& environment)
    {
        const pid_t pid = start(arguments, environment);
        waitForError(text);
        kill(pid, SIGINT);
        EXPECT_EQ(finish(pid).code, 130);
    }

    fs::path prefix_;
};

TEST_F(Install, HasItsFiles)
{
    const fs::path share = prefix_ / "share";
    for (const char* file :
         {"rekindle/assets/cornell-diffuse.gltf", "rekindle/assets/cornell-diffuse.bin",
          "rekindle/assets/scripts/tour.json", "applications/rekindle.desktop",
          "icons/hicolor/scalable/apps/rekindle.svg", "man/man1/rekindle.1",
          "doc/rekindle/LICENSE"})
        EXPECT_GT(fs::file_size(share / file), 50u) << file;
    EXPECT_FALSE(fs::exists(share / "rekindle/assets/generator"));
}

TEST_F(Install, RunsWithItsOwnScene)
{
    const fs::path scene = prefix_ / "share/rekindle/assets/cornell-diffuse.gltf";
    expectError({"--device", "cpu"}, scene.string(), kNoDisplay);
    const Result rendered = run({"render", scene.string(), "-o", "x.exr", "--device", "cpu",
                                 "--size", "16x16", "--spp", "1"});
    EXPECT_EQ(rendered.code, 0) << rendered.err;
    EXPECT_EQ(exr("x.exr").layer("").width, 16u);
}

/// .ci/install where there is no apt-get: with nothing needed missing it is silent, else it names
/// the packages.
TEST_F(Cli, WhatIsMissingIsNamedWhereThereIsNoAptGet)
{
    const fs::path commands = work("commands");
    fs::create_directory(commands);
    const auto offer = [&](const char* name) {
        fs::create_symlink(fs::path("/usr/bin") / name, commands / name);
    };
    for (const char* name : {"bash", "env", "c++", "cmake", "ninja"}) offer(name);
    program = "/usr/bin/env";
    const Strings install{"PATH=" + commands.string(), REKINDLE_SOURCE_DIR "/.ci/install"};
    const Result missing = run(install);
    EXPECT_EQ(missing.code, 1);
    EXPECT_TRUE(contains(missing.err, "glslang-tools: shader compiler")) << missing.err;
    EXPECT_TRUE(contains(missing.err, "spirv-tools: shader optimiser")) << missing.err;
    EXPECT_TRUE(contains(missing.err, "pacman -S "));
    EXPECT_FALSE(contains(missing.err, "cmake:"));
    offer("glslangValidator");
    offer("spirv-opt");
    const Result enough = run(install);
    EXPECT_EQ(enough.code, 0) << enough.err;
    EXPECT_EQ(enough.err, "");
}

/// Where apt-get is of no use, what the program builds without is no reason to stop.
TEST_F(Cli, WhatIsNotNeededMayStayMissing)
{
    const fs::path commands = work("commands");
    fs::create_directory(commands);
    for (const char* name : {"bash", "env", "c++", "cmake", "ninja", "glslangValidator"})
        fs::create_symlink(fs::path("/usr/bin") / name, commands / name);
    const auto script = [&](const std::string& name, const std::string& text) {
        writeFile("commands/" + name, "#!/usr/bin/env bash\n" + text + "\n");
        fs::permissions(commands / name, fs::perms::owner_all);
    };
    program = "/usr/bin/env";
    const Strings install{"PATH=" + commands.string(), REKINDLE_SOURCE_DIR "/.ci/install"};
    script("apt-get", "echo 'no network' >&2; exit 100");
    for (const char* user : {"0", "1000"}) {
        SCOPED_TRACE(user);
        script("id", std::string("echo ") + user);
        const Result needed = run(install);
        EXPECT_EQ(needed.code, 1) << needed.err;
        EXPECT_TRUE(contains(needed.err, "spirv-tools"));
        fs::create_symlink("/usr/bin/spirv-opt", commands / "spirv-opt");
        const Result enough = run(install);
        EXPECT_EQ(enough.code, 0) << enough.err;
        EXPECT_TRUE(contains(enough.err, "xvfb: (tests of the window)")) << enough.err;
        fs::remove(commands / "spirv-opt");
    }
}

/// Option names in a text, as "--spp".
std::set<std::string> optionsIn(const std::string& text)
{
    static const Pattern option("(^|[ ,])(--[a-z][a-z-]+)");
    std::set<std::string> names;
    for (const Pattern::Groups& found : option.findAll(text)) names.insert(found[2]);
    return names;
}

TEST_F(Install, ManualTellsTheCommandsInTheOrderOfTheHelpAndWhatAllOfThemTake)
{
    std::string manual = readAll(prefix_ / "share/man/man1/rekindle.1");
    manual = Pattern("\\\\f[BIR]").replace(manual, "");
    manual = Pattern("\\\\-").replace(manual, "-");
    const auto inOrder = [&](const std::string& text, const Strings& words) {
        size_t place = 0;
        for (const std::string& word : words) {
            place = text.find(word, place);
            ASSERT_NE(place, std::string::npos) << word;
        }
    };
    const size_t begin = manual.find(".SH SYNOPSIS"), end = manual.find(".SH DESCRIPTION");
    const Strings commands{"rekindle [COMMAND]", "rekindle view",    "rekindle render",
                           "rekindle compare",   "rekindle info",    "rekindle devices",
                           "rekindle lab",       "rekindle bench M", "rekindle bench throughput"};
    inOrder(manual.substr(begin, end - begin), commands);
    const std::string description = manual.substr(end, manual.find("\n.SH", end) - end);
    for (const char* option : {"-h, --help", "--version", "--json"})
        EXPECT_TRUE(contains(description, option)) << option;
}

TEST_F(Install, ManualNamesEveryCommandAndOption)
{
    std::string manual = readAll(prefix_ / "share/man/man1/rekindle.1");
    EXPECT_TRUE(manual.starts_with(".TH REKINDLE 1"));
    manual = Pattern("\\\\f[BIR]").replace(manual, "");
    manual = Pattern("\\\\-").replace(manual, "-");
    for (const Strings& command : {Strings{"view"},
                                   {"render"},
                                   {"compare"},
                                   {"info"},
                                   {"devices"},
                                   {"lab"},
                                   {"bench", "throughput"},
                                   {"bench", "flythrough"},
                                   {"bench", "manylights"},
                                   {"bench", "guiding"},
                                   {"bench", "light"}}) {
        std::string title = "COMMAND";
        for (const std::string& word : command) title += ' ' + word;
        const size_t begin = manual.find(".SH \"" + title + '"');
        ASSERT_NE(begin, std::string::npos) << title;
        const std::string section = manual.substr(begin, manual.find("\n.SH", begin) - begin);
        const std::set<std::string> said = optionsIn(run(command + Strings{"--help"}).out);
        EXPECT_GE(said.size(), 1u);
        for (const std::string& name : said) {
            if (name == "--help") continue;
            EXPECT_TRUE(contains(section, name)) << title << ' ' << name;
        }
    }
}

}  // namespace

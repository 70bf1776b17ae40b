// The check of the format (.ci/format) refuses a file that is not formatted, names it, and reads
// only what git tracks.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/files/source_folder.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/process/shell.h"

namespace {

using tests::kSource;

namespace fs = std::filesystem;

/// A repository with the project's style and one file that follows it.
class Format : public testing::Test {
protected:
    Format()
    {
        fs::copy_file(kSource / ".clang-format", tree_ / ".clang-format");
        write("good.h", "int a(int b);\n");
        run("git init -q . && git add .");
    }

    tests::ShellResult run(const std::string& command) const
    {
        return tests::shell("cd " + tests::quoted(tree_.path().string()) + " && " + command);
    }
    tests::ShellResult check() const
    {
        return run(tests::quoted((kSource / ".ci/format").string()) + " " +
                   tests::quoted(tree_.path().string()));
    }
    void write(const std::string& name, const std::string& text) const
    {
        std::ofstream(tree_ / name) << text;
    }

    const tests::TemporaryFolder tree_;
};

TEST_F(Format, AFileOutOfFormatIsRefusedByName)
{
    if (tests::shell("clang-format-14 --version").code != 0) GTEST_SKIP() << "no clang-format 14";
    const tests::ShellResult good = check();
    EXPECT_EQ(good.code, 0) << good.output;
    EXPECT_EQ(good.output, "");
    run("mkdir build");
    EXPECT_EQ(check().code, 0);
    write("bad.cpp", "int  a( int b ){ return b ; }\n");
    EXPECT_EQ(check().code, 0) << "git does not track it";
    run("git add bad.cpp");
    const tests::ShellResult bad = check();
    EXPECT_NE(bad.code, 0);
    EXPECT_NE(bad.output.find("bad.cpp:1"), std::string::npos) << bad.output;
    EXPECT_EQ(bad.output.find("good.h"), std::string::npos) << bad.output;
    EXPECT_NE(check().code, 0) << "a fault does not pass by asking twice";
    run("clang-format-14 -i bad.cpp");
    EXPECT_EQ(check().code, 0);
}

TEST_F(Format, ASkipIsReported)
{
    // A PATH with what the script needs, but no clang-format.
    run("mkdir bin && for tool in bash env git dirname sed; do ln -s \"$(command -v $tool)\" bin/; "
        "done");
    const std::string script = tests::quoted((kSource / ".ci/format").string());
    const tests::ShellResult skipped = run("PATH=$PWD/bin bash " + script + " .");
    EXPECT_EQ(skipped.code, 0) << skipped.output;
    EXPECT_NE(skipped.output.find("not checked"), std::string::npos) << skipped.output;
    EXPECT_NE(skipped.output.find("clang-format 14"), std::string::npos) << skipped.output;
}

}  // namespace

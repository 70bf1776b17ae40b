// The pages for users: docs/viewer.md lists every key of the viewer; README.md and the pages name
// only files and options that exist; the README leads to every page, and rows of figures that it
// shows stand in a page, too, so that they cannot drift apart.
#include <cstdio>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/session/actions.h"
#include "tests/support/files/pattern.h"
#include "tests/support/files/source_folder.h"
#include "tests/support/files/whole_files.h"

namespace {

namespace fs = std::filesystem;
using tests::kSource;
using tests::readAll;

/// The pages below docs/, by their path from the root.
std::vector<fs::path> pages()
{
    std::vector<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(kSource / "docs"))
        if (entry.path().extension() == ".md") found.push_back(fs::relative(entry.path(), kSource));
    return found;
}

TEST(Readme, ViewerPageListsEveryKeyWithWhatItDoes)
{
    const std::string text = readAll(kSource / "docs/viewer.md");
    for (const app::Action& action : app::actions()) {
        if (action.key[0] == '\0') continue;
        const std::string key =
            std::string(action.key) == "`" ? "`` ` ``" : '`' + std::string(action.key) + '`';
        const std::string help =
            std::string(action.help).substr(0, std::string(action.help).find("; with x"));
        EXPECT_NE(text.find("| " + key + " | " + help + " |"), std::string::npos)
            << key << ": " << help;
    }
}

TEST(Readme, PagesNameOnlyFilesThatExist)
{
    const tests::Pattern path(
        R"(\b(?:app|core|shaders|assets|tests)/[A-Za-z0-9_/.-]+\.(?:h|cpp|comp|json|jpg|png|sh|gltf)\b)");
    std::vector<fs::path> files = pages();
    files.emplace_back("README.md");
    size_t found = 0;
    for (const fs::path& file : files)
        for (const auto& name : path.findAll(readAll(kSource / file))) {
            ++found;
            EXPECT_TRUE(fs::exists(kSource / name[0])) << file << " names " << name[0];
        }
    EXPECT_GT(found, 100u);
}

/// Options in a text: "--spp".
std::set<std::string> optionsIn(const std::string& text)
{
    static const tests::Pattern option("(^|[^A-Za-z-])(--[a-z][a-z-]*)");
    std::set<std::string> names;
    for (const auto& found : option.findAll(text)) names.insert(found[2]);
    return names;
}

/// What the program prints for these arguments.
std::string printed(const std::string& arguments)
{
    FILE* const pipe = popen(("'" REKINDLE_BINARY "' " + arguments).c_str(), "r");
    std::string text;
    for (int c = 0; pipe != nullptr && (c = fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    EXPECT_EQ(pclose(pipe), 0) << arguments;
    return text;
}

/// The page of the manual has the options of all commands; ./test has its own, and CMake those that
/// stand here.
TEST(Readme, PagesNameOnlyOptionsThatExist)
{
    std::set<std::string> known{"--install", "--prefix", "--preset"};
    std::string manual = tests::Pattern("\\\\f[BIR]").replace(printed("--manual"), "");
    manual = tests::Pattern("\\\\-").replace(manual, "-");
    known.merge(optionsIn(manual));
    known.merge(optionsIn(readAll(kSource / "test")));
    EXPECT_TRUE(known.contains("--spp") && known.contains("--mutants"));
    EXPECT_EQ(optionsIn("`--cap` (--a-b), --c=3, x--d, ---"),
              (std::set<std::string>{"--a-b", "--c", "--cap"}));
    std::vector<fs::path> files = pages();
    files.emplace_back("README.md");
    for (const fs::path& file : files)
        for (const std::string& option : optionsIn(readAll(kSource / file)))
            EXPECT_TRUE(known.contains(option)) << file << " names " << option;
}

TEST(Readme, LeadsToEveryPage)
{
    const std::string text = readAll(kSource / "README.md");
    for (const fs::path& page : pages())
        EXPECT_NE(text.find("](" + page.generic_string() + ")"), std::string::npos) << page;
    EXPECT_GT(pages().size(), 10u);
}

TEST(Readme, RowsOfFiguresStandInAPage)
{
    std::string all;
    for (const fs::path& page : pages()) all += readAll(kSource / page) + '\n';
    const tests::Pattern figure(R"(\| [^|`]*\.\d[^|`]* \|)");
    std::istringstream lines(readAll(kSource / "README.md"));
    size_t found = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line[0] != '|' || !figure.find(line)) continue;
        ++found;
        EXPECT_NE(all.find('\n' + line + '\n'), std::string::npos) << line;
    }
    EXPECT_GT(found, 10u);
}

}  // namespace

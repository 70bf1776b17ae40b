// The README lists every key of the viewer, and names only files that exist.
#include <fstream>
#include <iterator>

#include <gtest/gtest.h>

#include "app/session/actions.h"
#include "tests/support/pattern.h"

namespace {

namespace fs = std::filesystem;

std::string readme()
{
    std::ifstream file(fs::path(REKINDLE_SOURCE_DIR) / "README.md");
    return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Readme, ListsEveryKeyWithWhatItDoes)
{
    const std::string text = readme();
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

TEST(Readme, NamesOnlyFilesThatExist)
{
    const std::string text = readme();
    const tests::Pattern path(
        R"(\b(?:app|core|shaders|assets|tests)/[A-Za-z0-9_/.-]+\.(?:h|cpp|comp|json|jpg|png|sh|gltf)\b)");
    const auto found = path.findAll(text);
    for (const auto& name : found)
        EXPECT_TRUE(fs::exists(fs::path(REKINDLE_SOURCE_DIR) / name[0])) << name[0];
    EXPECT_GT(found.size(), 20u);
}

}  // namespace

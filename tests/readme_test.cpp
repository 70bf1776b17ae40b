// The README lists every key of the viewer, and names only files that exist.
#include <fstream>
#include <iterator>
#include <regex>

#include <gtest/gtest.h>

#include "app/session/actions.h"

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
    const std::regex path(
        R"(\b(?:app|core|shaders|assets|tests)/[A-Za-z0-9_/.-]+\.(?:h|cpp|comp|json|jpg|png|sh|gltf)\b)");
    int found = 0;
    for (std::sregex_iterator i(text.begin(), text.end(), path), end; i != end; ++i, ++found)
        EXPECT_TRUE(fs::exists(fs::path(REKINDLE_SOURCE_DIR) / i->str())) << i->str();
    EXPECT_GT(found, 20);
}

}  // namespace

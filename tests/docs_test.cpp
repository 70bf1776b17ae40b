// The documents and the sources agree: every id of a claim has its row in docs/tests.md, which
// names the tests that prove it; files and tests that a comment or a document names exist, and
// links lead to files and headings. Each check is also given faults that it must see.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/files/pattern.h"
#include "tests/support/files/source_folder.h"
#include "tests/support/files/whole_files.h"

namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;
using Names = std::set<std::string>;
using tests::kSource;
using tests::Pattern;

/// A file of the repository, by its path from the root.
struct Text {
    std::string file;
    Strings lines;
};

Text readText(const std::string& file)
{
    std::ifstream stream(kSource / file);
    Text text{file, {}};
    for (std::string line; std::getline(stream, line);) text.lines.push_back(line);
    EXPECT_FALSE(text.lines.empty()) << file << " is missing or empty";
    return text;
}

/// Paths of all files below `folders`, from the root.
Strings filesBelow(const Strings& folders)
{
    Strings files;
    for (const std::string& folder : folders)
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kSource / folder))
            if (entry.is_regular_file())
                files.push_back(fs::relative(entry.path(), kSource).string());
    std::sort(files.begin(), files.end());
    return files;
}

bool hasKind(const std::string& file, const Names& kinds)
{
    return kinds.contains(fs::path(file).extension().string());
}

bool isProgram(const std::string& file)
{
    return hasKind(file, {".h", ".cpp", ".comp", ".glsl"});
}

/// Programs, build files and scripts.
const std::vector<Text>& sources()
{
    static const std::vector<Text> all = [] {
        std::vector<Text> texts;
        for (const std::string& file :
             filesBelow({"app", "assets", "bench", "cmake", "core", "shaders", "tests"}))
            if (isProgram(file) || hasKind(file, {".cmake", ".sh"}))
                texts.push_back(readText(file));
        for (const char* file :
             {"CMakeLists.txt", "run", "test", ".ci/run", ".ci/install", ".ci/format"})
            texts.push_back(readText(file));
        return texts;
    }();
    return all;
}

const std::vector<Text>& documents()
{
    static const std::vector<Text> all = [] {
        std::vector<Text> texts;
        for (const std::string& file : filesBelow({"docs"}))
            if (hasKind(file, {".md"})) texts.push_back(readText(file));
        for (const char* file :
             {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "assets/README.md"})
            texts.push_back(readText(file));
        return texts;
    }();
    return all;
}

Strings matches(const std::string& text, const Pattern& pattern, size_t group = 0)
{
    Strings found;
    for (const Pattern::Groups& groups : pattern.findAll(text)) found.push_back(groups[group]);
    return found;
}

std::string withoutStrings(const std::string& line)
{
    static const Pattern pattern(R"rx("(\\.|[^"\\])*")rx");
    return pattern.replace(line, "\"\"");
}

/// What a person reads in a line: the comment of a source, all of a document.
std::string prose(const Text& text, const std::string& line)
{
    if (hasKind(text.file, {".md"})) return line;
    const std::string code = isProgram(text.file) ? withoutStrings(line) : line;
    const size_t begin = code.find(isProgram(text.file) ? "//" : "#");
    return begin == std::string::npos ? "" : code.substr(begin);
}

// --- ids of claims

/// The ids that a line names, those of ranges ("B1-B12") one by one; T/(T-1) is a formula.
Names idsIn(const std::string& text)
{
    static const Pattern denominator(R"(/\([^()]*\))");
    const std::string line = denominator.replace(text, "");
    static const Pattern pattern(R"(\b(T-|[TNVBM])([0-9]{1,3})(?:-\1([0-9]{1,3}))?\b)");
    Names ids;
    for (const Pattern::Groups& id : pattern.findAll(line)) {
        const int first = std::stoi(id[2]), last = id[3].empty() ? first : std::stoi(id[3]);
        for (int n = first; n <= last; ++n) ids.insert(id[1] + std::to_string(n));
    }
    return ids;
}

bool isTest(const std::string& file)
{
    return file.starts_with("tests/") && file.ends_with("_test.cpp");
}

std::string stem(const std::string& file)
{
    return fs::path(file).stem().string();
}

/// Id to the tests that its row names.
using Claims = std::map<std::string, Names>;

Claims claimsIn(const Text& text)
{
    static const Pattern row(R"(^\| (T-?\d+|[NVBM]\d+) \| (.{10,}) \| (.*) \|$)"),
        test(R"(`(\w+)`)");
    Claims claims;
    for (const std::string& line : text.lines) {
        const auto cells = row.match(line);
        if (!cells) continue;
        const Strings named = matches((*cells)[3], test, 1);
        EXPECT_TRUE(claims.emplace((*cells)[1], Names(named.begin(), named.end())).second)
            << (*cells)[1] << " stands twice";
    }
    return claims;
}

/// Where rows and tests differ.
Strings claimFaults(const Claims& claims, const std::vector<Text>& texts)
{
    Strings faults;
    Claims named;
    for (const Text& text : texts)
        for (const std::string& line : text.lines)
            for (const std::string& id : idsIn(withoutStrings(line))) {
                if (!claims.contains(id))
                    faults.push_back(text.file + " names " + id +
                                     ", which docs/tests.md does not have");
                if (isTest(text.file)) named[id].insert(stem(text.file));
            }
    for (const auto& [id, tests] : claims) {
        if (tests.empty()) faults.push_back("docs/tests.md: nothing proves " + id);
        for (const std::string& test : tests)
            if (!named[id].contains(test))
                faults.push_back("docs/tests.md: " + test + " does not name " + id);
        for (const std::string& test : named[id])
            if (!tests.contains(test))
                faults.push_back("docs/tests.md: the row of " + id + " lacks " + test);
    }
    return faults;
}

// --- names of files and tests

/// The files that may be named: by their path from the root, from shaders/ or from where they are
/// named, or, for sources, by the last part alone. What some file includes is the compiler's
/// business.
class KnownFiles {
public:
    KnownFiles()
    {
        static const Pattern include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
        for (const Text& text : sources())
            for (const std::string& line : text.lines)
                for (const std::string& name : matches(line, include, 1)) included_.insert(name);
        for (const std::string& file :
             filesBelow({"app", "assets", "bench", "cmake", "core", "docs", "shaders", "tests"}))
            names_.insert(fs::path(file).filename().string());
    }

    bool has(const std::string& name, const Text& from) const
    {
        return included_.contains(name) || names_.contains(name) || fs::exists(kSource / name) ||
               fs::exists(kSource / "shaders" / name) ||
               fs::exists((kSource / from.file).parent_path() / name);
    }

private:
    Names included_, names_;
};

Strings fileFaults(const std::vector<Text>& texts)
{
    static const KnownFiles known;
    static const Pattern source(R"(\b[\w./-]+\.(?:h|cpp|comp|glsl|cmake|md|sh)\b)"),
        path(R"(\b(?:app|core|docs|shaders|assets|tests|bench)/[\w./-]+\.\w+\b)");
    Strings faults;
    for (const Text& text : texts)
        for (const std::string& line : text.lines) {
            const std::string words = prose(text, line);
            Names named;
            for (const Pattern* pattern : {&source, &path})
                for (const std::string& name : matches(words, *pattern)) named.insert(name);
            for (const std::string& name : named)
                if (!known.has(name, text))
                    faults.push_back(text.file + " names " + name + ", which does not exist");
        }
    return faults;
}

/// What a link to a heading is called: its letters in lower case, hyphens for spaces, no other
/// signs.
std::string anchorOf(const std::string& heading)
{
    std::string anchor;
    for (const char c : heading) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte >= 0x80 || std::isalnum(byte) != 0 || c == '-' || c == '_')
            anchor += static_cast<char>(std::tolower(byte));
        else if (c == ' ')
            anchor += '-';
    }
    return anchor;
}

Names anchorsOf(const std::string& file)
{
    static const Pattern heading(R"(^#+ (.+)$)");
    Names anchors;
    for (const std::string& line : readText(file).lines)
        for (const std::string& words : matches(line, heading, 1)) anchors.insert(anchorOf(words));
    return anchors;
}

/// Links within the repository, by their path from the document: as they work in a checkout and on
/// the web.
Strings linkFaults(const std::vector<Text>& texts)
{
    static const Pattern link(R"(\]\(([^)#:]*)(?:#([^)]*))?\))");
    Strings faults;
    for (const Text& text : texts)
        for (const std::string& line : text.lines)
            for (const Pattern::Groups& target : link.findAll(line)) {
                const fs::path folder = fs::path(text.file).parent_path();
                const std::string file = target[1].empty()
                                             ? text.file
                                             : (folder / target[1]).lexically_normal().string();
                if (!fs::exists(kSource / file) ||
                    (!target[2].empty() && !anchorsOf(file).contains(target[2])))
                    faults.push_back(text.file + " links to " + target[0].substr(1) +
                                     ", which does not exist");
            }
    return faults;
}

/// Documents name tests as `bvh_test`, families of them as `gltf_*_test`, and single ones as
/// `Suite.Name`.
Strings testFaults(const std::vector<Text>& texts)
{
    static const Pattern file(R"(`([\w*]+_test)`)"), single(R"(`([A-Z]\w+\.[A-Z]\w+)`)"),
        definition(R"(^TEST(?:_F|_P)?\((\w+),\s*(\w+)\))");
    Names files, singles;
    for (const Text& text : sources()) {
        if (!isTest(text.file)) continue;
        files.insert(stem(text.file));
        for (const std::string& line : text.lines) {
            if (const auto name = definition.find(line))
                singles.insert((*name)[1] + '.' + (*name)[2]);
        }
    }
    const auto exists = [&](const std::string& name) {
        const Pattern pattern(Pattern(R"(\*)").replace(name, R"(\w+)"));
        return std::any_of(files.begin(), files.end(),
                           [&](const std::string& f) { return pattern.match(f).has_value(); });
    };
    Strings faults;
    for (const Text& text : texts)
        for (const std::string& line : text.lines) {
            for (const std::string& name : matches(line, file, 1))
                if (!exists(name))
                    faults.push_back(text.file + " names the tests " + name +
                                     ", which do not exist");
            for (const std::string& name : matches(line, single, 1))
                if (!singles.contains(name))
                    faults.push_back(text.file + " names the test " + name +
                                     ", which does not exist");
        }
    return faults;
}

std::string list(const Strings& faults)
{
    std::string text;
    for (const std::string& fault : faults) text += '\n' + fault;
    return text;
}

TEST(Docs, EveryIdHasItsClaimAndItsTests)
{
    const Claims claims = claimsIn(readText("docs/tests.md"));
    EXPECT_GT(claims.size(), 140u);
    EXPECT_EQ(list(claimFaults(claims, sources())), "");
}

TEST(Docs, MissingClaimsAndTestsAreSeen)
{
    const Claims claims = claimsIn(
        {"docs/tests.md",
         {"| T1 | Something that holds. | `one_test` |", "| B2 | Another thing. | `one_test` |",
          "| B3 | A third thing. | `one_test`, `two_test` |", "| V9 | Proved by nothing. |  |"}});
    EXPECT_EQ(claims.size(), 4u);
    const std::vector<Text> texts{{"tests/core/one_test.cpp", {"// T1, B2-B3", "f(\"V8\");"}},
                                  {"tests/core/two_test.cpp", {"// B3; T-7"}}};
    EXPECT_EQ(claimFaults(claims, texts),
              (Strings{"tests/core/two_test.cpp names T-7, which docs/tests.md does not have",
                       "docs/tests.md: nothing proves V9"}));
    EXPECT_EQ(claimFaults(claims, {texts[0]}), (Strings{"docs/tests.md: two_test does not name B3",
                                                        "docs/tests.md: nothing proves V9"}));
    EXPECT_EQ(claimFaults({{"T1", {"one_test"}}},
                          {{"tests/one_test.cpp", {"// T1"}}, {"tests/two_test.cpp", {"// T1"}}}),
              Strings{"docs/tests.md: the row of T1 lacks two_test"});
}

TEST(Docs, NamedFilesExist)
{
    EXPECT_EQ(list(fileFaults(sources())), "");
    EXPECT_EQ(list(fileFaults(documents())), "");
}

TEST(Docs, MissingFilesAreSeen)
{
    EXPECT_EQ(fileFaults({{"core/x.h",
                           {"// See core/base/check.h, check.h, shared/path.h and <algorithm>."}}}),
              Strings{});
    EXPECT_EQ(fileFaults({{"core/x.h",
                           {"int x;  // as design"
                            ".md says"}}})
                  .size(),
              1u);
    EXPECT_EQ(fileFaults({{"core/x.h", {"call(\"nowhere.h\");"}}}), Strings{})
        << "code is the compiler's business";
    EXPECT_EQ(fileFaults({{"cmake/x.cmake",
                           {"# as tests/nowhere_test"
                            ".cpp does"}}})
                  .size(),
              1u);
    EXPECT_EQ(fileFaults({{"README.md", {"`assets/nowhere.gltf`"}}}).size(), 1u);
}

TEST(Docs, LinksLeadToFilesAndHeadings)
{
    EXPECT_EQ(list(linkFaults(documents())), "");
    EXPECT_EQ(anchorOf("The viewer's `--path` A-B, and more"), "the-viewers---path-a-b-and-more");
    EXPECT_EQ(linkFaults({{"docs/x.md",
                           {"[a](nowhere.svg), [b](https://example.org/x#y), [c](tests.md#claims)",
                            "[d](docs/tests.md), ![e](../README.md#use), [f](tests.md#nothing)"}}}),
              (Strings{"docs/x.md links to (nowhere.svg), which does not exist",
                       "docs/x.md links to (docs/tests.md), which does not exist",
                       "docs/x.md links to (tests.md#nothing), which does not exist"}));
}

TEST(Docs, NamedTestsExist)
{
    EXPECT_EQ(list(testFaults(documents())), "");
    EXPECT_EQ(testFaults({{"docs/x.md", {"`docs_test`, `gltf_*_test`, `Docs.NamedTestsExist`"}}}),
              Strings{});
    EXPECT_EQ(
        testFaults({{"docs/x.md", {"`nowhere_test`, `no_*_test`, `Docs.NoSuchTest`"}}}).size(), 3u);
}

/// What the program writes beside the pixels would tell where the picture was made.
TEST(Docs, PicturesDoNotTellWhereTheyWereMade)
{
    const Strings pictures = filesBelow({"assets/pictures"});
    EXPECT_GE(pictures.size(), 6u);
    for (const std::string& file : pictures)
        EXPECT_EQ(tests::readAll(kSource / file).find("rekindle:scene"), std::string::npos) << file;
}

TEST(Docs, ArchitectureNamesEveryRoom)
{
    const Pattern room(R"(^\s*room\(([\w/]+)[\s)])");
    const Text plan = readText("docs/architecture.md");
    size_t rooms = 0;
    for (const std::string& line : readText("cmake/rooms.cmake").lines)
        for (const std::string& name : matches(line, room, 1)) {
            ++rooms;
            EXPECT_TRUE(std::any_of(plan.lines.begin(), plan.lines.end(),
                                    [&](const std::string& l) {
                                        return l.find('`' + name + '`') != std::string::npos;
                                    }))
                << "docs/architecture.md does not say what " << name << " holds";
        }
    EXPECT_GT(rooms, 25u);
}

}  // namespace

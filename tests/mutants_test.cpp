// The faults that tests/mutants.sh plants can still be planted: each stands at one place of its
// file, and its tests exist. That the tests notice them takes an hour and is for `./test
// --mutants`.
#include <sstream>
#include <string>
#include <vector>

#include <fnmatch.h>

#include <gtest/gtest.h>

#include "tests/support/files/source_folder.h"
#include "tests/support/files/text_search.h"
#include "tests/support/files/whole_files.h"

namespace {

using tests::countOf;
using tests::kSource;
using tests::readAll;

struct Mutant {
    std::string name, file, from, to, tests;
};

/// The list of the script: a fault per line, its fields separated by '@'.
std::vector<Mutant> mutants()
{
    const std::string script = readAll(kSource / "tests/mutants.sh"), begin = "faults='\n";
    const size_t from = script.find(begin) + begin.size();
    std::istringstream lines(script.substr(from, script.find("\n'", from) - from));
    std::vector<Mutant> found;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream fields(line);
        Mutant m;
        for (std::string* field : {&m.name, &m.file, &m.from, &m.to})
            std::getline(fields, *field, '@');
        std::getline(fields, m.tests);
        found.push_back(m);
    }
    return found;
}

/// Whether a test of the program has a name that one of the patterns (separated by ':') describes.
bool anyTestMatches(const std::string& patterns)
{
    const testing::UnitTest& unit = *testing::UnitTest::GetInstance();
    for (int s = 0; s < unit.total_test_suite_count(); ++s) {
        const testing::TestSuite& suite = *unit.GetTestSuite(s);
        for (int t = 0; t < suite.total_test_count(); ++t) {
            const std::string name = std::string(suite.name()) + '.' + suite.GetTestInfo(t)->name();
            std::istringstream each(patterns.substr(0, patterns.find('-')));
            for (std::string pattern; std::getline(each, pattern, ':');)
                if (fnmatch(pattern.c_str(), name.c_str(), 0) == 0) return true;
        }
    }
    return false;
}

TEST(Mutants, EachFaultHasOnePlaceAndTests)
{
    const std::vector<Mutant> all = mutants();
    ASSERT_GT(all.size(), 30u);
    for (const Mutant& m : all) {
        SCOPED_TRACE(m.name);
        EXPECT_EQ(countOf(readAll(kSource / m.file), m.from), 1u) << m.from << " in " << m.file;
        EXPECT_NE(m.from, m.to);
        EXPECT_TRUE(anyTestMatches(m.tests)) << m.tests;
    }
    EXPECT_EQ(countOf(readAll(kSource / "docs/verification.md"),
                      "plants " + std::to_string(all.size()) + " known"),
              1u);
}

}  // namespace

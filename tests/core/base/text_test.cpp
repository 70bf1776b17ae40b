// Text from files, made fit for terminals and JSON; texts of JSON judged before they are parsed
// (B95, B96).
#include "core/base/text.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/json_scan.h"

namespace {

using core::printable;

TEST(Text, OneLineThatNothingHidesIn)
{
    EXPECT_EQ(printable("wood, häuser, 木, 🌲"), "wood, häuser, 木, 🌲");
    EXPECT_EQ(printable("a\nb\r\tc"), "a\\x0ab\\x0d\\x09c");
    EXPECT_EQ(printable("\x1b[2J\x7f"), "\\x1b[2J\\x7f");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m"),
              "\\x9b31m");  // the one-byte escape of 8-bit terminals
    EXPECT_EQ(printable("a\u202egnp.exe"), "a\\u202egnp.exe");
    EXPECT_EQ(printable("\u2028\u2066\ufeff"), "\\u2028\\u2066\\ufeff");
    EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(core::printableLines("one\n\ttwo\x1b"), "one\n\ttwo\\x1b");
}

TEST(Text, BytesThatAreNoUtf8)
{
    for (const char* bad : {"\xff", "\xc3", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80",
                            "\xf4\x90\x80\x80", "\xf8\x88\x80\x80\x80", "\x80"}) {
        const std::string shown = printable(bad);
        EXPECT_EQ(shown.substr(0, 2), "\\x") << shown;
        EXPECT_NO_THROW((void)nlohmann::json(shown).dump());
    }
    EXPECT_EQ(printable("a\xff"
                        "b"),
              "a\\xff"
              "b");
}

TEST(Text, CutsBetweenLetters)
{
    EXPECT_EQ(printable("häuser", 2), "h...");
    EXPECT_EQ(printable("häuser", 3), "hä...");
    EXPECT_EQ(printable("häuser", 7), "häuser");
    std::string forests;
    for (int i = 0; i < 100; ++i) forests += "🌲";
    for (size_t longest = 0; longest < 50; ++longest)
        EXPECT_NO_THROW((void)nlohmann::json(printable(forests, longest)).dump());
}

TEST(JsonScan, DepthAndPlace)
{
    EXPECT_EQ(core::scanJson("[[{\"a\": \"[[[[\\\"[[\"}]]").problem, "");
    EXPECT_EQ(core::scanJson(std::string(64, '[') + std::string(64, ']')).problem, "");
    EXPECT_EQ(core::scanJson("\n" + std::string(65, '[')).problem,
              "nested deeper than 64 levels at line 2, column 65");
    EXPECT_EQ(core::scanJson(std::string_view("{\0}", 3)).problem, "NUL byte at line 1, column 2");
    const core::JsonScan scan = core::scanJson(R"({"a": [1, 2, {}], ",:[{": 3})");
    EXPECT_EQ(scan.commas, 3u);
    EXPECT_EQ(scan.colons, 2u);
    EXPECT_EQ(scan.containers, 3u);
}

}  // namespace

// The loader's JSON tree holds what the text says, as nlohmann's own tree does, and refuses what
// nlohmann's parser does.
#include "core/gltf/json_tree.h"

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/process/allocation_count.h"

namespace core::gltf {
namespace {

/// The same tree in nlohmann's types.
nlohmann::json copied(const Json& value)
{
    nlohmann::json copy;
    switch (value.kind()) {
    case Json::Kind::null:
        break;
    case Json::Kind::boolean:
        copy = value.boolean();
        break;
    case Json::Kind::whole:
        copy = value.whole();
        break;
    case Json::Kind::negative:
        copy = static_cast<int64_t>(value.number());
        break;
    case Json::Kind::real:
        copy = value.number();
        break;
    case Json::Kind::string:
        copy = value.text();
        break;
    case Json::Kind::array:
        copy = nlohmann::json::array();
        for (size_t i = 0; i < value.size(); ++i) copy.push_back(copied(value[i]));
        break;
    case Json::Kind::object:
        copy = nlohmann::json::object();
        for (size_t i = 0; i < value.size(); ++i) {
            const JsonMember member = value.member(i);
            copy[*member.key] = copied(member.value);
        }
        break;
    }
    return copy;
}

TEST(JsonTree, HoldsWhatTheTextSays)
{
    JsonDocument document;
    for (const char* text :
         {"null", "true", "[]", "{}", "\"\"", R"({"b": [1, -2, 3.5, [], {}], "a": {"": "x"}})",
          R"(["tree \ud83c\udf32", "a\u0000b", "line\n", "\\\"", false, null])",
          "[0, -0, 18446744073709551615, -9223372036854775808, 1e300, 1e-300, "
          "18446744073709551616]",
          R"({"k9":9,"k3":3,"k1":1,"k7":7,"k5":5,"k0":0,"k2":2,"k8":8,"k4":4,"k6":6})"}) {
        ASSERT_EQ(document.parse(text), "") << text;
        EXPECT_EQ(copied(document.root()), nlohmann::json::parse(text)) << text;
    }
}

TEST(JsonTree, FindsMembersOfSmallAndLargeObjects)
{
    JsonDocument document;
    for (const int count : {0, 1, 7, 8, 9, 100}) {
        std::string text = "{";
        for (int i = 0; i < count; ++i)
            text +=
                (i > 0 ? ",\"" : "\"") + std::to_string(i * 37 % 101) + "\":" + std::to_string(i);
        ASSERT_EQ(document.parse(text + "}"), "");
        for (int i = 0; i < 101; ++i) {
            const std::optional<Json> found = document.root().find(std::to_string(i * 37 % 101));
            ASSERT_EQ(found.has_value(), i < count) << i << " of " << count;
            if (i < count) {
                EXPECT_EQ(found->whole(), static_cast<uint64_t>(i));
            }
        }
        EXPECT_FALSE(document.root().find(""));
        EXPECT_FALSE(document.root().find("zzz"));
    }
    ASSERT_EQ(document.parse("[1]"), "");
    EXPECT_FALSE(document.root().find("a"));
}

TEST(JsonTree, OfEqualKeysTheLastCounts)
{
    JsonDocument document;
    const char* text = R"({"b":1,"a":2,"b":{"x":[3]},"a":4,"c":5,"b":[6],"c":7})";
    ASSERT_EQ(document.parse(text), "");
    EXPECT_EQ(copied(document.root()), nlohmann::json::parse(text));
    EXPECT_EQ(document.root().size(), 3u);
    ASSERT_EQ(document.parse(R"({"a":1,"a":2})"), "");
    EXPECT_EQ(document.root().size(), 1u);
    EXPECT_EQ(document.root().find("a")->whole(), 2u);
}

TEST(JsonTree, TextsThatAreNoJsonSayWhyAndLeaveNothing)
{
    JsonDocument document;
    for (const char* text :
         {"", "{", "[1,]", "{\"a\":}", "[1] 2", "nul", "[1e999]", "\"\xff\"", "{a:1}"}) {
        ASSERT_EQ(document.parse("[1, \"kept\"]"), "");
        EXPECT_NE(document.parse(text), "") << text;
        EXPECT_EQ(document.root().kind(), Json::Kind::null) << text;
    }
}

TEST(JsonTree, RefusesWhatNlohmannRefuses)
{
    const std::vector<std::string> seeds{
        R"({"a": [1, -2.5e+3, 0.1E-2, true, false, null], "b\u00e4\ud83c\udf32\n": {"": "x\/y"}})",
        R"([[], {}, [[]], "\"\\\b\f\r\t", 1e5, -0, 0, -0.0, 123456789012345678901234567890])",
        " {\t\"häuser 木 🌲\" : [ ] }\r\n", "\xef\xbb\xbf[1]",
        R"(["\ud83c", "\udf32", "\u12g4", "\x", 01, 1., .5, 1e, +1, 1e400, -1e-400, 4.9e-324])"};
    const std::string letters =
        "{}[]\",:\\/ \n0123456789+-.eEtrufalsn\x01\x7f\x80\xc3\xa4\xed\xa0\xf4\xff";
    std::mt19937 random(11);
    JsonDocument document;
    const auto check = [&](const std::string& text) {
        const bool fine = document.parse(text).empty();
        ASSERT_EQ(fine, nlohmann::json::accept(text)) << text;
        if (fine) {
            ASSERT_EQ(copied(document.root()), nlohmann::json::parse(text)) << text;
        }
    };
    for (const std::string& seed : seeds) {
        for (size_t cut = 0; cut <= seed.size(); ++cut) check(seed.substr(0, cut));
        for (int i = 0; i < 5000; ++i) {
            std::string text = seed;
            for (auto changes = 1 + random() % 3; changes > 0; --changes) {
                const size_t at = random() % text.size();
                const char letter = letters[random() % letters.size()];
                switch (random() % 3) {
                case 0:
                    text[at] = letter;
                    break;
                case 1:
                    text.insert(at, 1, letter);
                    break;
                default:
                    text.erase(at, text.size() > 1 ? 1 : 0);
                }
            }
            check(text);
        }
    }
}

TEST(JsonTree, NumbersOfVeryManyDigitsOrLargeExponents)
{
    const std::string zeros(400, '0'), nines(400, '9');
    JsonDocument document;
    for (const std::string& text :
         {"0." + zeros + "1", "-0." + zeros + "1e400", std::string("0.000000001e-2147483639"),
          "0." + nines, "1e-" + nines, "0e" + nines, "1" + zeros + "e-400", "1" + zeros + ".5e-300",
          std::string("1e-400"), std::string("2.2250738585072011e-308"),
          std::string("1.7976931348623157e308")}) {
        ASSERT_EQ(document.parse("[" + text + "]"), "") << text;
        EXPECT_EQ(document.root()[0].number(), nlohmann::json::parse(text).get<double>()) << text;
    }
    for (const std::string& text : {nines, "1" + zeros + "e308", "1e" + nines, "-" + nines})
        EXPECT_NE(document.parse(text), "") << text;
}

TEST(JsonTree, TextIsReadToItsEndAndNotBeyond)
{
    JsonDocument document;
    const std::string text = "[1, 23]4";
    ASSERT_EQ(document.parse(std::string_view(text).substr(0, 7)), "");
    EXPECT_NE(document.parse(text), "");
    EXPECT_NE(document.parse(std::string_view("[1]\0[2]", 7)), "");
    EXPECT_NE(document.parse(R"(["\udc00"])"), "") << "half of a pair";
    EXPECT_NE(document.parse(R"({"\udfff": 1})"), "");
}

TEST(JsonTree, NumbersAloneKeepTheirKinds)
{
    JsonDocument document;
    ASSERT_EQ(document.parse("[[3, -4, 0.5, -0.0, 9007199254740992, -7.0], [1, 9007199254740993]]"),
              "");
    const Json plain = document.root()[0], large = document.root()[1];
    EXPECT_EQ(plain[0].whole(), 3u);
    EXPECT_EQ(plain[1].kind(), Json::Kind::negative);
    EXPECT_EQ(plain[1].number(), -4);
    EXPECT_EQ(plain[2].kind(), Json::Kind::real);
    EXPECT_TRUE(std::signbit(plain[3].number()));
    EXPECT_EQ(plain[4].whole(), 9007199254740992u);
    EXPECT_EQ(plain[5].number(), -7);
    EXPECT_EQ(large[1].whole(), 9007199254740993u) << "no double holds it";
}

TEST(JsonTree, NumbersThatFloatsHoldAndThoseThatTheyDoNot)
{
    JsonDocument document;
    for (const char* text :
         {"[0.5, -0.0, 16777216, -3, 3.4028234663852886e38]", "[0.5, 0.1]", "[16777217]",
          "[3.4028235677973366e38, 1]", "[-1e300]", "[1e-60, 2]", "[1.401298464324817e-45, -7]"}) {
        ASSERT_EQ(document.parse(text), "") << text;
        EXPECT_EQ(copied(document.root()), nlohmann::json::parse(text)) << text;
    }
}

TEST(JsonTree, ObjectsThatAreAlikeButForAKindOrAnOrder)
{
    JsonDocument document;
    std::string text = "[";
    for (int i = 0; i < 300; ++i)
        text +=
            R"({"a":1,"b":"x"},{"b":"x","a":1},{"a":1.5,"b":"x"},{"a":-1,"b":[]},{"a":1},{"b":)" +
            std::to_string(i) + R"(},{"a":0,"b":1,"a":2},{"b":null,"a":{}},)";
    text += "{}]";
    ASSERT_EQ(document.parse(text), "");
    EXPECT_EQ(copied(document.root()), nlohmann::json::parse(text));
}

TEST(JsonTree, MemoryOfKeysIsAskedForBeforeItIsTaken)
{
    JsonDocument document;
    uint64_t asked = 0;
    const auto reserve = [&](uint64_t bytes) { asked += bytes; };
    ASSERT_EQ(document.parse(R"([{"a": 1, "b": 2}, {"b": 3, "a": 4}, {"a": 5}])", reserve), "");
    EXPECT_GT(asked, 2u);
    const uint64_t two = asked;
    asked = 0;
    ASSERT_EQ(document.parse(R"({"a": 1, "b": 2})", reserve), "");
    EXPECT_EQ(asked, two) << "each key once";
    const std::string key(100'000, 'k');
    asked = 0;
    ASSERT_EQ(document.parse("{\"" + key + "\": 1}", reserve), "");
    EXPECT_GT(asked, key.size());
    asked = 0;
    ASSERT_EQ(document.parse("\"" + key + "\"", reserve), "");
    EXPECT_GT(asked, key.size()) << "where the parser keeps a string while it reads it";
    struct Enough {};
    EXPECT_THROW(document.parse(R"({"a": 1})", [](uint64_t) { throw Enough(); }), Enough);
}

TEST(JsonTree, AMillionObjectsLieInAFewBlocks)
{
    constexpr size_t kCount = 1'000'000;
    std::string text = "[{\"mesh\":0}";
    for (size_t i = 1; i < kCount; ++i) text += ",{\"mesh\":0}";
    text += "]";
    JsonDocument document;
    const uint64_t before = tests::allocations();
    ASSERT_EQ(document.parse(text), "");
    if (tests::allocationsAreCounted()) {
        EXPECT_LT(tests::allocations() - before, 200u);
    }
    ASSERT_EQ(document.root().size(), kCount);
    EXPECT_EQ(document.root()[kCount - 1].find("mesh")->whole(), 0u);
}

}  // namespace
}  // namespace core::gltf

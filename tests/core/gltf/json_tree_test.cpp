// The loader's JSON tree holds what the text says, as nlohmann's own tree does.
#include "core/gltf/json_tree.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/allocation_count.h"

namespace {

using core::gltf::Json;
using core::gltf::JsonDocument;
using core::gltf::JsonMember;

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
        for (const Json& element : value.elements()) copy.push_back(copied(element));
        break;
    case Json::Kind::object:
        copy = nlohmann::json::object();
        for (const JsonMember& member : value.members()) copy[*member.key] = copied(member.value);
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
            const Json* found = document.root().find(std::to_string(i * 37 % 101));
            ASSERT_EQ(found != nullptr, i < count) << i << " of " << count;
            if (i < count) {
                EXPECT_EQ(found->whole(), static_cast<uint64_t>(i));
            }
        }
        EXPECT_EQ(document.root().find(""), nullptr);
        EXPECT_EQ(document.root().find("zzz"), nullptr);
    }
    ASSERT_EQ(document.parse("[1]"), "");
    EXPECT_EQ(document.root().find("a"), nullptr);
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

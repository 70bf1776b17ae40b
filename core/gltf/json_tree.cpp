// See json_tree.h.
#include "core/gltf/json_tree.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/base/check.h"

namespace core::gltf {

static_assert(sizeof(Json) == 16 && sizeof(JsonMember) == 24);
static_assert(std::is_trivially_copyable_v<Json> && std::is_trivially_copyable_v<JsonMember>);

namespace {

constexpr double kLargestPlain = 9'007'199'254'740'992;  // 2^53: all whole numbers up to it

/// A number of which the value tells the kind: whole, if it is a whole number.
Json plainNumber(double value)
{
    const bool isWhole = std::abs(value) <= kLargestPlain && value == std::floor(value);
    if (!isWhole || (value == 0 && std::signbit(value))) return Json(value);
    return value < 0 ? Json(static_cast<int64_t>(value)) : Json(static_cast<uint64_t>(value));
}

}  // namespace

bool isPlainNumber(const Json& value)
{
    switch (value.kind()) {
    case Json::Kind::whole:
        return value.whole() <= static_cast<uint64_t>(kLargestPlain);
    case Json::Kind::negative:  // -0 is one
        return value.number() < 0 && value.number() >= -kLargestPlain;
    default:
        return value.kind() == Json::Kind::real;
    }
}

Json::Json(std::string_view text) : size_(static_cast<uint32_t>(text.size())), kind_(Kind::string)
{
    content_.text = text.data();
}

Json::Json(std::span<const Json> elements)
    : size_(static_cast<uint32_t>(elements.size())), kind_(Kind::array)
{
    content_.elements = elements.data();
}

Json::Json(std::span<const double> numbers)
    : size_(static_cast<uint32_t>(numbers.size())), kind_(Kind::array), isNumbers_(true)
{
    content_.numbers = numbers.data();
}

Json::Json(std::span<const JsonMember> members)
    : size_(static_cast<uint32_t>(members.size())), kind_(Kind::object)
{
    content_.members = members.data();
}

bool Json::isNumber() const
{
    return kind_ == Kind::whole || kind_ == Kind::negative || kind_ == Kind::real;
}

bool Json::boolean() const
{
    CHECK(isBoolean());
    return content_.whole != 0;
}

uint64_t Json::whole() const
{
    CHECK(kind_ == Kind::whole);
    return content_.whole;
}

double Json::number() const
{
    CHECK(isNumber());
    if (kind_ == Kind::real) return content_.real;
    return kind_ == Kind::whole ? static_cast<double>(content_.whole)
                                : static_cast<double>(content_.negative);
}

std::string_view Json::text() const
{
    CHECK(isString());
    return {content_.text, size_};
}

Json Json::operator[](size_t i) const
{
    CHECK(isArray() && i < size_);
    return isNumbers_ ? plainNumber(content_.numbers[i]) : content_.elements[i];
}

std::span<const JsonMember> Json::members() const
{
    return isObject() ? std::span(content_.members, size_) : std::span<const JsonMember>();
}

const Json* Json::find(std::string_view key) const
{
    constexpr size_t kFew = 8;  // so many lengths are compared faster than three keys
    const std::span<const JsonMember> all = members();
    auto found = all.begin();
    if (all.size() > kFew)
        found = std::lower_bound(
            all.begin(), all.end(), key,
            [](const JsonMember& member, std::string_view wanted) { return *member.key < wanted; });
    else
        while (found != all.end() && *found->key != key) ++found;
    return found != all.end() && *found->key == key ? &found->value : nullptr;
}

void JsonDocument::clear()
{
    root_ = {};
    keys_.clear();
    memory_.release();
}

uint64_t jsonTreeBytes(uint64_t commas, uint64_t colons, uint64_t containers)
{
    return (commas + containers) * sizeof(Json) + colons * sizeof(JsonMember);
}

}  // namespace core::gltf

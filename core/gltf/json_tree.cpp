// See json_tree.h.
#include "core/gltf/json_tree.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "core/base/check.h"
#include "core/gltf/json_storage.h"

namespace core::gltf {

static_assert(std::is_trivially_copyable_v<Json> && std::is_trivially_copyable_v<JsonMember>);

namespace {

/// A number of which the value tells the kind: whole, if it is a whole number.
Json plainNumber(double value)
{
    const bool isWhole = std::abs(value) <= kLargestPlain && value == std::floor(value);
    if (!isWhole || (value == 0 && std::signbit(value))) return Json(value);
    return value < 0 ? Json(static_cast<int64_t>(value)) : Json(static_cast<uint64_t>(value));
}

}  // namespace

Json Json::emptyArray()
{
    static const Array none;
    Content content;
    content.array = &none;
    return {Kind::array, content};
}

Json Json::emptyObject()
{
    static const JsonShape noKeys;
    static const Members none{&noKeys};
    Content content;
    content.members = &none;
    return {Kind::object, content};
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

std::string_view Json::text() const
{
    CHECK(isString());
    return content_.text->view();
}

size_t Json::size() const
{
    if (isArray()) return content_.array->size;
    return isObject() ? content_.members->shape->size : 0;
}

Json Json::operator[](size_t i) const
{
    CHECK(isArray() && i < content_.array->size);
    const Array& array = *content_.array;
    switch (array.of) {
    case Array::Of::floats:
        return plainNumber(static_cast<double>(array.elements<float>()[i]));
    case Array::Of::doubles:
        return plainNumber(array.elements<double>()[i]);
    case Array::Of::kind:
        return {array.kind, array.elements<Content>()[i]};
    case Array::Of::values:
        break;
    }
    return array.elements<Json>()[i];
}

JsonMember Json::member(size_t i) const
{
    CHECK(isObject() && i < size());
    const Members& members = *content_.members;
    return {members.shape->keys()[i], {members.shape->kinds()[i], members.contents()[i]}};
}

std::optional<Json> Json::find(std::string_view key) const
{
    constexpr size_t kFew = 8;  // so many lengths are compared faster than three keys
    if (!isObject()) return std::nullopt;
    const std::span<const std::string* const> keys = content_.members->shape->keys();
    auto found = keys.begin();
    if (keys.size() > kFew)
        found = std::lower_bound(
            keys.begin(), keys.end(), key,
            [](const std::string* one, std::string_view wanted) { return *one < wanted; });
    else
        while (found != keys.end() && **found != key) ++found;
    if (found == keys.end() || **found != key) return std::nullopt;
    return member(static_cast<size_t>(found - keys.begin())).value;
}

void JsonDocument::clear()
{
    root_ = {};
    keys_.clear();
    memory_.release();
}

uint64_t jsonTreeBytes(uint64_t commas, uint64_t colons, uint64_t containers)
{
    constexpr uint64_t kElement = 24;    // a value, and what a string takes beside its letters
    constexpr uint64_t kMember = 24;     // a content and a string's head; its key and kind
    constexpr uint64_t kContainer = 32;  // its head, that of a shape, and what alignment leaves
    return (commas + containers) * kElement + colons * kMember + containers * kContainer;
}

}  // namespace core::gltf

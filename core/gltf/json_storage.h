// How the values of a JSON tree lie in its memory. Private to json_tree.cpp and json_parse.cpp.
#pragma once

#include <span>

#include "core/gltf/json_tree.h"

namespace core::gltf {

/// The letters follow.
struct Json::Text {
    uint32_t size = 0;

    std::string_view view() const { return {reinterpret_cast<const char*>(this + 1), size}; }
};

/// The elements follow: floats or doubles, each a plain number; contents, if all are of one kind;
/// or whole values.
struct Json::Array {
    enum class Of : uint8_t { floats, doubles, kind, values };

    uint32_t size = 0;
    Of of = Of::floats;
    Kind kind = Kind::null;  // of all elements, for Of::kind

    template <class T> std::span<const T> elements() const
    {
        return {reinterpret_cast<const T*>(this + 1), size};
    }
};

/// Keys, ascending, and the kinds of their values: what objects may have in common. Both follow.
struct JsonShape {
    uint64_t size = 0;

    std::span<const std::string* const> keys() const
    {
        return {reinterpret_cast<const std::string* const*>(this + 1), size};
    }
    std::span<const Json::Kind> kinds() const
    {
        return {reinterpret_cast<const Json::Kind*>(keys().data() + size), size};
    }
};

/// An object; the contents of its members follow.
struct Json::Members {
    const JsonShape* shape = nullptr;

    std::span<const Content> contents() const
    {
        return {reinterpret_cast<const Content*>(this + 1), shape->size};
    }
};

static_assert(sizeof(Json) == 16 && sizeof(Json::Content) == 8 && sizeof(Json::Array) == 8);

constexpr double kLargestPlain = 9'007'199'254'740'992;  // 2^53: all whole numbers up to it

/// Whether a double tells all of it: its value, and by that its kind.
inline bool isPlainNumber(const Json& value)
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

}  // namespace core::gltf

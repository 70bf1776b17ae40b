// The JSON text of a scene as a tree. Its values lie side by side in a few large blocks: 8 bytes
// each, 4 in an array of numbers that are floats; keys are held once, and which keys an object has
// and of what kinds their values are once for all objects that are alike. A scene of a million
// nodes takes an eighth of the memory of nlohmann's tree, and is gone without a walk through it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory_resource>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/base/check.h"

namespace core::gltf {

struct JsonMember;

/// One value of a document; a handle, valid as long as its JsonDocument.
class Json {
public:
    /// Whole numbers with a minus are of a kind of their own: no index or count may be one.
    enum class Kind : uint8_t { null, boolean, whole, negative, real, string, array, object };

    struct Text;
    struct Array;
    struct Members;
    /// What a value is besides its kind.
    union Content {
        uint64_t whole = 0;
        int64_t negative;
        double real;
        const Text* text;
        const Array* array;
        const Members* members;
    };

    Json() = default;  // null
    Json(Kind kind, Content content) : content_(content), kind_(kind) {}
    explicit Json(bool value) : kind_(Kind::boolean) { content_.whole = value ? 1 : 0; }
    explicit Json(uint64_t value) : kind_(Kind::whole) { content_.whole = value; }
    explicit Json(int64_t value) : kind_(Kind::negative) { content_.negative = value; }
    explicit Json(double value) : kind_(Kind::real) { content_.real = value; }
    static Json emptyArray();
    static Json emptyObject();

    Kind kind() const { return kind_; }
    Content content() const { return content_; }
    bool isBoolean() const { return kind_ == Kind::boolean; }
    bool isNumber() const
    {
        return kind_ == Kind::whole || kind_ == Kind::negative || kind_ == Kind::real;
    }
    bool isString() const { return kind_ == Kind::string; }
    bool isArray() const { return kind_ == Kind::array; }
    bool isObject() const { return kind_ == Kind::object; }

    bool boolean() const;    // of a boolean
    uint64_t whole() const;  // of a whole number
    double number() const    // of any number
    {
        CHECK(isNumber());
        if (kind_ == Kind::real) return content_.real;
        return kind_ == Kind::whole ? static_cast<double>(content_.whole)
                                    : static_cast<double>(content_.negative);
    }
    std::string_view text() const;  // of a string

    /// Elements of an array or members of an object; 0 for other values.
    size_t size() const;
    /// Element of an array. CHECKs that there is one. Among numbers alone 1.0 is told as 1.
    Json operator[](size_t i) const;
    /// Member of an object, in the order of the keys. CHECKs that there is one.
    JsonMember member(size_t i) const;
    /// The member of that name; nothing when there is none, or this is no object.
    std::optional<Json> find(std::string_view key) const;

private:
    Content content_;
    Kind kind_ = Kind::null;
};

struct JsonMember {
    const std::string* key = nullptr;
    Json value;
};

/// A parsed text and the memory of its tree.
class JsonDocument {
public:
    /// Told, before it is taken, of memory (in bytes) that jsonTreeBytes does not know of. May
    /// throw.
    using Reserve = std::function<void(uint64_t)>;

    /// Replaces the tree by that of `text`, which must not nest deeper than scanJson allows and be
    /// shorter than 4 GiB. Returns what is wrong with the text, in nlohmann's words; empty:
    /// nothing. Of members with equal keys the last one counts.
    std::string parse(std::string_view text, const Reserve& reserve = {});

    const Json& root() const { return root_; }

    /// Leaves null behind.
    void clear();

private:
    class Builder;

    std::pmr::monotonic_buffer_resource memory_;
    std::set<std::string, std::less<>> keys_;  // no hash: files can be made to fill one bucket
    Json root_;
};

/// What a tree takes at most, but for its keys and strings, that is parsed from text with so many
/// commas, colons and brackets. Strings are shorter than the text.
uint64_t jsonTreeBytes(uint64_t commas, uint64_t colons, uint64_t containers);

}  // namespace core::gltf

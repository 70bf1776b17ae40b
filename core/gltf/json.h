// Checked reading of JSON objects. Each value is taken through a function that verifies its type
// and range and knows its JSON pointer. Two families: the plain ones refuse the file, the `soft`
// ones warn and fall back.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "core/gltf/load.h"

namespace core::gltf {

/// Largest magnitude that a number of a scene may have: products of two still fit a float.
constexpr double kHuge = 1e18;

/// Bytes of a name that are kept.
constexpr size_t kLongestName = 256;

/// Appends a reference token to a JSON pointer (RFC 6901).
std::string child(const std::string& pointer, std::string_view token);
std::string child(const std::string& pointer, size_t index);

/// One JSON object at a known place. Holds references only: the document outlives it.
class Object {
public:
    Object(Load& load, const Json& value, std::string pointer);  // refuses when it is not an object

    const std::string& pointer() const { return pointer_; }
    std::string at(std::string_view key) const { return child(pointer_, key); }
    bool has(const char* key) const { return find(key).has_value(); }
    std::optional<Json> find(const char* key) const;
    const Json& json() const { return value_; }
    Load& load() const { return *load_; }

    // Structure: a value of the wrong kind refuses the file.
    uint64_t integer(const char* key, uint64_t fallback) const;
    uint64_t requiredInteger(const char* key) const;
    /// Index into an array of `limit` elements called `array`; -1 when absent.
    int index(const char* key, size_t limit, const char* array) const;
    int requiredIndex(const char* key, size_t limit, const char* array) const;
    std::string requiredString(const char* key) const;
    bool boolean(const char* key, bool fallback) const;
    std::optional<Object> object(const char* key) const;
    /// False when absent; otherwise exactly N finite numbers.
    template <size_t N> bool numbers(const char* key, std::array<double, N>& out) const
    {
        return numbers(key, out.data(), N);
    }
    /// The array of that name, or an empty one.
    Json array(const char* key) const;
    /// Element `i` of that array, as an object.
    Object element(const char* key, size_t i) const;

    // Quality: a fault is counted as a warning and the fallback taken.
    std::string softString(const char* key) const;
    /// Printable; empty when there is none.
    std::string name() const;
    bool softBoolean(const char* key, bool fallback) const;
    /// Clamped to [low, high].
    double softNumber(const char* key, double fallback, double low, double high) const;
    template <size_t N>
    std::array<double, N> softNumbers(const char* key, std::array<double, N> fallback, double low,
                                      double high) const
    {
        softNumbers(key, fallback.data(), N, low, high);
        return fallback;
    }
    std::optional<Object> softObject(const char* key, const char* consequence = "ignored") const;
    int softIndex(const char* key, size_t limit, const char* array, const char* consequence) const;

    /// The extension of that name on this object, if it is there and an object.
    std::optional<Object> extension(const char* name) const;

    /// `extras`, if they are an object: glTF lets every tool put any value there, so that another
    /// one is no fault.
    std::optional<Object> extras() const;

private:
    bool numbers(const char* key, double* out, size_t count) const;
    void softNumbers(const char* key, double* values, size_t count, double low, double high) const;

    Load* load_;
    Json value_;
    std::string pointer_;
};

/// A non-negative whole number, also when written as 3.0; nothing for anything else.
std::optional<uint64_t> wholeNumber(const Json& value);

/// Short form of a value for messages.
std::string describe(const Json& value);
std::string describe(double value);
std::string describe(std::string_view text);

/// Number of elements of an array at the top of the document (0 when absent; refuses another type).
size_t countOf(const Load& load, const char* key);

/// Element `i` of an array at the top of the document.
Object topLevel(Load& load, const char* key, size_t i);

}  // namespace core::gltf

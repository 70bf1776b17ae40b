// Checked reading of JSON objects.
#include "core/gltf/json.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/base/text.h"

namespace core::gltf {

std::string child(const std::string& pointer, std::string_view token)
{
    std::string result = pointer + '/';
    for (const char c : token) {
        if (c == '~')
            result += "~0";
        else if (c == '/')
            result += "~1";
        else
            result += c;
    }
    return result;
}

std::string child(const std::string& pointer, size_t index)
{
    return pointer + '/' + std::to_string(index);
}

std::optional<uint64_t> wholeNumber(const Json& value)
{
    if (value.kind() == Json::Kind::whole) return value.whole();
    if (value.kind() != Json::Kind::real) return std::nullopt;
    const double number = value.number();
    if (!(number >= 0 && number < 9.0e15) || number != std::floor(number)) return std::nullopt;
    return static_cast<uint64_t>(number);
}

std::string describe(const Json& value)
{
    switch (value.kind()) {
    case Json::Kind::null:
        return "null";
    case Json::Kind::boolean:
        return value.boolean() ? "true" : "false";
    case Json::Kind::whole:
        return std::to_string(value.whole());
    case Json::Kind::negative:
        return std::to_string(static_cast<int64_t>(value.number()));
    case Json::Kind::real:
        return describe(value.number());
    case Json::Kind::string:
        return describe(value.text());
    case Json::Kind::array:
        return "an array of " + std::to_string(value.size());
    case Json::Kind::object:
        break;
    }
    return "an object";
}

std::string describe(double value)
{
    return nlohmann::json(value).dump();
}

std::string describe(std::string_view text)
{
    constexpr size_t kLongest = 40;
    using nlohmann::json;
    return printable(json(text).dump(-1, ' ', false, json::error_handler_t::replace), kLongest);
}

size_t countOf(const Load& load, const char* key)
{
    const std::optional<Json> found = load.document.root().find(key);
    if (!found) return 0;
    if (!found->isArray())
        load.refuse("TYPE_MISMATCH", std::string("/") + key,
                    "is " + describe(*found) + ", must be an array");
    return found->size();
}

Object topLevel(Load& load, const char* key, size_t i)
{
    const std::optional<Json> all = load.document.root().find(key);
    CHECK(all);
    return {load, (*all)[i], child(std::string("/") + key, i)};
}

Object::Object(Load& load, const Json& value, std::string pointer)
    : load_(&load), value_(value), pointer_(std::move(pointer))
{
    if (!value.isObject())
        load.refuse("TYPE_MISMATCH", pointer_, "is " + describe(value) + ", must be an object");
}

std::optional<Json> Object::find(const char* key) const
{
    return value_.find(key);
}

// --- structure

uint64_t Object::integer(const char* key, uint64_t fallback) const
{
    return has(key) ? requiredInteger(key) : fallback;
}

uint64_t Object::requiredInteger(const char* key) const
{
    const std::optional<Json> value = find(key);
    if (!value)
        load_->refuse("UNDEFINED_PROPERTY", pointer_, std::string("'") + key + "' is missing");
    const std::optional<uint64_t> whole = wholeNumber(*value);
    if (!whole)
        load_->refuse("TYPE_MISMATCH", at(key),
                      "is " + describe(*value) + ", must be a whole number, not negative");
    return *whole;
}

int Object::index(const char* key, size_t limit, const char* array) const
{
    if (!has(key)) return -1;
    const uint64_t value = requiredInteger(key);
    if (value >= limit)
        load_->refuse("UNRESOLVED_REFERENCE", at(key),
                      "refers to " + std::string(array) + " " + std::to_string(value) +
                          ", there are " + std::to_string(limit));
    return static_cast<int>(value);
}

int Object::requiredIndex(const char* key, size_t limit, const char* array) const
{
    requiredInteger(key);
    return index(key, limit, array);
}

std::string Object::requiredString(const char* key) const
{
    const std::optional<Json> value = find(key);
    if (!value)
        load_->refuse("UNDEFINED_PROPERTY", pointer_, std::string("'") + key + "' is missing");
    if (!value->isString())
        load_->refuse("TYPE_MISMATCH", at(key), "is " + describe(*value) + ", must be a string");
    return std::string(value->text());
}

bool Object::boolean(const char* key, bool fallback) const
{
    const std::optional<Json> value = find(key);
    if (!value) return fallback;
    if (!value->isBoolean())
        load_->refuse("TYPE_MISMATCH", at(key),
                      "is " + describe(*value) + ", must be true or false");
    return value->boolean();
}

std::optional<Object> Object::object(const char* key) const
{
    const std::optional<Json> value = find(key);
    if (!value) return std::nullopt;
    return Object(*load_, *value, at(key));
}

bool Object::numbers(const char* key, double* out, size_t count) const
{
    const std::optional<Json> value = find(key);
    if (!value) return false;
    if (!value->isArray() || value->size() != count)
        load_->refuse("ARRAY_LENGTH_NOT_IN_LIST", at(key),
                      "is " + describe(*value) + ", must be an array of " + std::to_string(count) +
                          " numbers");
    for (size_t i = 0; i < count; ++i) {
        const Json number = (*value)[i];
        if (!number.isNumber())
            load_->refuse("TYPE_MISMATCH", child(at(key), i),
                          "is " + describe(number) + ", must be a number");
        out[i] = number.number();
    }
    return true;
}

Json Object::array(const char* key) const
{
    const std::optional<Json> value = find(key);
    if (!value) return Json::emptyArray();
    if (!value->isArray())
        load_->refuse("TYPE_MISMATCH", at(key), "is " + describe(*value) + ", must be an array");
    return *value;
}

Object Object::element(const char* key, size_t i) const
{
    return {*load_, array(key)[i], child(at(key), i)};
}

// --- quality

std::string Object::softString(const char* key) const
{
    const std::optional<Json> value = find(key);
    if (!value) return {};
    if (value->isString()) return std::string(value->text());
    load_->warn("TYPE_MISMATCH", at(key),
                "is " + describe(*value) + ", must be a string — ignored");
    return {};
}

std::string Object::name() const
{
    return printable(softString("name"), kLongestName);
}

bool Object::softBoolean(const char* key, bool fallback) const
{
    const std::optional<Json> value = find(key);
    if (!value) return fallback;
    if (value->isBoolean()) return value->boolean();
    load_->warn("TYPE_MISMATCH", at(key),
                "is " + describe(*value) + ", must be true or false — ignored");
    return fallback;
}

double Object::softNumber(const char* key, double fallback, double low, double high) const
{
    const std::optional<Json> value = find(key);
    if (!value) return fallback;
    if (!value->isNumber()) {
        load_->warn("TYPE_MISMATCH", at(key),
                    "is " + describe(*value) + ", must be a number — ignored");
        return fallback;
    }
    const double number = value->number();
    if (number >= low && number <= high) return number;
    const double clamped = std::clamp(number, low, high);
    load_->warn("VALUE_NOT_IN_RANGE", at(key),
                "is " + describe(*value) + ", must be in [" + describe(low) + ", " +
                    describe(high) + "] — clamped");
    return clamped;
}

void Object::softNumbers(const char* key, double* values, size_t count, double low,
                         double high) const
{
    const std::optional<Json> value = find(key);
    if (!value) return;
    bool isNumbers = value->isArray() && value->size() == count;
    for (size_t i = 0; isNumbers && i < count; ++i) isNumbers = (*value)[i].isNumber();
    if (!isNumbers) {
        load_->warn("ARRAY_LENGTH_NOT_IN_LIST", at(key),
                    "is " + describe(*value) + ", must be an array of " + std::to_string(count) +
                        " numbers — ignored");
        return;
    }
    bool clamped = false;
    for (size_t i = 0; i < count; ++i) {
        const double number = (*value)[i].number();
        values[i] = std::clamp(number, low, high);
        clamped = clamped || values[i] != number;
    }
    if (clamped)
        load_->warn("VALUE_NOT_IN_RANGE", at(key),
                    "has values outside [" + describe(low) + ", " + describe(high) + "] — clamped");
}

std::optional<Object> Object::softObject(const char* key, const char* consequence) const
{
    const std::optional<Json> value = find(key);
    if (!value) return std::nullopt;
    if (value->isObject()) return Object(*load_, *value, at(key));
    load_->warn("TYPE_MISMATCH", at(key),
                "is " + describe(*value) + ", must be an object — " + consequence);
    return std::nullopt;
}

int Object::softIndex(const char* key, size_t limit, const char* array,
                      const char* consequence) const
{
    const std::optional<Json> value = find(key);
    if (!value) return -1;
    const std::optional<uint64_t> whole = wholeNumber(*value);
    if (whole && *whole < limit) return static_cast<int>(*whole);
    load_->warn("UNRESOLVED_REFERENCE", at(key),
                "is " + describe(*value) + ", there are " + std::to_string(limit) + " " + array +
                    " — " + consequence);
    return -1;
}

std::optional<Object> Object::extension(const char* name) const
{
    const std::optional<Json> extensions = find("extensions");
    if (!extensions || !extensions->isObject()) return std::nullopt;
    return Object(*load_, *extensions, at("extensions")).softObject(name);
}

std::optional<Object> Object::extras() const
{
    const std::optional<Json> value = find("extras");
    if (!value || !value->isObject()) return std::nullopt;
    return Object(*load_, *value, at("extras"));
}

}  // namespace core::gltf

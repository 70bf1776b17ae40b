// See json_tree.h.
#include "core/gltf/json_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/gltf/json_reader.h"

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

/// What JsonReader tells. Members and elements of the open containers lie on one stack; those of a
/// container that ends move into the document's memory, side by side.
class JsonDocument::Builder {
public:
    Builder(JsonDocument& document, const Reserve& reserve) : document_(document), reserve_(reserve)
    {}

    void null() { take(Json()); }
    void boolean(bool value) { take(Json(value)); }
    void whole(uint64_t value) { take(Json(value)); }
    void negative(int64_t value) { take(Json(value)); }
    void real(double value) { take(Json(value)); }
    void string(std::string_view value)
    {
        const std::span<const char> kept = keep(std::span<const char>(value));
        take(Json(std::string_view(kept.data(), kept.size())));
    }
    void key(std::string_view text) { stack_.push_back({keyOf(text), {}}); }
    void startObject() { open(true); }
    void endObject()
    {
        const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(open_.back().first);
        sortMembers(first);
        close(Json(keep(std::span<const JsonMember>(first, stack_.end()))));
    }
    void startArray() { open(false); }
    void endArray()
    {
        const std::span<const JsonMember> top = std::span(stack_).subspan(open_.back().first);
        const bool isNumbers = std::ranges::all_of(
            top, [](const JsonMember& member) { return isPlainNumber(member.value); });
        close(isNumbers ? arrayOf<double>(top, [](const Json& element) { return element.number(); })
                        : arrayOf<Json>(top, [](const Json& element) { return element; }));
    }

private:
    struct Container {
        size_t first;  // of its members or elements on the stack
        bool object;
    };

    void open(bool object) { open_.push_back({stack_.size(), object}); }

    void close(const Json& value)
    {
        stack_.resize(open_.back().first);
        open_.pop_back();
        take(value);
    }

    void take(const Json& value)
    {
        if (open_.empty())
            document_.root_ = value;
        else if (open_.back().object)
            stack_.back().value = value;  // its key came before
        else
            stack_.push_back({nullptr, value});
    }

    /// The key as the document holds it. Most of a text's keys were met before: few are looked for
    /// in the set.
    const std::string* keyOf(std::string_view text)
    {
        const size_t place =
            text.empty() ? 0 : static_cast<unsigned char>(text.front() + text.back());
        const std::string*& met = met_.at((place + text.size()) % met_.size());
        if (met != nullptr && *met == text) return met;
        auto found = document_.keys_.find(text);
        if (found == document_.keys_.end()) {
            constexpr uint64_t kNodeBytes = 80;  // of the set
            if (reserve_) reserve_(kNodeBytes + text.size());
            found = document_.keys_.emplace(text).first;
        }
        return met = &*found;
    }

    template <class T, class Convert>
    Json arrayOf(std::span<const JsonMember> elements, const Convert& convert)
    {
        T* values = allocate<T>(elements.size());
        std::ranges::transform(elements, values, convert, &JsonMember::value);
        return Json(std::span<const T>(values, elements.size()));
    }

    /// Sorts the members on the stack from `first` on; of equal keys the last one stays.
    void sortMembers(std::vector<JsonMember>::iterator first)
    {
        const auto inOrder = [](const JsonMember& a, const JsonMember& b) {
            return *a.key < *b.key;
        };
        const auto notAbove = [&](const JsonMember& a, const JsonMember& b) {
            return !inOrder(a, b);
        };
        if (std::adjacent_find(first, stack_.end(), notAbove) == stack_.end()) return;
        std::stable_sort(first, stack_.end(), inOrder);
        auto kept = first;
        for (auto next = first + 1; next != stack_.end(); ++next) {
            if (next->key != kept->key) ++kept;
            *kept = *next;
        }
        stack_.erase(kept + 1, stack_.end());
    }

    template <class T> T* allocate(size_t count)
    {
        return static_cast<T*>(document_.memory_.allocate(count * sizeof(T), alignof(T)));
    }

    template <class T> std::span<const T> keep(std::span<const T> values)
    {
        if (values.empty()) return {};
        T* copy = allocate<T>(values.size());
        std::memcpy(copy, values.data(), values.size_bytes());
        return {copy, values.size()};
    }

    JsonDocument& document_;
    const Reserve& reserve_;
    std::vector<JsonMember> stack_;
    std::vector<Container> open_;
    std::array<const std::string*, 64> met_{};
};

namespace {

/// Waits for what nlohmann's parser says of a text; the names and signatures are its own.
struct Complaint : nlohmann::json_sax<nlohmann::json> {
    std::string text;

    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(int64_t) override { return true; }
    bool number_unsigned(uint64_t) override { return true; }
    bool number_float(double, const std::string&) override { return true; }
    bool string(std::string&) override { return true; }
    bool binary(binary_t&) override { return true; }
    bool start_object(size_t) override { return true; }
    bool key(std::string&) override { return true; }
    bool end_object() override { return true; }
    bool start_array(size_t) override { return true; }
    bool end_array() override { return true; }
    bool parse_error(size_t, const std::string&, const nlohmann::json::exception& error) override
    {
        text = error.what();
        return false;
    }
};

}  // namespace

std::string JsonDocument::parse(std::string_view text, const Reserve& reserve)
{
    clear();
    Builder builder(*this, reserve);
    if (JsonReader(text, builder).read()) return {};
    clear();
    Complaint complaint;
    complaint.text = "is no JSON";
    nlohmann::json::sax_parse(text.begin(), text.end(), &complaint);
    return std::move(complaint.text);
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

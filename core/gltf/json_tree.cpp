// See json_tree.h.
#include "core/gltf/json_tree.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/check.h"

namespace core::gltf {

static_assert(sizeof(Json) == 16 && sizeof(JsonMember) == 24);
static_assert(std::is_trivially_copyable_v<Json> && std::is_trivially_copyable_v<JsonMember>);

Json::Json(std::string_view text) : size_(static_cast<uint32_t>(text.size())), kind_(Kind::string)
{
    content_.text = text.data();
}

Json::Json(std::span<const Json> elements)
    : size_(static_cast<uint32_t>(elements.size())), kind_(Kind::array)
{
    content_.elements = elements.data();
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

const Json& Json::operator[](size_t i) const
{
    CHECK(isArray() && i < size_);
    return content_.elements[i];
}

std::span<const Json> Json::elements() const
{
    return isArray() ? std::span(content_.elements, size_) : std::span<const Json>();
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

/// What nlohmann's parser calls. Members and elements of the open containers lie on one stack;
/// those of a container that ends move into the document's memory, side by side.
class JsonDocument::Builder {
public:
    explicit Builder(JsonDocument& document) : document_(document) {}

    std::string problem;

    // The names and signatures are nlohmann's.
    bool null() { return take(Json()); }
    bool boolean(bool value) { return take(Json(value)); }
    bool number_integer(int64_t value) { return take(Json(value)); }
    bool number_unsigned(uint64_t value) { return take(Json(value)); }
    bool number_float(double value, const std::string&) { return take(Json(value)); }
    bool string(std::string& value)
    {
        const std::span<const char> kept = keep(std::span<const char>(value));
        return take(Json(std::string_view(kept.data(), kept.size())));
    }
    bool binary(std::vector<uint8_t>&) { return false; }  // not in text
    bool start_object(size_t) { return open(true); }
    bool key(std::string& value)
    {
        stack_.push_back({&*document_.keys_.insert(value).first, {}});
        return true;
    }
    bool end_object()
    {
        const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(open_.back().first);
        sortMembers(first);
        return close(Json(keep(std::span<const JsonMember>(first, stack_.end()))));
    }
    bool start_array(size_t) { return open(false); }
    bool end_array()
    {
        const std::span<const JsonMember> top = std::span(stack_).subspan(open_.back().first);
        Json* elements = allocate<Json>(top.size());
        std::transform(top.begin(), top.end(), elements,
                       [](const JsonMember& member) { return member.value; });
        return close(Json(std::span<const Json>(elements, top.size())));
    }
    bool parse_error(size_t, const std::string&, const nlohmann::json::exception& error)
    {
        problem = error.what();
        return false;
    }

private:
    struct Container {
        size_t first;  // of its members or elements on the stack
        bool object;
    };

    bool open(bool object)
    {
        open_.push_back({stack_.size(), object});
        return true;
    }

    bool close(const Json& value)
    {
        stack_.resize(open_.back().first);
        open_.pop_back();
        return take(value);
    }

    bool take(const Json& value)
    {
        if (open_.empty())
            document_.root_ = value;
        else if (open_.back().object)
            stack_.back().value = value;  // its key came before
        else
            stack_.push_back({nullptr, value});
        return true;
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
    std::vector<JsonMember> stack_;
    std::vector<Container> open_;
};

std::string JsonDocument::parse(std::string_view text)
{
    clear();
    Builder builder(*this);
    if (!nlohmann::json::sax_parse(text.begin(), text.end(), &builder)) clear();
    return std::move(builder.problem);
}

void JsonDocument::clear()
{
    root_ = {};
    keys_.clear();
    memory_.release();
}

uint64_t jsonTreeBytes(uint64_t commas, uint64_t colons, uint64_t containers)
{
    constexpr uint64_t kKeyBytes = 80;  // a node of JsonDocument's set, without long names
    return commas * sizeof(Json) + colons * (sizeof(JsonMember) + kKeyBytes) +
           containers * sizeof(Json);
}

}  // namespace core::gltf

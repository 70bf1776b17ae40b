// JsonDocument::parse. RapidJSON reads, faster than nlohmann's parser; what
// it refuses, or may read wrongly, nlohmann's parser reads again and has the last word on.
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <new>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>
#include <rapidjson/memorystream.h>
#include <rapidjson/reader.h>

#include "core/gltf/json_tree.h"

namespace core::gltf {

/// Makes the tree of what a parser tells, value by value. Members and elements of the open
/// containers lie on one stack; those of a container that ends move into the document's memory,
/// side by side. Each call returns true, the parsers' word for going on.
class JsonDocument::Builder {
public:
    class FastHandler;
    class SlowHandler;

    Builder(JsonDocument& document, const Reserve& reserve) : document_(document), reserve_(reserve)
    {}

    bool null() { return take(Json()); }
    bool boolean(bool value) { return take(Json(value)); }
    bool whole(uint64_t value) { return take(Json(value)); }
    bool negative(int64_t value) { return take(Json(value)); }
    bool real(double value) { return take(Json(value)); }
    bool string(std::string_view value)
    {
        const std::span<const char> kept = keep(std::span<const char>(value));
        return take(Json(std::string_view(kept.data(), kept.size())));
    }
    bool key(std::string_view text)
    {
        stack_.push_back({keyOf(text), {}});
        return true;
    }
    bool startObject() { return open(true); }
    bool endObject()
    {
        const auto first = stack_.begin() + static_cast<std::ptrdiff_t>(open_.back().first);
        sortMembers(first);
        return close(Json(keep(std::span<const JsonMember>(first, stack_.end()))));
    }
    bool startArray() { return open(false); }
    bool endArray()
    {
        const std::span<const JsonMember> top = std::span(stack_).subspan(open_.back().first);
        const bool isNumbers = std::ranges::all_of(
            top, [](const JsonMember& member) { return isPlainNumber(member.value); });
        return close(
            isNumbers ? arrayOf<double>(top, [](const Json& element) { return element.number(); })
                      : arrayOf<Json>(top, [](const Json& element) { return element; }));
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

/// Passes on what RapidJSON tells. False ends its parse.
class JsonDocument::Builder::FastHandler
    : public rapidjson::BaseReaderHandler<rapidjson::UTF8<>, FastHandler> {
public:
    explicit FastHandler(Builder& builder) : builder_(builder) {}

    bool Null() { return builder_.null(); }
    bool Bool(bool value) { return builder_.boolean(value); }
    bool StartObject() { return builder_.startObject(); }
    bool EndObject(rapidjson::SizeType) { return builder_.endObject(); }
    bool StartArray() { return builder_.startArray(); }
    bool EndArray(rapidjson::SizeType) { return builder_.endArray(); }

    bool String(const char* text, rapidjson::SizeType size, bool)
    {
        return isSound({text, size}) && builder_.string({text, size});
    }

    bool Key(const char* text, rapidjson::SizeType size, bool)
    {
        return isSound({text, size}) && builder_.key({text, size});
    }

    /// The number as it is written: RapidJSON 1.1.0 reads beyond its table of powers for numbers
    /// such as 0.1e-2147483639, or a 1 after 400 zeros.
    bool RawNumber(const char* text, rapidjson::SizeType size, bool)
    {
        const std::string_view number(text, size);
        if (number.find_first_of(".eE") == std::string_view::npos) {
            if (number.front() == '-') {
                if (int64_t value = 0; isRead(number, value)) return builder_.negative(value);
            } else if (uint64_t value = 0; isRead(number, value)) {
                return builder_.whole(value);
            }
        }
        double value = 0;
        return isRead(number, value) && builder_.real(value);
    }

private:
    template <class Number> static bool isRead(std::string_view text, Number& value)
    {
        return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
    }

    /// Whether there is no half of a pair of UTF-16, which RapidJSON takes from \udc00.
    static bool isSound(std::string_view text)
    {
        for (size_t at = text.find('\xed'); at < text.size(); at = text.find('\xed', at + 1))
            if (at + 1 < text.size() && static_cast<unsigned char>(text[at + 1]) >= 0xa0)
                return false;
        return true;
    }

    Builder& builder_;
};

/// Passes on what nlohmann's parser tells, and keeps what it says of a text that is no JSON; the
/// names and signatures are its own.
class JsonDocument::Builder::SlowHandler : public nlohmann::json_sax<nlohmann::json> {
public:
    explicit SlowHandler(Builder& builder) : builder_(builder) {}

    const std::string& problem() const { return problem_; }

    bool null() override { return builder_.null(); }
    bool boolean(bool value) override { return builder_.boolean(value); }
    bool number_integer(int64_t value) override { return builder_.negative(value); }
    bool number_unsigned(uint64_t value) override { return builder_.whole(value); }
    bool number_float(double value, const std::string&) override { return builder_.real(value); }
    bool string(std::string& value) override { return builder_.string(value); }
    bool binary(binary_t&) override { return false; }  // JSON has none
    bool start_object(size_t) override { return builder_.startObject(); }
    bool key(std::string& text) override { return builder_.key(text); }
    bool end_object() override { return builder_.endObject(); }
    bool start_array(size_t) override { return builder_.startArray(); }
    bool end_array() override { return builder_.endArray(); }
    bool parse_error(size_t, const std::string&, const nlohmann::json::exception& error) override
    {
        problem_ = error.what();
        return false;
    }

private:
    Builder& builder_;
    std::string problem_;
};

namespace {

/// Memory for the string that RapidJSON reads, told of before it is taken: its own allocators do
/// not look whether there is any.
class StringMemory {
public:
    StringMemory() = default;  // RapidJSON's code for no allocator needs it, and is not reached
    explicit StringMemory(const JsonDocument::Reserve& reserve) : reserve_(&reserve) {}

    void* Realloc(void* old, size_t oldBytes, size_t bytes)
    {
        if (reserve_ != nullptr && *reserve_ && bytes > oldBytes) (*reserve_)(bytes - oldBytes);
        void* grown = std::realloc(old, bytes);
        if (grown == nullptr) throw std::bad_alloc();
        return grown;
    }
    static void Free(void* memory) { std::free(memory); }

private:
    const JsonDocument::Reserve* reserve_ = nullptr;
};

/// False: the text is no JSON, or for another parser to judge. Nesting takes no recursion.
template <class Handler>
bool isParsed(std::string_view text, Handler handler, const JsonDocument::Reserve& reserve)
{
    using rapidjson::UTF8;
    constexpr unsigned kFlags = rapidjson::kParseIterativeFlag |
                                rapidjson::kParseValidateEncodingFlag |
                                rapidjson::kParseNumbersAsStringsFlag;
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    rapidjson::MemoryStream stream(text.data(), text.size());
    StringMemory memory(reserve);
    rapidjson::GenericReader<UTF8<>, UTF8<>, StringMemory> reader(&memory);
    return !reader.Parse<kFlags>(stream, handler).IsError();
}

}  // namespace

std::string JsonDocument::parse(std::string_view text, const Reserve& reserve)
{
    clear();
    if (text.find('\0') != std::string_view::npos) return "has a NUL byte";  // to parsers the end
    Builder fast(*this, reserve);
    if (isParsed(text, Builder::FastHandler(fast), reserve)) return {};
    clear();
    Builder slow(*this, reserve);
    Builder::SlowHandler judge(slow);
    if (nlohmann::json::sax_parse(text.begin(), text.end(), &judge)) return {};
    clear();
    return judge.problem();
}

}  // namespace core::gltf

// JsonDocument::parse. RapidJSON reads, faster than nlohmann's parser; what
// it refuses, or may read wrongly, nlohmann's parser reads again and has the last word on.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <numeric>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>
#include <rapidjson/memorystream.h>
#include <rapidjson/reader.h>

#include "core/gltf/json_storage.h"

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
    bool string(std::string_view text)
    {
        Json::Content content;
        content.text = textOf(text);
        return take({Json::Kind::string, content});
    }
    bool key(std::string_view text)
    {
        stack_.push_back({keyOf(text), {}});
        return true;
    }
    bool startObject() { return open(true); }
    bool endObject() { return close(objectOf(top())); }
    bool startArray() { return open(false); }
    bool endArray() { return close(arrayOf(top())); }

private:
    struct Container {
        size_t first;  // of its members or elements on the stack
        bool object;
    };

    /// How objects are stored whose members stand in the text in this order and are of these kinds.
    struct Layout {
        std::vector<std::pair<const std::string*, Json::Kind>> members;  // in the text's order
        std::vector<uint32_t> order;  // of those that count, by key
        const JsonShape* shape = nullptr;
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

    /// What the container that ends holds.
    std::span<const JsonMember> top() const
    {
        return std::span(stack_).subspan(open_.back().first);
    }

    /// A place among `places` for a text: the same for the same text.
    static size_t placeOf(std::string_view text, size_t places)
    {
        const size_t ends =
            text.empty() ? 0 : static_cast<unsigned char>(text.front() + text.back());
        return (ends + text.size()) % places;
    }

    /// The key as the document holds it. Most of a text's keys were met before: few are looked for
    /// in the set.
    const std::string* keyOf(std::string_view text)
    {
        const std::string*& met = metKeys_.at(placeOf(text, metKeys_.size()));
        if (met != nullptr && *met == text) return met;
        auto found = document_.keys_.find(text);
        if (found == document_.keys_.end()) {
            constexpr uint64_t kNodeBytes = 80;  // of the set
            if (reserve_) reserve_(kNodeBytes + text.size());
            found = document_.keys_.emplace(text).first;
        }
        return met = &*found;
    }

    /// The string as the document holds it: once where it was met not long before.
    const Json::Text* textOf(std::string_view text)
    {
        const Json::Text*& met = metTexts_.at(placeOf(text, metTexts_.size()));
        if (met != nullptr && met->view() == text) return met;
        auto* kept = new (allocate(sizeof(Json::Text) + text.size(), alignof(Json::Text)))
            Json::Text{static_cast<uint32_t>(text.size())};
        std::ranges::copy(text, reinterpret_cast<char*>(kept + 1));
        return met = kept;
    }

    Json arrayOf(std::span<const JsonMember> elements)
    {
        using Of = Json::Array::Of;
        if (elements.empty()) return Json::emptyArray();
        const Json::Kind kind = elements.front().value.kind();
        bool alike = true, plain = true, floats = true;
        for (const JsonMember& element : elements) {
            alike = alike && element.value.kind() == kind;
            plain = plain && isPlainNumber(element.value);
            floats = floats && plain && isFloat(element.value.number());
            if (!alike && !plain) break;
        }
        if (floats)
            return array<float>(elements, Of::floats, [](const Json& element) {
                return static_cast<float>(element.number());
            });
        if (plain) return array<double>(elements, Of::doubles, &Json::number);
        if (alike) return array<Json::Content>(elements, Of::kind, &Json::content);
        return array<Json>(elements, Of::values, std::identity());
    }

    static bool isFloat(double number)
    {
        return std::abs(number) <= double(std::numeric_limits<float>::max()) &&
               static_cast<double>(static_cast<float>(number)) == number;
    }

    template <class T, class Convert>
    Json array(std::span<const JsonMember> elements, Json::Array::Of of, const Convert& convert)
    {
        const size_t bytes = sizeof(Json::Array) + elements.size() * sizeof(T);
        auto* made = new (allocate(bytes, std::max(alignof(Json::Array), alignof(T))))
            Json::Array{static_cast<uint32_t>(elements.size()), of, elements.front().value.kind()};
        T* values = reinterpret_cast<T*>(made + 1);
        for (const JsonMember& element : elements)
            new (values++) T(std::invoke(convert, element.value));
        Json::Content content;
        content.array = made;
        return {Json::Kind::array, content};
    }

    Json objectOf(std::span<const JsonMember> members)
    {
        if (members.empty()) return Json::emptyObject();
        const Layout& layout = layoutOf(members);
        const size_t bytes = sizeof(Json::Members) + layout.order.size() * sizeof(Json::Content);
        auto* made = new (allocate(bytes, alignof(Json::Members))) Json::Members{layout.shape};
        auto* contents = reinterpret_cast<Json::Content*>(made + 1);
        for (const uint32_t member : layout.order)
            new (contents++) Json::Content(members[member].value.content());
        Json::Content content;
        content.members = made;
        return {Json::Kind::object, content};
    }

    /// Most objects are laid out as one that was met not long before.
    const Layout& layoutOf(std::span<const JsonMember> members)
    {
        size_t place = members.size();
        for (const JsonMember& member : members)
            place = place * 31 + reinterpret_cast<uintptr_t>(member.key) / sizeof(std::string) +
                    static_cast<size_t>(member.value.kind());
        Layout& met = metLayouts_.at(place % metLayouts_.size());
        const auto same = [](const auto& known, const JsonMember& member) {
            return known.first == member.key && known.second == member.value.kind();
        };
        if (!std::ranges::equal(met.members, members, same)) met = newLayout(members);
        return met;
    }

    /// Sorted by key; of equal keys the last one counts.
    Layout newLayout(std::span<const JsonMember> members)
    {
        Layout layout;
        for (const JsonMember& member : members)
            layout.members.emplace_back(member.key, member.value.kind());
        std::vector<uint32_t>& order = layout.order;
        order.resize(members.size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::stable_sort(
            order, [&](uint32_t a, uint32_t b) { return *members[a].key < *members[b].key; });
        size_t kept = 0;
        for (size_t next = 1; next < order.size(); ++next) {
            if (members[order[next]].key != members[order[kept]].key) ++kept;
            order[kept] = order[next];
        }
        order.resize(kept + 1);
        layout.shape = shapeOf(layout);
        return layout;
    }

    const JsonShape* shapeOf(const Layout& layout)
    {
        const size_t size = layout.order.size();
        const size_t bytes =
            sizeof(JsonShape) + size * (sizeof(const std::string*) + sizeof(Json::Kind));
        auto* shape = new (allocate(bytes, alignof(JsonShape))) JsonShape{size};
        auto* keys = reinterpret_cast<const std::string**>(shape + 1);
        auto* kinds = reinterpret_cast<Json::Kind*>(keys + size);
        for (const uint32_t member : layout.order) {
            new (keys++) const std::string*(layout.members[member].first);
            new (kinds++) Json::Kind(layout.members[member].second);
        }
        return shape;
    }

    void* allocate(size_t bytes, size_t alignment)
    {
        return document_.memory_.allocate(bytes, alignment);
    }

    JsonDocument& document_;
    const Reserve& reserve_;
    std::vector<JsonMember> stack_;
    std::vector<Container> open_;
    std::array<const std::string*, 64> metKeys_{};
    std::array<const Json::Text*, 64> metTexts_{};
    std::array<Layout, 64> metLayouts_{};
};

/// Passes on what RapidJSON tells. False ends its parse.
class JsonDocument::Builder::FastHandler
    : public rapidjson::BaseReaderHandler<rapidjson::UTF8<>, FastHandler> {
public:
    /// Only a text with escapes, or with a byte that begins them, can hold halves of pairs.
    FastHandler(Builder& builder, std::string_view text)
        : builder_(builder), looksForHalves_(text.find('\\') != std::string_view::npos ||
                                             text.find('\xed') != std::string_view::npos)
    {}

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
    bool isSound(std::string_view text) const
    {
        if (!looksForHalves_) return true;
        for (size_t at = text.find('\xed'); at < text.size(); at = text.find('\xed', at + 1))
            if (at + 1 < text.size() && static_cast<unsigned char>(text[at + 1]) >= 0xa0)
                return false;
        return true;
    }

    Builder& builder_;
    bool looksForHalves_;
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
    if (isParsed(text, Builder::FastHandler(fast, text), reserve)) return {};
    clear();
    Builder slow(*this, reserve);
    Builder::SlowHandler judge(slow);
    if (nlohmann::json::sax_parse(text.begin(), text.end(), &judge)) return {};
    clear();
    return judge.problem();
}

}  // namespace core::gltf

// Reads JSON text (RFC 8259) without recursion and without memory for what it reads: a handler is
// told of each value in turn, as nlohmann's sax_parse tells its own, in a third of the time. What
// is no JSON is refused without a word; json_tree.cpp lets nlohmann's parser say why.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/text.h"

namespace core::gltf {

/// A Handler has null(), boolean(bool), whole(uint64_t), negative(int64_t), real(double),
/// string(std::string_view), key(std::string_view), startObject(), endObject(), startArray() and
/// endArray(). Texts that it is given are gone after the call.
template <class Handler> class JsonReader {
public:
    JsonReader(std::string_view text, Handler& handler)
        : at_(text.data()), end_(text.data() + text.size()), handler_(handler)
    {}

    /// False when the text is not one value of JSON; the handler has then been told of a part.
    bool read()
    {
        if (std::string_view(at_, left()).starts_with("\xef\xbb\xbf")) at_ += 3;
        do {
            skipSpace();
            if (!readValue()) return false;
        } while (!isInside_.empty() && goOn());
        skipSpace();
        return isInside_.empty() && at_ == end_;
    }

private:
    enum class Inside : char { array, object };

    size_t left() const { return static_cast<size_t>(end_ - at_); }
    bool isNext(char c) const { return at_ != end_ && *at_ == c; }

    bool skip(char c)
    {
        if (!isNext(c)) return false;
        ++at_;
        return true;
    }

    bool skip(std::string_view word)
    {
        if (!std::string_view(at_, left()).starts_with(word)) return false;
        at_ += word.size();
        return true;
    }

    void skipSpace()
    {
        while (at_ != end_ && (*at_ == ' ' || *at_ == '\n' || *at_ == '\r' || *at_ == '\t')) ++at_;
    }

    /// Where a value must begin: reads it, or of an array or object that is not empty all before
    /// its first value.
    bool readValue();

    /// After a value in an array or object: reads what there is before the next value. False where
    /// the text ends, or is wrong; isInside_ tells which.
    bool goOn()
    {
        for (;;) {
            skipSpace();
            const bool isObject = isInside_.back() == Inside::object;
            if (skip(',')) return !isObject || readKey();
            if (!skip(isObject ? '}' : ']')) return false;
            leave();
            if (isInside_.empty()) return false;
        }
    }

    void leave()
    {
        isInside_.back() == Inside::object ? handler_.endObject() : handler_.endArray();
        isInside_.pop_back();
    }

    bool readKey()
    {
        skipSpace();
        std::string_view text;
        if (!skip('"') || !readString(text)) return false;
        handler_.key(text);
        skipSpace();
        return skip(':');
    }

    /// After the first quotation mark. `text` stays until the next string.
    bool readString(std::string_view& text);
    bool readEscape();
    bool readHex(uint32_t& code);
    bool readNumber();
    bool readReal(const char* begin);
    void skipDigits()
    {
        while (at_ != end_ && *at_ >= '0' && *at_ <= '9') ++at_;
    }

    const char* at_;
    const char* end_;
    Handler& handler_;
    std::vector<Inside> isInside_;  // the arrays and objects that are open
    std::string unescaped_;
};

template <class Handler> bool JsonReader<Handler>::readValue()
{
    // One step into arrays and objects at a time, down to the first value.
    for (;; skipSpace()) {
        if (skip('[')) {
            isInside_.push_back(Inside::array);
            handler_.startArray();
            skipSpace();
            if (!isNext(']')) continue;
            return true;
        }
        if (skip('{')) {
            isInside_.push_back(Inside::object);
            handler_.startObject();
            skipSpace();
            if (isNext('}')) return true;
            if (!readKey()) return false;
            continue;
        }
        break;
    }
    if (skip('"')) {
        std::string_view text;
        if (!readString(text)) return false;
        handler_.string(text);
        return true;
    }
    if (skip("null")) {
        handler_.null();
        return true;
    }
    const bool isTrue = skip("true");
    if (isTrue || skip("false")) {
        handler_.boolean(isTrue);
        return true;
    }
    return readNumber();
}

template <class Handler> bool JsonReader<Handler>::readString(std::string_view& text)
{
    const char* plain = at_;  // begin of what need not be changed
    bool isEscaped = false;
    unescaped_.clear();
    while (at_ != end_) {
        const auto c = static_cast<unsigned char>(*at_);
        if (c == '"') {
            text = {plain, static_cast<size_t>(at_ - plain)};
            if (isEscaped) text = unescaped_.append(text);
            ++at_;
            return true;
        }
        if (c == '\\') {
            isEscaped = true;
            unescaped_.append(plain, at_);
            ++at_;
            if (!readEscape()) return false;
            plain = at_;
        } else if (c < 0x20) {
            return false;
        } else {
            const size_t bytes = c < 0x80 ? 1 : utf8Bytes({at_, left()});
            if (bytes == 0) return false;
            at_ += bytes;
        }
    }
    return false;
}

/// After a backslash.
template <class Handler> bool JsonReader<Handler>::readEscape()
{
    if (at_ == end_) return false;
    constexpr std::string_view kLetters = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
    const char letter = *at_++;
    if (const size_t i = kLetters.find(letter); i != std::string_view::npos) {
        unescaped_ += kMeant[i];
        return true;
    }
    uint32_t code = 0;
    if (letter != 'u' || !readHex(code)) return false;
    const bool isLow = code >= 0xdc00 && code < 0xe000;
    if (code >= 0xd800 && code < 0xdc00) {  // the first half of a pair
        uint32_t low = 0;
        if (!skip("\\u") || !readHex(low) || low < 0xdc00 || low >= 0xe000) return false;
        code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
    }
    if (isLow) return false;
    appendUtf8(unescaped_, code);
    return true;
}

template <class Handler> bool JsonReader<Handler>::readHex(uint32_t& code)
{
    if (left() < 4) return false;
    const std::from_chars_result result = std::from_chars(at_, at_ + 4, code, 16);
    const bool isWhole = result.ec == std::errc() && result.ptr == at_ + 4;
    at_ += 4;
    return isWhole;
}

template <class Handler> bool JsonReader<Handler>::readNumber()
{
    const char* const begin = at_;
    const bool isNegative = skip('-');
    const char* const digits = at_;
    skipDigits();
    if (at_ == digits || (*digits == '0' && at_ - digits > 1)) return false;
    if (isNext('.') || isNext('e') || isNext('E')) return readReal(begin);
    if (isNegative) {
        int64_t value = 0;
        if (std::from_chars(begin, at_, value).ec != std::errc()) return readReal(begin);
        handler_.negative(value);
    } else {
        uint64_t value = 0;
        if (std::from_chars(begin, at_, value).ec != std::errc()) return readReal(begin);
        handler_.whole(value);
    }
    return true;
}

/// After the digits before the point.
template <class Handler> bool JsonReader<Handler>::readReal(const char* begin)
{
    if (skip('.')) {
        const char* const digits = at_;
        skipDigits();
        if (at_ == digits) return false;
    }
    if (skip('e') || skip('E')) {
        if (!skip('+')) skip('-');
        const char* const digits = at_;
        skipDigits();
        if (at_ == digits) return false;
    }
    double value = 0;
    // What is too large is refused, what is too small is zero: from_chars tells of both alike.
    if (std::from_chars(begin, at_, value).ec != std::errc())
        value = std::strtod(std::string(begin, at_).c_str(), nullptr);
    if (!std::isfinite(value)) return false;
    handler_.real(value);
    return true;
}

}  // namespace core::gltf

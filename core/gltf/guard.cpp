// What the loader may read: files and data URIs. Containers, syntax and versions are in
// document.cpp.
#include "core/gltf/guard.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <optional>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/text.h"

namespace core::gltf {

namespace {

/// A file descriptor that is closed at the end of the scope.
class Descriptor {
public:
    explicit Descriptor(const std::filesystem::path& file)
        : fd_(::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY))
    {}
    ~Descriptor()
    {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }

private:
    int fd_;
};

/// %41 becomes A; nothing when a % is not followed by two hexadecimal digits or stands for NUL.
std::optional<std::string> percentDecode(std::string_view text)
{
    const auto digit = [](char c) {
        if (c >= '0' && c <= '9') return c - '0';
        if (c >= 'a' && c <= 'f') return c - 'a' + 10;
        if (c >= 'A' && c <= 'F') return c - 'A' + 10;
        return -1;
    };
    std::string result;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            result += text[i];
            continue;
        }
        if (i + 2 >= text.size()) return std::nullopt;
        const int high = digit(text[i + 1]), low = digit(text[i + 2]);
        if (high < 0 || low < 0 || high + low == 0) return std::nullopt;
        result += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return result;
}

/// RFC 4648; white space is skipped, padding may be left out, any other character is an error.
std::optional<Bytes> base64Decode(std::string_view text)
{
    constexpr std::string_view kSpace = " \t\r\n";
    std::string dense;
    if (text.find_first_of(kSpace) != std::string_view::npos) {
        std::ranges::copy_if(text, std::back_inserter(dense),
                             [&](char c) { return kSpace.find(c) == std::string_view::npos; });
        text = dense;
    }
    static const std::array<int8_t, 256> table = [] {
        constexpr std::string_view alphabet =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::array<int8_t, 256> values{};
        values.fill(-1);
        for (size_t i = 0; i < alphabet.size(); ++i)
            values[static_cast<unsigned char>(alphabet[i])] = static_cast<int8_t>(i);
        return values;
    }();
    for (int padding = 0; padding < 2 && !text.empty() && text.back() == '='; ++padding)
        text.remove_suffix(1);
    if (text.size() % 4 == 1) return std::nullopt;
    Bytes result;
    result.reserve(text.size() / 4 * 3 + 2);
    uint32_t bits = 0;
    int bitCount = 0;
    for (const char c : text) {
        const int value = table[static_cast<unsigned char>(c)];
        if (value < 0) return std::nullopt;
        bits = bits << 6 | static_cast<uint32_t>(value);
        bitCount += 6;
        if (bitCount >= 8) {
            bitCount -= 8;
            result.push_back(static_cast<std::byte>(bits >> bitCount & 0xff));
        }
    }
    return result;
}

std::string lower(std::string_view text)
{
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return result;
}

Content readDataUri(std::string_view uri)
{
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) return {{}, "data: URI without content"};
    const std::string_view head = uri.substr(0, comma), payload = uri.substr(comma + 1);
    std::optional<Bytes> bytes;
    if (lower(head).ends_with(";base64")) {
        bytes = base64Decode(payload);
        if (!bytes) return {{}, "data: URI with broken base64"};
    } else {
        const std::optional<std::string> text = percentDecode(payload);
        if (!text) return {{}, "data: URI with broken percent-encoding"};
        const auto* begin = reinterpret_cast<const std::byte*>(text->data());
        bytes.emplace(begin, begin + text->size());
    }
    if (bytes->empty()) return {{}, "data: URI without content"};
    return {std::move(*bytes), {}};
}

/// "http" of "http://x"; empty for a relative reference.
std::string_view schemeOf(std::string_view uri)
{
    const size_t end = uri.find_first_of(":/?#");
    if (end == std::string_view::npos || uri[end] != ':') return {};
    return uri.substr(0, end);
}

std::string quoted(std::string_view text)
{
    constexpr size_t kLongest = 120;
    return std::string("'").append(printable(text, kLongest)).append("'");
}

}  // namespace

Content readFile(const std::filesystem::path& file, uint64_t maxBytes)
{
    const Descriptor descriptor(file);
    if (descriptor.get() < 0) return {{}, std::string("cannot be opened: ") + std::strerror(errno)};
    struct stat status {};
    if (::fstat(descriptor.get(), &status) != 0)
        return {{}, std::string("cannot be examined: ") + std::strerror(errno)};
    if (S_ISDIR(status.st_mode)) return {{}, "is a folder, not a file"};
    if (!S_ISREG(status.st_mode)) return {{}, "is not a regular file"};
    const auto size = static_cast<uint64_t>(status.st_size);
    if (size > maxBytes)
        return {{},
                "has " + formatBytes(size) + ", allowed are " + formatBytes(maxBytes) +
                    " (--max-file-mb)"};
    Content content;
    content.bytes.resize(size);
    size_t done = 0;
    while (done < size) {
        const ssize_t got = ::read(descriptor.get(), content.bytes.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return {{}, std::string("cannot be read: ") + std::strerror(errno)};
        if (got == 0) return {{}, "became shorter while it was read"};
        done += static_cast<size_t>(got);
    }
    return content;
}

bool isDataUri(std::string_view uri)
{
    return lower(schemeOf(uri)) == "data";
}

std::vector<std::string> namesMeant(std::string_view uri)
{
    std::vector<std::string> names;
    if (std::optional<std::string> decoded = percentDecode(uri)) names.push_back(*decoded);
    if (names.empty() || names.front() != uri) names.emplace_back(uri);
    for (size_t i = 0, given = names.size(); i < given; ++i) {
        if (names[i].find('\\') == std::string::npos) continue;
        std::string turned = names[i];
        std::ranges::replace(turned, '\\', '/');
        names.push_back(std::move(turned));
    }
    std::erase_if(names, [](const std::string& name) {
        return name.empty() || name.find('\0') != std::string::npos;
    });
    return names;
}

Content readUri(const Load& load, std::string_view uri)
{
    const std::string_view scheme = schemeOf(uri);
    if (isDataUri(uri)) return readDataUri(uri);
    if (!scheme.empty())
        return {{}, quoted(uri) + ": remote files and schemes other than data: are not supported"};
    if (load.folder.empty())
        return {{}, quoted(uri) + ": other files are not read for a document in memory"};
    std::error_code error;
    std::filesystem::path real;
    for (const std::string& name : namesMeant(uri)) {
        real = std::filesystem::canonical(load.folder / name, error);
        if (!error) break;
    }
    if (real.empty() && !error) return {{}, quoted(uri) + ": not a file name"};
    if (error) return {{}, "missing file " + quoted(uri) + ": " + error.message()};
    const auto [inFolder, rest] =
        std::mismatch(load.folder.begin(), load.folder.end(), real.begin(), real.end());
    if (inFolder != load.folder.end() && !load.options.allowOutside)
        return {{}, quoted(uri) + " lies outside the scene's folder (--allow-outside permits it)"};

    Content content = readFile(real, load.options.maxFileMb << 20);
    if (!content.problem.empty()) content.problem = quoted(uri) + " " + content.problem;
    return content;
}

}  // namespace core::gltf

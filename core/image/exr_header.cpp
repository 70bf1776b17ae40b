// A reader of EXR attributes that trusts no length: each is checked against the bytes that are
// left.
#include "core/image/exr_header.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/check.h"

namespace core {

namespace {

constexpr size_t kLongestHeader = size_t(1) << 20;
constexpr int64_t kLargestSide = 65536;
constexpr uint32_t kMostChannels = 256;
constexpr uint64_t kLargestImageBytes = uint64_t(4) << 30;
constexpr uint32_t kMagic = 20000630;  // 0x76 0x2f 0x31 0x01 in the file
constexpr uint32_t kFlagDeep = 0x800, kFlagMultiPart = 0x1000;

/// Little-endian bytes that are taken from the front; taking more than there is sets `failed`.
struct Bytes {
    std::span<const char> rest;
    bool failed = false;

    std::span<const char> take(size_t count)
    {
        if (count > rest.size()) {
            failed = true;
            rest = {};
            return {};
        }
        const std::span<const char> taken = rest.first(count);
        rest = rest.subspan(count);
        return taken;
    }
    uint32_t word()
    {
        uint32_t value = 0;
        const std::span<const char> bytes = take(4);
        if (!failed) std::memcpy(&value, bytes.data(), 4);
        return value;
    }
    int32_t integer() { return static_cast<int32_t>(word()); }
    std::string text()
    {
        const auto end = std::find(rest.begin(), rest.end(), '\0');
        if (end == rest.end()) {
            failed = true;
            return {};
        }
        const size_t length = static_cast<size_t>(end - rest.begin());
        const std::span<const char> bytes = take(length + 1);
        return {bytes.data(), length};
    }
};

/// Entries of a `chlist`: name, pixel type, linearity, x and y sampling; ended by an empty name.
uint32_t countChannels(Bytes list)
{
    uint32_t count = 0;
    while (!list.failed && !list.text().empty()) {
        list.take(16);
        ++count;
    }
    return list.failed ? 0 : count;
}

/// The header's claims, or nothing when it is malformed.
std::optional<ExrHeader> parseAttributes(Bytes header)
{
    ExrHeader result;
    bool haveWindow = false;
    for (std::string name = header.text(); !header.failed && !name.empty(); name = header.text()) {
        header.text();  // type
        const uint32_t size = header.word();
        Bytes value{header.take(size)};
        if (header.failed) break;
        if (name == "channels") result.channels = countChannels(value);
        if (name != "dataWindow") continue;
        const int64_t left = value.integer(), top = value.integer();
        const int64_t right = value.integer(), bottom = value.integer();
        if (value.failed || right < left || bottom < top) return {};
        result.width = static_cast<uint32_t>(right - left + 1);
        result.height = static_cast<uint32_t>(bottom - top + 1);
        haveWindow = right - left < 0xffffffff && bottom - top < 0xffffffff;
    }
    if (header.failed || !haveWindow || result.channels == 0) return {};
    return result;
}

std::vector<char> readStart(const std::filesystem::path& file)
{
    std::error_code error;
    if (!std::filesystem::exists(file, error)) throw Error(file.string() + ": no such file");
    if (!std::filesystem::is_regular_file(file, error))
        throw Error(file.string() + ": not a regular file — name an EXR file");
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw Error(file.string() + ": cannot be opened for reading");
    std::vector<char> start(
        static_cast<size_t>(std::min<uintmax_t>(std::filesystem::file_size(file), kLongestHeader)));
    stream.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    return start;
}

}  // namespace

ExrHeader readExrHeader(const std::filesystem::path& file)
{
    const std::vector<char> start = readStart(file);
    const std::string name = file.string();
    Bytes header{start};
    if (header.word() != kMagic || header.failed)
        throw Error(name + ": not an EXR file (its first bytes are others)");
    const uint32_t version = header.word();
    if (!header.failed && (version & (kFlagDeep | kFlagMultiPart)) != 0)
        throw Error(name + ": deep or multi-part EXR — save it as one part with flat pixels");
    const std::optional<ExrHeader> claims = parseAttributes(header);
    if (header.failed || !claims) throw Error(name + ": EXR header is damaged or cut off");
    const uint64_t bytes = uint64_t(4) * claims->width * claims->height * claims->channels;
    if (claims->width > kLargestSide || claims->height > kLargestSide ||
        claims->channels > kMostChannels || bytes > kLargestImageBytes)
        throw Error(name + ": " + std::to_string(claims->width) + " x " +
                    std::to_string(claims->height) + " pixels of " +
                    std::to_string(claims->channels) +
                    " channels — at most 65536 a side, 256 channels and 4 GiB are read");
    return *claims;
}

}  // namespace core

// A reader of EXR attributes that trusts no length: each is checked against the bytes that are
// left.
#include "core/image/exr_header.h"

#include <algorithm>
#include <cstring>
#include <fstream>

#include "core/base/check.h"

namespace core {

namespace {

constexpr size_t kLongestHeader = size_t(1) << 20;
constexpr int64_t kLargestSide = 65536;
constexpr uint32_t kMostChannels = 256;
constexpr uint64_t kLargestImageBytes = uint64_t(4) << 30;
// A tile may be larger than its image, but the library allocates by its size.
constexpr uint32_t kLargestTileSide = 1024;
constexpr uint32_t kMagic = 20000630;  // 0x76 0x2f 0x31 0x01 in the file
constexpr uint32_t kFlagDeep = 0x800, kFlagMultiPart = 0x1000;

/// Little-endian bytes that are taken from the front; taking more than there is sets `failed`.
struct Bytes {
    EncodedImage rest;
    bool failed = false;

    EncodedImage take(size_t count)
    {
        if (count > rest.size()) {
            failed = true;
            rest = {};
            return {};
        }
        const EncodedImage taken = rest.first(count);
        rest = rest.subspan(count);
        return taken;
    }
    uint32_t word()
    {
        uint32_t value = 0;
        const EncodedImage bytes = take(4);
        if (!failed) std::memcpy(&value, bytes.data(), 4);
        return value;
    }
    int32_t integer() { return static_cast<int32_t>(word()); }
    std::string text()
    {
        const auto end = std::find(rest.begin(), rest.end(), std::byte{});
        if (end == rest.end()) {
            failed = true;
            return {};
        }
        const size_t length = static_cast<size_t>(end - rest.begin());
        const EncodedImage bytes = take(length + 1);
        return {reinterpret_cast<const char*>(bytes.data()), length};
    }
    std::string all() const { return {reinterpret_cast<const char*>(rest.data()), rest.size()}; }
};

/// Entries of a `chlist`: name, pixel type, linearity, x and y sampling; ended by an empty name.
void parseChannels(Bytes list, ExrHeader& header)
{
    header.channelNames.clear();
    for (std::string name = list.text(); !list.failed && !name.empty(); name = list.text()) {
        list.take(8);
        const uint32_t x = list.word(), y = list.word();
        header.subsampled = header.subsampled || x != 1 || y != 1;
        header.channelNames.push_back(std::move(name));
    }
    if (list.failed) header.channelNames.clear();
    header.channels = static_cast<uint32_t>(header.channelNames.size());
}

/// False: the window has no area, or is cut off.
bool parseWindow(Bytes value, ExrHeader& header)
{
    const int64_t left = value.integer(), top = value.integer();
    const int64_t right = value.integer(), bottom = value.integer();
    if (value.failed || right < left || bottom < top) return false;
    header.width = static_cast<uint32_t>(right - left + 1);
    header.height = static_cast<uint32_t>(bottom - top + 1);
    return right - left < 0xffffffff && bottom - top < 0xffffffff;
}

/// The header's claims, or nothing when it is malformed.
std::optional<ExrHeader> parseAttributes(Bytes& header)
{
    ExrHeader result;
    bool haveWindow = false;
    for (std::string name = header.text(); !header.failed && !name.empty(); name = header.text()) {
        const std::string type = header.text();
        const uint32_t size = header.word();
        Bytes value{header.take(size)};
        if (header.failed) break;
        if (name == "channels") parseChannels(value, result);
        if (type == "string") result.strings[name] = value.all();
        if (name == "type") result.deep = result.deep || value.all().starts_with("deep");
        if (name == "chunkCount") result.chunks = value.word();
        if (name == "tiles") {
            result.tileWidth = value.word();
            result.tileHeight = value.word();
            if (value.failed || result.tileWidth == 0 || result.tileHeight == 0) return {};
        }
        if (name == "dataWindow" && !(haveWindow = parseWindow(value, result))) return {};
    }
    if (header.failed || !haveWindow || result.channels == 0) return {};
    return result;
}

std::vector<std::byte> readStart(const std::filesystem::path& file)
{
    std::error_code error;
    if (!std::filesystem::exists(file, error)) throw Error(file.string() + ": no such file");
    if (!std::filesystem::is_regular_file(file, error))
        throw Error(file.string() + ": not a regular file — name an EXR file");
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw Error(file.string() + ": cannot be opened for reading");
    std::vector<std::byte> start(
        static_cast<size_t>(std::min<uintmax_t>(std::filesystem::file_size(file), kLongestHeader)));
    stream.read(reinterpret_cast<char*>(start.data()), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    return start;
}

}  // namespace

std::string ExrHeader::problem(uint64_t fileBytes) const
{
    if (deep) return "is a deep or volume image";
    if (subsampled) return "has channels of fewer values than pixels (chroma), which are not read";
    if (tileWidth > std::max(width, kLargestTileSide) ||
        tileHeight > std::max(height, kLargestTileSide))
        return "is damaged: tiles of " + std::to_string(tileWidth) + " x " +
               std::to_string(tileHeight) + " pixels";
    if (chunks > fileBytes / 8)  // each has an offset of 8 bytes in a table
        return "is damaged: " + std::to_string(chunks) + " blocks of pixels in a file of " +
               std::to_string(fileBytes) + " bytes";
    return {};
}

bool isExr(EncodedImage bytes)
{
    return Bytes{bytes}.word() == kMagic;
}

std::optional<ExrHeader> parseExrHeader(EncodedImage bytes)
{
    Bytes rest{bytes.first(std::min(bytes.size(), kLongestHeader))};
    if (rest.word() != kMagic) return {};
    const uint32_t version = rest.word();
    std::optional<ExrHeader> header = parseAttributes(rest);
    if (!header) return {};
    header->deep = header->deep || (version & kFlagDeep) != 0;
    header->severalParts = (version & kFlagMultiPart) != 0;
    // Further headers up to an empty one.
    while (header->severalParts && !rest.failed && !rest.rest.empty() &&
           rest.rest.front() != std::byte{}) {
        const std::optional<ExrHeader> next = parseAttributes(rest);
        if (!next) return {};
        header->chunks += next->chunks;
    }
    return header;
}

ExrHeader readExrHeader(const std::filesystem::path& file)
{
    const std::vector<std::byte> start = readStart(file);
    const std::string name = file.string();
    if (!isExr(start)) throw Error(name + ": not an EXR file (its first bytes are others)");
    const std::optional<ExrHeader> claims = parseExrHeader(start);
    if (!claims) throw Error(name + ": EXR header is damaged or cut off");
    if (claims->deep || claims->severalParts)
        throw Error(name + ": deep or multi-part EXR — save it as one part with flat pixels");
    const uint64_t bytes = uint64_t(4) * claims->width * claims->height * claims->channels;
    if (claims->width > kLargestSide || claims->height > kLargestSide ||
        claims->channels > kMostChannels || bytes > kLargestImageBytes)
        throw Error(name + ": " + std::to_string(claims->width) + " x " +
                    std::to_string(claims->height) + " pixels of " +
                    std::to_string(claims->channels) +
                    " channels — at most 65536 a side, 256 channels and 4 GiB are read");
    if (const std::string problem = claims->problem(std::filesystem::file_size(file));
        !problem.empty())
        throw Error(name + ": " + problem);
    return *claims;
}

}  // namespace core

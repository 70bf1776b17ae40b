// See picture_bytes.h.
#include "tests/support/files/picture_bytes.h"

namespace tests {

Bytes operator+(Bytes a, const Bytes& b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

Bytes bytesOf(const std::string& text)
{
    Bytes bytes(text.size());
    for (size_t i = 0; i < text.size(); ++i) bytes[i] = static_cast<std::byte>(text[i]);
    return bytes;
}

static Bytes numbers(const std::vector<int>& values)
{
    Bytes bytes;
    for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
    return bytes;
}

Bytes bigEndian(uint32_t value)
{
    Bytes bytes;
    for (int shift = 24; shift >= 0; shift -= 8)
        bytes.push_back(static_cast<std::byte>(value >> shift & 0xffu));
    return bytes;
}

static uint32_t crc32(const Bytes& bytes)
{
    uint32_t crc = 0xffffffffu;
    for (const std::byte b : bytes) {
        crc ^= static_cast<uint32_t>(b);
        for (int k = 0; k < 8; ++k) crc = (crc & 1u) != 0 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
    }
    return ~crc;
}

Bytes pngChunk(const std::string& type, const Bytes& content)
{
    const Bytes named = bytesOf(type) + content;
    return bigEndian(static_cast<uint32_t>(content.size())) + named + bigEndian(crc32(named));
}

static Bytes inserted(const Bytes& into, size_t at, const Bytes& what)
{
    Bytes result = into;
    result.insert(result.begin() + static_cast<ptrdiff_t>(at), what.begin(), what.end());
    return result;
}

Bytes behindHeader(const Bytes& png, const Bytes& chunks)
{
    return inserted(png, 8 + 12 + 13, chunks);
}

Bytes jpegSegment(uint8_t marker, const Bytes& content)
{
    const size_t length = content.size() + 2;
    return numbers({0xff, marker, static_cast<int>(length >> 8), static_cast<int>(length & 0xff)}) +
           content;
}

Bytes behindStart(const Bytes& jpeg, const Bytes& segments)
{
    return inserted(jpeg, 2, segments);
}

Bytes jpegProfile(const Bytes& profile)
{
    return jpegSegment(0xe2, bytesOf(std::string("ICC_PROFILE\0\1\1", 14)) + profile);
}

Bytes progressiveJpeg(uint16_t width, uint16_t height, size_t more)
{
    const Bytes start = numbers({0xff, 0xd8}), end = numbers({0xff, 0xd9});
    const Bytes quantization = jpegSegment(0xdb, numbers({0}) + Bytes(64, std::byte{1}));
    const Bytes frame = jpegSegment(
        0xc2, numbers({8, height >> 8, height & 0xff, width >> 8, width & 0xff, 1, 1, 0x11, 0}));
    // One code of one bit: the difference 0, or the end of the block.
    const Bytes codes = numbers({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
    const Bytes tables =
        jpegSegment(0xc4, numbers({0x00}) + codes) + jpegSegment(0xc4, numbers({0x10}) + codes);
    const Bytes first = jpegSegment(0xda, numbers({1, 1, 0x00, 0, 0, 0}));
    const size_t blocks = (size_t{width} + 7) / 8 * ((size_t{height} + 7) / 8);
    const Bytes scan = jpegSegment(0xda, numbers({1, 1, 0x00, 1, 63, 0}));
    Bytes jpeg = start + quantization + frame + tables + first + Bytes(blocks / 8 + 1);
    for (size_t i = 0; i < more; ++i) jpeg.insert(jpeg.end(), scan.begin(), scan.end());
    return jpeg + end;
}

}  // namespace tests

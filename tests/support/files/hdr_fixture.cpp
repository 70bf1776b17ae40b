// See hdr_fixture.h.
#include "tests/support/files/hdr_fixture.h"

#include <algorithm>
#include <cmath>

#include "tests/support/files/picture_bytes.h"

namespace tests {

namespace {

void append(Bytes& bytes, std::initializer_list<size_t> values)
{
    for (const size_t value : values) bytes.push_back(static_cast<std::byte>(value));
}

/// One channel of a line: runs of four and more equal values, and what lies between them.
void packChannel(Bytes& bytes, const uint8_t* first, uint32_t width, size_t channel)
{
    const auto value = [&](uint32_t x) { return first[4 * size_t{x} + channel]; };
    const auto runAt = [&](uint32_t x) {
        uint32_t length = 1;
        while (x + length < width && length < 127 && value(x + length) == value(x)) ++length;
        return length;
    };
    for (uint32_t x = 0; x < width;) {
        if (const uint32_t run = runAt(x); run >= 4) {
            append(bytes, {128 + run, value(x)});
            x += run;
            continue;
        }
        uint32_t end = x + 1;
        while (end < width && end - x < 128 && runAt(end) < 4) ++end;
        append(bytes, {end - x});
        for (; x < end; ++x) append(bytes, {value(x)});
    }
}

/// One line, each pixel followed by how often it comes again.
void packOld(Bytes& bytes, const uint8_t* first, uint32_t width)
{
    for (uint32_t x = 0; x < width;) {
        const uint8_t* pixel = first + 4 * size_t{x};
        uint32_t more = 0;
        while (x + more + 1 < width && std::equal(pixel, pixel + 4, pixel + 4 * size_t{more + 1}))
            ++more;
        append(bytes, {pixel[0], pixel[1], pixel[2], pixel[3]});
        for (uint32_t rest = more; rest > 0; rest /= 256) append(bytes, {1, 1, 1, rest % 256});
        x += more + 1;
    }
}

}  // namespace

Bytes makeHdr(const std::string& sizes, uint32_t width, const std::vector<uint8_t>& rgbe,
              HdrPacking packing)
{
    Bytes bytes = bytesOf("#?RADIANCE\nSOFTWARE=test\nFORMAT=32-bit_rle_rgbe\n\n" + sizes + "\n");
    for (size_t line = 0; line < rgbe.size() / (4 * width); ++line) {
        const uint8_t* first = rgbe.data() + line * 4 * width;
        if (packing == HdrPacking::none)
            for (size_t i = 0; i < 4 * width; ++i) append(bytes, {first[i]});
        else if (packing == HdrPacking::old)
            packOld(bytes, first, width);
        else {
            append(bytes, {2, 2, width / 256, width % 256});
            for (size_t channel = 0; channel < 4; ++channel)
                packChannel(bytes, first, width, channel);
        }
    }
    return bytes;
}

Bytes makeHdr(uint32_t width, uint32_t height, const std::vector<float>& rgb)
{
    std::vector<uint8_t> rgbe;
    for (size_t i = 0; i < rgb.size(); i += 3) {
        int exponent = 0;
        const float largest = std::max({rgb[i], rgb[i + 1], rgb[i + 2]});
        std::frexp(largest, &exponent);
        for (size_t c = 0; c < 3; ++c)
            rgbe.push_back(largest > 0 ? static_cast<uint8_t>(std::ldexp(rgb[i + c], 8 - exponent))
                                       : uint8_t{0});
        rgbe.push_back(largest > 0 ? static_cast<uint8_t>(exponent + 128) : uint8_t{0});
    }
    return makeHdr("-Y " + std::to_string(height) + " +X " + std::to_string(width), width, rgbe,
                   width < 8 ? HdrPacking::none : HdrPacking::lines);
}

}  // namespace tests

// Images of scenes, decoded behind guards.
#include "core/gltf/texture_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/gtc/packing.hpp>

#include "core/image/exr_file.h"
#include "core/image/exr_header.h"
#include "core/image/hdr_file.h"
#include "core/image/jpeg_file.h"
#include "core/image/png_file.h"
#include "shared/tonemap.h"

namespace core {

namespace {

float fromSrgb(float value)
{
    return shared::srgbDecode(value);
}

/// What a stored value means, per channel, as T (half bits or float).
template <class T, class Convert> std::vector<T> table(size_t size, bool color, Convert convert)
{
    std::vector<T> values(size);
    for (size_t i = 0; i < size; ++i) {
        const float unit = static_cast<float>(i) / static_cast<float>(size - 1);
        values[i] = convert(color ? fromSrgb(unit) : unit);
    }
    return values;
}

uint16_t toHalf(float value)
{
    return glm::packHalf1x16(value);
}

/// Calls put(pixel, r, g, b, a) with stored values; missing alpha is `opaque`.
template <class S, class Put> void forPixels(const RawImage& image, S opaque, Put put)
{
    const size_t count = size_t{image.width} * image.height;
    const uint32_t channels = image.channels;
    const std::byte* data = image.pixels.data();
    for (size_t i = 0; i < count; ++i, data += channels * sizeof(S)) {
        std::array<S, 4> v{opaque, opaque, opaque, opaque};
        std::memcpy(v.data(), data, channels * sizeof(S));
        if (channels <= 2) {
            const S alpha = channels == 2 ? v[1] : opaque;
            v = {v[0], v[0], v[0], alpha};
        }
        put(i, v[0], v[1], v[2], v[3]);
    }
}

float sanitise(float value, float largest, uint64_t& repaired)
{
    if (value >= 0 && value <= largest) return value;
    ++repaired;
    return value > largest ? largest : 0.0f;
}

template <class S> void fillFromTable(const RawImage& image, bool color, std::vector<Texel>& texels)
{
    constexpr size_t kSize = size_t{std::numeric_limits<S>::max()} + 1;
    const std::vector<uint16_t> rgb = table<uint16_t>(kSize, color, toHalf);
    const std::vector<uint16_t> alpha = table<uint16_t>(kSize, false, toHalf);
    forPixels<S>(image, std::numeric_limits<S>::max(), [&](size_t i, S r, S g, S b, S a) {
        texels[i] = {rgb[r], rgb[g], rgb[b], alpha[a]};
    });
}

template <class S> void fillFromTable(const RawImage& image, std::vector<glm::vec4>& texels)
{
    constexpr size_t kSize = size_t{std::numeric_limits<S>::max()} + 1;
    const std::vector<float> rgb = table<float>(kSize, true, [](float v) { return v; });
    forPixels<S>(image, S{}, [&](size_t i, S r, S g, S b, S) {
        texels[i] = {rgb[r], rgb[g], rgb[b], 1};
    });
}

}  // namespace

DecodedImage decodeImage(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop)
{
    if (isPng(bytes)) return decodePng(bytes, guards, std::move(stop));
    if (isJpeg(bytes)) return decodeJpeg(bytes, guards, std::move(stop));
    if (isExr(bytes)) return decodeExr(bytes, guards, std::move(stop));
    if (isHdr(bytes)) return decodeHdr(bytes, guards, std::move(stop));
    return {{}, "is no PNG, JPEG, OpenEXR or Radiance image by its content", {}};
}

Texture makeTexture(const RawImage& image, bool color, uint64_t& repaired)
{
    constexpr float kLargestHalf = 65504;
    Texture texture;
    texture.width = image.width;
    texture.height = image.height;
    texture.texels.resize(size_t{image.width} * image.height);
    switch (image.type) {
    case RawImage::Type::unsigned8:
        fillFromTable<uint8_t>(image, color, texture.texels);
        break;
    case RawImage::Type::unsigned16:
        fillFromTable<uint16_t>(image, color, texture.texels);
        break;
    case RawImage::Type::float32:
        forPixels<float>(image, 1.0f, [&](size_t i, float r, float g, float b, float a) {
            const auto half = [&](float v) { return toHalf(sanitise(v, kLargestHalf, repaired)); };
            texture.texels[i] = {half(r), half(g), half(b), half(a)};
        });
    }
    return texture;
}

std::vector<glm::vec4> makeRadiance(const RawImage& image, uint64_t& repaired)
{
    constexpr float kLargest = 1e30f;
    std::vector<glm::vec4> texels(size_t{image.width} * image.height);
    switch (image.type) {
    case RawImage::Type::unsigned8:
        fillFromTable<uint8_t>(image, texels);
        break;
    case RawImage::Type::unsigned16:
        fillFromTable<uint16_t>(image, texels);
        break;
    case RawImage::Type::float32:
        forPixels<float>(image, 1.0f, [&](size_t i, float r, float g, float b, float) {
            texels[i] = {sanitise(r, kLargest, repaired), sanitise(g, kLargest, repaired),
                         sanitise(b, kLargest, repaired), 1};
        });
    }
    return texels;
}

Texture checkerTexture()
{
    constexpr uint32_t kSide = 8;
    Texture texture;
    texture.name = "missing";
    texture.width = texture.height = kSide;
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const bool odd = (x + y) % 2 != 0;
            const uint16_t magenta = toHalf(0.8f), dark = toHalf(0.05f), one = toHalf(1);
            texture.texels.push_back(odd ? Texel{magenta, dark, magenta, one}
                                         : Texel{dark, dark, dark, one});
        }
    return texture;
}

}  // namespace core

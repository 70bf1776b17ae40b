// Images of scenes, decoded behind guards.
#include "core/gltf/texture_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <glm/gtc/packing.hpp>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "core/image/jpeg_file.h"
#include "core/image/png_file.h"
#include "shared/tonemap.h"

namespace core {

namespace {

/// Name of OpenImageIO's reader for these first bytes; empty for what it is not asked for.
std::string readerFor(EncodedImage bytes)
{
    const auto startsWith = [&](std::string_view magic) {
        return bytes.size() >= magic.size() &&
               std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
    };
    if (startsWith("\x76\x2f\x31\x01")) return "openexr";
    if (startsWith("#?RADIANCE") || startsWith("#?RGBE")) return "hdr";
    return {};
}

/// Size in the header of an OpenEXR file, 0 x 0 when there is none: the library allocates a table
/// of as many lines before it can be asked.
glm::dvec2 exrSize(std::span<const std::byte> bytes)
{
    static constexpr std::string_view kName("dataWindow\0box2i\0", 17);
    const auto* begin = reinterpret_cast<const char*>(bytes.data());
    const std::string_view head(begin, std::min<size_t>(bytes.size(), 1u << 20));
    const size_t found = head.find(kName);
    if (found == std::string_view::npos || found + kName.size() + 20 > head.size()) return {0, 0};
    std::array<int32_t, 4> box{};  // after the attribute's size: left, top, right, bottom
    std::memcpy(box.data(), begin + found + kName.size() + 4, sizeof(box));
    return {double(box[2]) - box[0] + 1, double(box[3]) - box[1] + 1};
}

/// First line of a message of the library.
std::string firstLine(const std::string& text)
{
    return text.substr(0, std::min<size_t>(text.find('\n'), 200));
}

DecodedImage refused(std::string problem)
{
    return {{}, std::move(problem), {}};
}

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
    const std::string name = readerFor(bytes);
    if (name.empty()) return refused("is no PNG, JPEG, OpenEXR or Radiance image by its content");
    if (name == "openexr") {
        const glm::dvec2 size = exrSize(bytes);
        if (std::string problem = sizeProblem(size.x, size.y, guards); !problem.empty())
            return refused(problem);
    }
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(name);
    if (!input) return refused("cannot be read: this OpenImageIO has no reader for " + name);
    OIIO::Filesystem::IOMemReader memory(const_cast<std::byte*>(bytes.data()), bytes.size());
    OIIO::Filesystem::IOProxy* proxy = &memory;
    OIIO::ImageSpec config, spec;
    config.attribute("oiio:UnassociatedAlpha", 1);
    config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
    if (!input->open("image." + name, spec, config))
        return refused("cannot be read: " + firstLine(input->geterror()));

    if (std::string problem = sizeProblem(spec.width, spec.height, guards); !problem.empty())
        return refused(problem);
    if (spec.deep || spec.depth > 1) return refused("is a deep or volume image");
    if (spec.nchannels < 1 || spec.nchannels > 4)
        return refused("has " + std::to_string(spec.nchannels) + " channels, allowed are 1 to 4");
    RawImage image{static_cast<uint32_t>(spec.width),
                   static_cast<uint32_t>(spec.height),
                   static_cast<uint32_t>(spec.nchannels),
                   RawImage::Type::float32,
                   {}};
    if (std::string problem = allocatePixels(image, bytes.size(), 0, guards); !problem.empty())
        return refused(problem);
    const auto stopped = [](void* token, float) {
        return static_cast<std::stop_token*>(token)->stop_requested();
    };
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.pixels.data(),
                           OIIO::AutoStride, OIIO::AutoStride, OIIO::AutoStride, stopped, &stop)) {
        if (stop.stop_requested()) return refused("was not read: loading was stopped");
        return refused("is damaged: " + firstLine(input->geterror()));
    }
    return {std::move(image), {}, {}};
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

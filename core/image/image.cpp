// Image files through OpenImageIO, which is used here and in texture loading only. The library does
// not limit what an EXR may make it allocate (2.4.7), so the header is checked first; and it writes
// in place, so it encodes in memory.
#include "core/image/image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/image/exr_header.h"
#include "core/image/image_metadata.h"
#include "core/image/png_file.h"
#include "shared/tonemap.h"

namespace core {

namespace {

// Keys carry a prefix in the file, so that none collides with an attribute that EXR or PNG gives a
// meaning to.
const std::string kMetadataPrefix = "rekindle:";

constexpr uint64_t kMaxPngBytes = uint64_t{1} << 30;

/// The ending of the name with its dot, in lower case.
std::string lowerExtension(const std::filesystem::path& file)
{
    std::string extension = file.extension().string();
    for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
    return extension;
}

/// First line of the library's error message.
std::string firstLine(std::string text)
{
    text.erase(std::min(text.find('\n'), text.size()));
    return text.empty() ? "unknown reason" : text;
}

/// Channel names of a layer of `count` channels: colours by letter, single values as luminance.
std::string channelName(const std::string& layer, uint32_t channel, uint32_t count)
{
    static constexpr std::array<const char*, 4> kColours{"R", "G", "B", "A"};
    const std::string suffix = count == 1 ? "Y" : kColours[channel];
    return layer.empty() ? suffix : layer + "." + suffix;
}

OIIO::ImageSpec exrSpec(const ImageFile& image)
{
    const Image& first = image.layers.front().image;
    OIIO::ImageSpec spec(int(first.width), int(first.height), 0, OIIO::TypeDesc::FLOAT);
    for (const Layer& layer : image.layers) {
        CHECK(layer.image.width == first.width && layer.image.height == first.height);
        CHECK(layer.image.channels >= 1 && layer.image.channels <= 4);
        for (uint32_t c = 0; c < layer.image.channels; ++c)
            spec.channelnames.push_back(channelName(layer.name, c, layer.image.channels));
    }
    spec.nchannels = int(spec.channelnames.size());
    spec.attribute("compression", "zip");
    spec.attribute("DateTime",
                   "");  // the library would write the time of day: same image, same bytes
    for (const auto& [key, value] : image.metadata) spec.attribute(kMetadataPrefix + key, value);
    return spec;
}

/// All layers' channels side by side per pixel.
std::vector<float> interleave(const std::vector<Layer>& layers, size_t channelCount)
{
    const Image& first = layers.front().image;
    const size_t pixelCount = size_t(first.width) * first.height;
    std::vector<float> all(pixelCount * channelCount);
    size_t offset = 0;
    for (const Layer& layer : layers) {
        const size_t count = layer.image.channels;
        for (size_t i = 0; i < pixelCount; ++i)
            std::copy_n(&layer.image.pixels[i * count], count, &all[i * channelCount + offset]);
        offset += count;
    }
    return all;
}

/// Where the channels of one layer lie among those of the file.
struct LayerChannels {
    std::string name;
    std::vector<size_t> channels;  // indices in the file
};

/// The library gives the channels of a layer as R, G, B, A or X, Y, Z, whatever their order in the
/// file.
std::vector<LayerChannels> groupChannels(const std::vector<std::string>& names)
{
    std::vector<LayerChannels> layers;
    for (size_t i = 0; i < names.size(); ++i) {
        const size_t dot = names[i].rfind('.');
        const std::string layer = dot == std::string::npos ? "" : names[i].substr(0, dot);
        auto found = std::find_if(layers.begin(), layers.end(),
                                  [&](const LayerChannels& l) { return l.name == layer; });
        if (found == layers.end()) found = layers.insert(layers.end(), {layer, {}});
        found->channels.push_back(i);
    }
    return layers;
}

Metadata metadataOf(const OIIO::ImageSpec& spec)
{
    Metadata metadata;
    for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
        const std::string name = attribute.name().string();
        if (name.rfind(kMetadataPrefix, 0) == 0)
            metadata[name.substr(kMetadataPrefix.size())] = attribute.get_string();
    }
    return metadata;
}

Metadata pngMetadata(const std::filesystem::path& file)
{
    std::error_code error;
    if (std::filesystem::file_size(file, error) > kMaxPngBytes)
        throw Error(file.string() + ": larger than " + std::to_string(kMaxPngBytes >> 20) + " MiB");
    std::ifstream stream(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
    if (!stream) throw Error(file.string() + ": cannot be read");
    const EncodedImage encoded = std::as_bytes(std::span(bytes));
    if (!isPng(encoded)) throw Error(file.string() + ": not a PNG file");
    Metadata metadata;
    for (const auto& [key, value] : pngText(encoded))
        if (key.starts_with(kMetadataPrefix)) metadata[key.substr(kMetadataPrefix.size())] = value;
    return metadata;
}

/// Encodes in memory and writes the bytes: the library's PNG writer does not notice a full disk
/// (2.4.7).
void encode(const std::filesystem::path& file, const char* format, const OIIO::ImageSpec& spec,
            OIIO::TypeDesc type, const void* pixels)
{
    const std::unique_ptr<OIIO::ImageOutput> writer = OIIO::ImageOutput::create(format);
    OIIO::Filesystem::IOVecOutput memory;
    if (!writer || !writer->set_ioproxy(&memory))
        throw Error(file.string() + ": this OpenImageIO cannot write " + format, ExitCode::failure);
    if (!writer->open(file.string(), spec) || !writer->write_image(type, pixels) ||
        !writer->close())
        throw Error(file.string() + ": cannot be encoded: " + firstLine(writer->geterror()));
    writeFile(file, std::as_bytes(std::span(memory.buffer())));
}

/// Display value of one pixel; what is not finite shows as black.
uint8_t quantize(float linear)
{
    const float encoded = shared::srgbEncode(linear);
    if (!(encoded > 0)) return 0;
    return static_cast<uint8_t>(std::lround(std::min(encoded, 1.0f) * 255.0f));
}

}  // namespace

bool ImageFile::hasLayer(const std::string& name) const
{
    return std::any_of(layers.begin(), layers.end(),
                       [&](const Layer& layer) { return layer.name == name; });
}

const Image& ImageFile::layer(const std::string& name) const
{
    std::string known;
    for (const Layer& layer : layers) {
        if (layer.name == name) return layer.image;
        known += (known.empty() ? "\"" : ", \"") + layer.name + "\"";
    }
    throw Error("no layer \"" + name + "\" in the image — it has " +
                (known.empty() ? "none" : known));
}

void writeExr(const std::filesystem::path& file, const ImageFile& image)
{
    CHECK(!image.layers.empty());
    const OIIO::ImageSpec spec = exrSpec(image);
    const std::vector<float> pixels = interleave(image.layers, size_t(spec.nchannels));
    encode(file, "openexr", spec, OIIO::TypeDesc::FLOAT, pixels.data());
}

ImageFile readExr(const std::filesystem::path& file)
{
    const ExrHeader header = readExrHeader(file);
    const std::unique_ptr<OIIO::ImageInput> reader = OIIO::ImageInput::create("openexr");
    if (!reader)
        throw Error(file.string() + ": this OpenImageIO cannot read EXR", ExitCode::failure);
    OIIO::ImageSpec spec;
    if (!reader->open(file.string(), spec))
        throw Error(file.string() + ": cannot be read (" + firstLine(reader->geterror()) + ")");
    if (spec.width != int(header.width) || spec.height != int(header.height) ||
        spec.nchannels != int(header.channels))
        throw Error(file.string() + ": EXR header contradicts itself");
    const size_t channelCount = header.channels;
    const size_t pixelCount = size_t(header.width) * header.height;
    std::vector<float> all(pixelCount * channelCount);
    if (!reader->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data()))
        throw Error(file.string() + ": damaged or cut off (" + firstLine(reader->geterror()) + ")");
    ImageFile result;
    result.metadata = metadataOf(spec);
    for (const LayerChannels& layer : groupChannels(spec.channelnames)) {
        const size_t count = layer.channels.size();
        Image image(header.width, header.height, uint32_t(count));
        for (size_t i = 0; i < pixelCount; ++i)
            for (size_t c = 0; c < count; ++c)
                image.pixels[i * count + c] = all[i * channelCount + layer.channels[c]];
        result.layers.push_back({layer.name, std::move(image)});
    }
    return result;
}

Metadata readMetadata(const std::filesystem::path& file)
{
    const std::string extension = lowerExtension(file);
    std::error_code error;
    if (!std::filesystem::exists(file, error)) throw Error(file.string() + ": no such file");
    if (!std::filesystem::is_regular_file(file, error))  // a pipe would block for ever
        throw Error(file.string() + ": not a regular file");
    if (extension == ".png") return pngMetadata(file);
    if (extension != ".exr") throw Error(file.string() + ": not an EXR or PNG file");
    (void)readExrHeader(file);
    const std::unique_ptr<OIIO::ImageInput> reader = OIIO::ImageInput::create("openexr");
    if (!reader)
        throw Error(file.string() + ": this OpenImageIO cannot read EXR", ExitCode::failure);
    OIIO::ImageSpec spec;
    if (!reader->open(file.string(), spec))
        throw Error(file.string() + ": cannot be read (" + firstLine(reader->geterror()) + ")");
    return metadataOf(spec);
}

void writePng(const std::filesystem::path& file, const Image& linear, float exposure,
              uint32_t toneCurve, const Metadata& metadata)
{
    CHECK(linear.channels >= 3);
    const size_t pixelCount = size_t(linear.width) * linear.height;
    const float scale = std::exp2(exposure);
    std::vector<uint8_t> bytes(3 * pixelCount);
    for (size_t i = 0; i < pixelCount; ++i) {
        const float* p = &linear.pixels[i * linear.channels];
        const glm::vec3 shown = shared::toneMap(scale * glm::vec3(p[0], p[1], p[2]), toneCurve);
        for (int c = 0; c < 3; ++c) bytes[3 * i + size_t(c)] = quantize(shown[c]);
    }
    writePngBytes(file, linear.width, linear.height, 3, bytes, metadata);
}

void writePngBytes(const std::filesystem::path& file, uint32_t width, uint32_t height,
                   uint32_t channels, std::span<const uint8_t> bytes, const Metadata& metadata)
{
    CHECK(channels >= 1 && channels <= 4 && bytes.size() == size_t(width) * height * channels);
    OIIO::ImageSpec spec(int(width), int(height), int(channels), OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    for (const auto& [key, value] : metadata) spec.attribute(kMetadataPrefix + key, value);
    encode(file, "png", spec, OIIO::TypeDesc::UINT8, bytes.data());
}

void requireWritable(const std::filesystem::path& file)
{
    const std::string name = file.string(), extension = lowerExtension(file);
    if (extension != ".exr" && extension != ".png")
        throw Error(name + ": unknown kind of image \"" + extension +
                        "\" — end the name in .exr or .png",
                    ExitCode::commandLine);
    requireWritableFile(file);
}

}  // namespace core

// Image files as the program writes and reads them: encoded in memory, so that a file appears whole
// or not at all; and read after their headers have been checked.
#include "core/image/image.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/image/exr_file.h"
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

/// The metadata as it stands in a file.
Metadata withPrefix(const Metadata& metadata)
{
    Metadata strings;
    for (const auto& [key, value] : metadata) strings.emplace(kMetadataPrefix + key, value);
    return strings;
}

/// The metadata among a file's strings.
Metadata withoutPrefix(const std::map<std::string, std::string>& strings)
{
    Metadata metadata;
    for (const auto& [key, value] : strings)
        if (key.starts_with(kMetadataPrefix)) metadata[key.substr(kMetadataPrefix.size())] = value;
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
    return withoutPrefix(pngText(encoded));
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
    writeFile(file, encodeExr(file.string(), image.layers, withPrefix(image.metadata)));
}

ImageFile readExr(const std::filesystem::path& file)
{
    const ExrHeader header = readExrHeader(file);
    ImageFile result;
    result.layers = readExrLayers(file, header);
    result.metadata = withoutPrefix(header.strings);
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
    return withoutPrefix(readExrHeader(file).strings);
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
    writeFile(file, encodePng(file.string(), width, height, channels, bytes, withPrefix(metadata)));
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

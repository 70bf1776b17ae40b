// Float images and their files: EXR with named layers and metadata, PNG through the display
// transform.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace core {

/// Interleaved float pixels, rows from the top.
struct Image {
    uint32_t width = 0, height = 0, channels = 3;
    std::vector<float> pixels;

    Image() = default;
    Image(uint32_t w, uint32_t h, uint32_t c)
        : width(w), height(h), channels(c), pixels(size_t(w) * h * c)
    {}
    float* at(uint32_t x, uint32_t y) { return &pixels[(size_t(y) * width + x) * channels]; }
    const float* at(uint32_t x, uint32_t y) const
    {
        return &pixels[(size_t(y) * width + x) * channels];
    }
};

/// Strings by name: everything needed to render an image again. An empty string is the same as
/// none.
using Metadata = std::map<std::string, std::string>;

/// One named group of channels of an EXR: "" is the picture itself (R,G,B), "variance" becomes
/// variance.R, .G, .B.
struct Layer {
    std::string name;
    Image image;
};

struct ImageFile {
    std::vector<Layer> layers;
    Metadata metadata;

    /// The layer of that name; throws core::Error naming the layers there are.
    const Image& layer(const std::string& name) const;
    bool hasLayer(const std::string& name) const;
};

/// Writes all layers as 32-bit float. The file appears under its name only when complete. Throws
/// core::Error.
void writeExr(const std::filesystem::path& file, const ImageFile& image);

/// Reads every channel of an EXR into layers. Throws core::Error (missing, not EXR, too large,
/// truncated).
ImageFile readExr(const std::filesystem::path& file);

/// Writes 8-bit sRGB PNG of linear RGB after `exposure` stops and the tone curve
/// (shared/tonemap.h). Throws core::Error.
void writePng(const std::filesystem::path& file, const Image& linear, float exposure,
              uint32_t toneCurve, const Metadata& metadata);

/// Writes 8-bit values as they are: 1 to 4 channels, sRGB colours, alpha not multiplied in. Throws
/// core::Error.
void writePngBytes(const std::filesystem::path& file, uint32_t width, uint32_t height,
                   uint32_t channels, std::span<const uint8_t> bytes, const Metadata& metadata);

/// Throws core::Error unless a file of that name could be created now (directory there, writable,
/// extension known).
void requireWritable(const std::filesystem::path& file);

}  // namespace core

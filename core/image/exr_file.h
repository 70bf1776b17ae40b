// EXR through OpenEXR's own library: pictures with their layers, and images of scenes. The header
// is checked before the library sees the file (exr_header.h).
#pragma once

#include <filesystem>
#include <stop_token>
#include <vector>

#include "core/image/exr_header.h"
#include "core/image/image.h"
#include "core/image/raw_image.h"

namespace core {

/// The bytes of a file with all layers as 32-bit floats; equal images give equal bytes. `strings`
/// become attributes. `name` is that of the file in messages. Throws core::Error.
std::vector<std::byte> encodeExr(const std::string& name, const std::vector<Layer>& layers,
                                 const Metadata& strings);

/// Every channel, in layers: "" first, the others by name; within a layer R, G, B, A or X, Y, Z
/// come first, whatever their order in the file. Half floats and integers become floats. `claims`
/// is what readExrHeader has accepted. Throws core::Error.
std::vector<Layer> readExrLayers(const std::filesystem::path& file, const ExrHeader& claims);

/// An image of 1 to 4 channels in the same order, as floats; of a file of several parts the first.
DecodedImage decodeExr(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop = {});

}  // namespace core

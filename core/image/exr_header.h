// What an EXR file claims about itself, read from its first bytes before a library allocates by
// those claims.
//   "OpenEXR File Layout", openexr.com: magic number, version, attributes (name, type, size,
//   value).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/image/raw_image.h"

namespace core {

/// Of a file of several parts: what the first part claims.
struct ExrHeader {
    uint32_t width = 0, height = 0, channels = 0;
    std::vector<std::string> channelNames;       // as many as channels, in the order of the file
    std::map<std::string, std::string> strings;  // the attributes of type `string`
    bool deep = false, severalParts = false;
    bool subsampled = false;                 // a channel has fewer values than the image has pixels
    uint32_t tileWidth = 0, tileHeight = 0;  // 0 x 0: in scan lines

    uint64_t chunks = 0;  // blocks of pixels that are claimed, of all parts; 0: as the size demands

    /// What stands against reading it from a file of so many bytes, beside the size of the image;
    /// empty when nothing does. The library allocates by what is asked for here.
    std::string problem(uint64_t fileBytes) const;
};

/// Whether these are the first bytes of an EXR file.
bool isExr(EncodedImage bytes);

/// Nothing: no EXR, or its header is damaged or cut off.
std::optional<ExrHeader> parseExrHeader(EncodedImage bytes);

/// Reads the header of a single-part EXR with flat pixels and checks it against what readExr
/// accepts: at most 65536 pixels a side, 256 channels, 4 GiB as floats. Throws core::Error
/// (missing, no EXR, malformed, deep, several parts, too large).
ExrHeader readExrHeader(const std::filesystem::path& file);

}  // namespace core

// What an EXR file claims about itself, read from its first bytes before a library allocates by
// those claims.
//   "OpenEXR File Layout", openexr.com: magic number, version, attributes (name, type, size,
//   value).
#pragma once

#include <cstdint>
#include <filesystem>

namespace core {

struct ExrHeader {
    uint32_t width = 0, height = 0, channels = 0;
};

/// Reads the header of a single-part EXR with flat pixels and checks it against what readExr
/// accepts: at most 65536 pixels a side, 256 channels, 4 GiB as floats. Throws core::Error
/// (missing, no EXR, malformed, deep, several parts, too large).
ExrHeader readExrHeader(const std::filesystem::path& file);

}  // namespace core

// What the loader may read from the file system, and whether bytes are a document at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/gltf/load.h"

namespace core::gltf {

/// Something read from outside, or the reason why not (`problem` is then not empty).
struct Content {
    Bytes bytes;
    std::string problem;
};

/// Reads a regular file of at most `maxBytes`. Never blocks on a FIFO or device.
Content readFile(const std::filesystem::path& file, uint64_t maxBytes);

/// Whether a URI holds its own content.
bool isDataUri(std::string_view uri);

/// The names that a URI of a file may stand for, likeliest first: decoded; as it is, from exporters
/// that do not encode a per cent sign; and both with the slashes of Windows turned.
std::vector<std::string> namesMeant(std::string_view uri);

/// What a URI of the document stands for: the bytes of a data: URI, or those of a file inside the
/// scene's folder (real paths are compared, so that neither "..", "%2e%2e", nor a symbolic link
/// leads out).
Content readUri(const Load& load, std::string_view uri);

/// Takes the bytes of a .gltf or .glb apart: returns the JSON text, sets load.binaryChunk. Refuses
/// damaged containers.
std::string_view openContainer(Load& load, std::span<const std::byte> bytes);

/// Parses the JSON text into load.document. Refuses with line and column what is no JSON object, is
/// nested deeper than 64 levels, or would need more memory than allowed.
void parseDocument(Load& load, std::string_view text);

/// asset.version, extensionsUsed and extensionsRequired against what this loader knows.
void checkVersionAndExtensions(Load& load);

}  // namespace core::gltf

// What the parts of the loader share: the state of one load, and how it refuses and warns.
// tinygltf is deliberately not used: version 2.7 accepts about forty of the bad inputs we must
// refuse, refuses whole files for faults we must repair (a broken image, a light without a type),
// reports errors without their place, and copies every buffer. The document is read straight from
// the JSON tree through Object (json.h) instead, which checks each value as it is taken and knows
// its JSON pointer.
#pragma once

#include <map>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/base/content_hash.h"
#include "core/gltf/gltf.h"
#include "core/gltf/json_tree.h"

namespace core::gltf {

using Bytes = std::vector<std::byte>;

/// An image of the document as one role needs it: decoded from sRGB, or plain data. Parallel to
/// scene.textures.
struct TextureRequest {
    size_t image = 0;
    bool color = false;
};

/// The state of one load; `scene` grows while its parts are read in order.
struct Load {
    std::filesystem::path file;    // empty for a document in memory
    std::filesystem::path folder;  // real path of the folder that URIs are relative to
    std::string label;             // how messages name the file
    LoadOptions options;
    LoadProgress progress;
    std::stop_token stop;

    Bytes content;  // the file; let go after parsing unless binaryChunk points into it
    JsonDocument document;
    std::vector<Bytes> storage;              // owns what `buffers` and `binaryChunk` point into
    std::span<const std::byte> binaryChunk;  // of a GLB
    std::vector<std::span<const std::byte>> buffers;  // cut to their byteLength
    std::map<size_t, Bytes> decodedViews;             // buffer views that are stored compressed
    std::vector<TextureRequest> textureRequests;
    Scene scene;
    ContentHash hash;
    ContentHash fileHash;      // without what is around the scene
    uint64_t memoryBytes = 0;  // estimated so far

    /// Throws LoadError: "<label>: <pointer>: <what> — <remedy>". Whatever the file put into these
    /// words, here it becomes one printable line.
    [[noreturn]] void refuse(const std::string& code, const std::string& pointer,
                             const std::string& what, const std::string& remedy = "file refused",
                             ExitCode exit = ExitCode::badInput) const;

    /// Counts a warning: `what` says what is wrong and what was done about it.
    void warn(const std::string& code, const std::string& pointer, const std::string& what);

    /// Throws when the caller wants to stop.
    void checkpoint() const;

    /// Reports progress, after a checkpoint.
    void stage(const char* name, double fraction) const;

    /// Adds to the estimate of memory, refusing the file when it passes the limit.
    void reserveMemory(uint64_t bytes, const std::string& pointer);
};

/// "512 bytes", "20 MiB": for messages.
std::string formatBytes(uint64_t bytes);

}  // namespace core::gltf

// glTF 2.0 (.gltf, .glb) to core::Scene. Structure errors refuse the whole file; faults of an
// asset's quality are repaired, counted in Scene::warnings and reported. Everything that is read is
// checked before it is used.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "core/base/check.h"
#include "core/scene/world.h"

namespace core {

// What may be around a scene: what its file says; that, and the plain sky where nothing in the
// scene shines; no environment and no sun; the plain sky, grey, lighter above than below, whose
// name is also that of the environment's file then.
inline constexpr const char* kOwnEnvironment = "own";
inline constexpr const char* kAnyEnvironment = "auto";
inline constexpr const char* kNoEnvironment = "none";
inline constexpr const char* kPlainSky = "plain";

/// Whether LoadOptions::environment names a file, rather than one of those.
bool isEnvironmentFile(const std::string& environment);

struct LoadOptions {
    uint64_t maxFileMb = 2048;    // of each file that is read
    uint64_t maxMemoryMb = 8192;  // of the scene in memory, estimated before anything is allocated
    uint32_t maxTextureSize = 16384;                // width and height in pixels
    Instancing instancing = Instancing::automatic;  // to be the World's
    std::string environment = kOwnEnvironment;  // or one of those above, or the file of a panorama
    bool allowOutside = false;                  // let URIs leave the folder of the scene
    bool strict = false;                        // a warning refuses the file
    bool ignoreRequired = false;                // load even if an unknown extension is required
};

/// A refusal. what() is "<file>: <JSON pointer>: <what is wrong> — <what to do>"; `code` follows
/// the names of the Khronos validator where it has one.
class LoadError : public Error {
public:
    LoadError(std::string code, std::string pointer, const std::string& message, ExitCode exit)
        : Error(message, exit), code_(std::move(code)), pointer_(std::move(pointer))
    {}
    const std::string& code() const { return code_; }
    const std::string& pointer() const { return pointer_; }

private:
    std::string code_, pointer_;
};

/// The stage and the fraction of it that is done, in [0,1] or kUnknownShare (core/base/progress.h).
/// Called by one thread at a time, while textures are read from any.
using LoadProgress = std::function<void(const char* stage, double fraction)>;

/// Reads a scene with all its files. Throws LoadError (a bad file, or ExitCode::deviceLost where
/// memory runs out) or Error with ExitCode::interrupted when `stop` is requested (noticed within
/// 100 ms; by a mesh that Draco decodes, at its next step). Lengths stay in the file's units;
/// world.h rescales.
std::shared_ptr<const Scene> loadGltf(const std::filesystem::path& file,
                                      const LoadOptions& options = {},
                                      const LoadProgress& progress = {}, std::stop_token stop = {});

/// The same for the bytes of a .gltf or .glb; `label` stands for the file's name. Other files are
/// not read: a buffer in one refuses the document, an image in one is repaired.
std::shared_ptr<const Scene> loadGltfFromMemory(std::span<const std::byte> bytes,
                                                const std::string& label,
                                                const LoadOptions& options = {},
                                                std::stop_token stop = {});

}  // namespace core

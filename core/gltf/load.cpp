// The order of a load, and what all its parts share.
#include "core/gltf/load.h"

#include <array>
#include <new>

#include "core/base/progress.h"
#include "core/base/text.h"
#include "core/gltf/compression.h"
#include "core/gltf/guard.h"
#include "core/gltf/parts.h"

namespace core::gltf {

std::string formatBytes(uint64_t bytes)
{
    constexpr std::array<const char*, 4> units{"bytes", "KiB", "MiB", "GiB"};
    size_t unit = 0;
    while (bytes >= 10'240 && unit + 1 < units.size()) {
        bytes /= 1024;
        ++unit;
    }
    return std::to_string(bytes) + " " + units[unit];
}

void Load::refuse(const std::string& code, const std::string& pointer, const std::string& what,
                  const std::string& remedy, ExitCode exit) const
{
    const std::string place = pointer.empty() ? "" : pointer + ": ";
    throw LoadError(code, printable(pointer),
                    printable(label + ": " + place + what + " — " + remedy), exit);
}

void Load::warn(const std::string& code, const std::string& pointer, const std::string& what)
{
    scene.warnings.add(code, printable(pointer), printable(what));
}

void Load::checkpoint() const
{
    if (stop.stop_requested()) throw Error(label + ": loading was stopped", ExitCode::interrupted);
}

void Load::stage(const char* name, double fraction) const
{
    checkpoint();
    if (progress) progress(name, fraction);
}

void Load::reserveMemory(uint64_t bytes, const std::string& pointer)
{
    const uint64_t limit = options.maxMemoryMb << 20;
    if (bytes > limit || memoryBytes > limit - bytes)
        refuse("TOO_LARGE", pointer,
               "the scene needs at least " + formatBytes(memoryBytes + bytes) +
                   " of memory, allowed are " + formatBytes(limit),
               "allow more with --max-memory-mb");
    memoryBytes += bytes;
}

namespace {

std::string hexadecimal(uint64_t value)
{
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text(16, '0');
    for (size_t i = 0; i < 16; ++i) text[15 - i] = digits[value >> (4 * i) & 15];
    return text;
}

void refuseWhenStrict(const Load& load)
{
    const Warnings& warnings = load.scene.warnings;
    if (!load.options.strict || warnings.total() == 0) return;
    const Warning& first = warnings.listed.front();
    load.refuse(first.code, first.pointer, first.message,
                "refused: " + std::to_string(warnings.total()) + " warnings and --strict");
}

/// Everything after the bytes of the document are there.
std::shared_ptr<const Scene> build(Load& load, std::span<const std::byte> bytes)
{
    load.scene.file = load.file;
    load.scene.fileBytes = bytes.size();
    load.hash.add(bytes);
    load.stage("parsing", kUnknownShare);
    parseDocument(load, openContainer(load, bytes));
    if (load.binaryChunk.empty()) load.content = Bytes();  // the tree has copies of what it needs
    checkVersionAndExtensions(load);
    readBuffers(load);
    decodeViews(load);
    load.stage("checking", kUnknownShare);
    const std::vector<Accessor> accessors = readAccessors(load);
    const NodePlan nodes = readNodes(load);
    readCameras(load, nodes);
    readLights(load, nodes);
    readAnimations(load, accessors, nodes);
    readPlacements(load, accessors, nodes);
    readSkins(load, accessors, nodes);
    const MaterialPlan materials = readMaterials(load, nodes);
    readMeshes(load, accessors, nodes, materials);
    readTextures(load);
    readEnvironment(load);
    if (load.scene.meshes.empty())
        load.warn("EMPTY_SCENE", "", "empty scene: there are no triangles to show");
    load.scene.hash = hexadecimal(load.hash.value());
    load.scene.fileHash = hexadecimal(load.fileHash.value());
    refuseWhenStrict(load);
    load.stage("loaded", 1);
    return std::make_shared<const Scene>(std::move(load.scene));
}

/// Running out of memory is a refusal too: the estimate is not exact.
std::shared_ptr<const Scene> buildOrRefuse(Load& load, std::span<const std::byte> bytes)
{
    try {
        return build(load, bytes);
    } catch (const std::bad_alloc&) {
        load.document.clear();
        load.scene = {};
        load.refuse("OUT_OF_MEMORY", "", "not enough memory to load the scene",
                    "close other programs or simplify it", ExitCode::deviceLost);
    }
}

}  // namespace

}  // namespace core::gltf

namespace core {

std::shared_ptr<const Scene> loadGltf(const std::filesystem::path& file, const LoadOptions& options,
                                      const LoadProgress& progress, std::stop_token stop)
{
    gltf::Load load;
    load.file = file;
    load.label = file.filename().empty() ? file.string() : file.filename().string();
    load.options = options;
    load.progress = progress;
    load.stop = std::move(stop);
    load.stage("reading", 0);
    gltf::Content content = gltf::readFile(file, options.maxFileMb << 20);
    if (!content.problem.empty()) {
        load.label = file.string();
        load.refuse("IO_ERROR", "", content.problem, "give a .gltf or .glb file");
    }
    std::error_code error;
    const std::filesystem::path real = std::filesystem::canonical(file, error);
    if (error)
        load.refuse("IO_ERROR", "", "cannot be resolved: " + error.message(),
                    "give a .gltf or .glb file");
    load.folder = real.parent_path();
    load.content = std::move(content.bytes);
    return gltf::buildOrRefuse(load, load.content);
}

std::shared_ptr<const Scene> loadGltfFromMemory(std::span<const std::byte> bytes,
                                                const std::string& label,
                                                const LoadOptions& options, std::stop_token stop)
{
    gltf::Load load;
    load.file = label;
    load.label = label;
    load.options = options;
    load.stop = std::move(stop);
    return gltf::buildOrRefuse(load, bytes);
}

}  // namespace core

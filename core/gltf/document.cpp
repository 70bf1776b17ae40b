// What the loader accepts as a document: container, syntax, version and extensions.
#include <algorithm>
#include <cstring>

#include "core/base/json_scan.h"
#include "core/base/text.h"
#include "core/gltf/guard.h"
#include "core/gltf/json.h"

namespace core::gltf {

namespace {

constexpr uint64_t kMaxTextBytes = 256u << 20;

constexpr std::array<std::string_view, 18> kKnownExtensions{
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    // These describe nothing that a picture shows.
    "KHR_materials_variants",
    "KHR_xmp",
    "KHR_xmp_json_ld",
};

/// How a person can get rid of an extension that is required.
std::string remedyFor(const std::string& extension)
{
    if (extension == "EXT_texture_webp" || extension == "EXT_texture_avif" ||
        extension == "KHR_texture_basisu")
        return "convert the images to PNG or JPEG first";
    return "export without it, or try --ignore-required";
}

uint32_t word(std::span<const std::byte> bytes, size_t offset)
{
    uint32_t value = 0;  // little endian, as glTF and every machine we build for
    std::memcpy(&value, bytes.data() + offset, 4);
    return value;
}

std::string_view textOf(std::span<const std::byte> bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// What the JSON parser said, shortened.
std::string tidy(std::string_view text)
{
    constexpr size_t kLongest = 200;
    if (const size_t bracket = text.find("] "); bracket != std::string::npos)
        text.remove_prefix(bracket + 2);
    return printable(text, kLongest);
}

std::vector<std::string> strings(const Load& load, const char* key)
{
    std::vector<std::string> result;
    for (size_t i = 0; i < countOf(load, key); ++i) {
        const Json name = (*load.document.root().find(key))[i];
        if (!name.isString())
            load.refuse("TYPE_MISMATCH", child(std::string("/") + key, i),
                        "is " + describe(name) + ", must be a string");
        result.emplace_back(name.text());
    }
    return result;
}

/// The number before the point of "2.0"; -1 when there is none.
int majorVersion(const std::string& version)
{
    if (version.size() < 3 || version[1] != '.') return -1;
    return version[0] >= '0' && version[0] <= '9' ? version[0] - '0' : -1;
}

}  // namespace

std::string_view openContainer(Load& load, std::span<const std::byte> bytes)
{
    if (bytes.empty()) load.refuse("EMPTY_FILE", "", "file is empty");
    if (bytes.size() < 4 || std::memcmp(bytes.data(), "glTF", 4) != 0) {
        std::string_view text = textOf(bytes);
        if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
        const size_t first = text.find_first_not_of(" \t\r\n");
        if (first == std::string_view::npos)
            load.refuse("INVALID_JSON", "", "file holds only white space");
        if (text[first] != '{')
            load.refuse("INVALID_JSON", "",
                        "not glTF 2.0: " + placeInText(text, first) +
                            ": a JSON object must begin with '{'",
                        "give a .gltf or .glb file");
        return text;
    }

    constexpr size_t kHeader = 12, kChunkHeader = 8;
    if (bytes.size() < kHeader + kChunkHeader)
        load.refuse("GLB_UNEXPECTED_END_OF_HEADER", "",
                    "GLB of only " + std::to_string(bytes.size()) + " bytes");
    if (word(bytes, 4) != 2)
        load.refuse("GLB_UNKNOWN_VERSION", "",
                    "GLB version " + std::to_string(word(bytes, 4)) + ", needs version 2");
    const uint64_t length = word(bytes, 8);
    if (length > bytes.size() || length < kHeader + kChunkHeader)
        load.refuse("GLB_LENGTH_MISMATCH", "",
                    "GLB header says " + std::to_string(length) + " bytes, the file has " +
                        std::to_string(bytes.size()));
    if (length < bytes.size())
        load.warn("GLB_LENGTH_MISMATCH", "",
                  std::to_string(bytes.size() - length) +
                      " bytes after the end of the GLB — ignored");

    std::string_view text;
    size_t index = 0;
    for (uint64_t offset = kHeader; offset < length; ++index) {
        if (offset + kChunkHeader > length)
            load.refuse("GLB_UNEXPECTED_END_OF_CHUNK_HEADER", "",
                        "GLB chunk " + std::to_string(index) + " is cut off at byte " +
                            std::to_string(offset));
        const uint64_t size = word(bytes, offset);
        const uint32_t type = word(bytes, offset + 4);
        offset += kChunkHeader;
        if (size > length - offset)
            load.refuse("GLB_CHUNK_TOO_BIG", "",
                        "GLB chunk " + std::to_string(index) + " has " + std::to_string(size) +
                            " bytes, " + std::to_string(length - offset) + " are left");
        constexpr uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
        if (index == 0 && type != kJson)
            load.refuse("GLB_UNEXPECTED_FIRST_CHUNK", "", "the first GLB chunk is not JSON");
        if (index == 0 && size == 0)
            load.refuse("GLB_EMPTY_CHUNK", "", "the JSON chunk of the GLB is empty");
        if (index == 0) {
            text = textOf(bytes.subspan(offset, size));
            // Padding should be spaces; old exporters pad with zeros.
            while (text.ends_with('\0')) text.remove_suffix(1);
        }
        if (index == 1 && type == kBinary) load.binaryChunk = bytes.subspan(offset, size);
        offset += size;
    }
    return text;
}

void parseDocument(Load& load, std::string_view text)
{
    if (text.size() > kMaxTextBytes)
        load.refuse("INVALID_JSON", "",
                    "JSON of " + formatBytes(text.size()) + ", allowed are " +
                        formatBytes(kMaxTextBytes));
    const JsonScan scan = scanJson(text);
    if (!scan.problem.empty()) load.refuse("INVALID_JSON", "", scan.problem);
    const auto reserve = [&](uint64_t bytes) { load.reserveMemory(bytes, ""); };
    reserve(text.size() + jsonTreeBytes(scan.commas, scan.colons, scan.containers));
    if (const std::string problem = load.document.parse(text, reserve); !problem.empty())
        load.refuse("INVALID_JSON", "", tidy(problem));
    const Json& root = load.document.root();
    if (!root.isObject())
        load.refuse("INVALID_JSON", "",
                    "the document is " + describe(root) + ", must be an object");
}

void checkVersionAndExtensions(Load& load)
{
    const Object root(load, load.document.root(), "");
    const std::optional<Object> asset = root.object("asset");
    if (!asset) load.refuse("UNDEFINED_PROPERTY", "", "'asset' is missing: not glTF 2.0");
    const std::string version = asset->requiredString("version");
    if (majorVersion(version) != 2)
        load.refuse("UNKNOWN_ASSET_MAJOR_VERSION", "/asset/version",
                    "is \"" + tidy(version) + "\", needs 2.x", "convert the file to glTF 2.0");
    if (asset->has("minVersion")) {
        const std::string minimum = asset->requiredString("minVersion");
        if (minimum != "2.0")
            load.refuse("UNKNOWN_ASSET_MAJOR_VERSION", "/asset/minVersion",
                        "is \"" + tidy(minimum) + "\", this loader reads 2.0",
                        "convert the file to glTF 2.0");
    }

    const auto known = [](const std::string& name) {
        return std::find(kKnownExtensions.begin(), kKnownExtensions.end(), name) !=
               kKnownExtensions.end();
    };
    const std::vector<std::string> required = strings(load, "extensionsRequired");
    for (size_t i = 0; i < required.size(); ++i) {
        if (known(required[i])) continue;
        const std::string pointer = child("/extensionsRequired", i);
        if (!load.options.ignoreRequired)
            load.refuse("UNSUPPORTED_EXTENSION", pointer,
                        "the file requires " + tidy(required[i]) + ", which is not supported",
                        remedyFor(required[i]));
        load.warn("UNSUPPORTED_EXTENSION", pointer,
                  "the file requires " + tidy(required[i]) +
                      ", which is not supported — ignored as asked");
    }
    const std::vector<std::string> used = strings(load, "extensionsUsed");
    for (size_t i = 0; i < used.size(); ++i) {
        if (known(used[i]) ||
            std::find(required.begin(), required.end(), used[i]) != required.end())
            continue;
        load.warn("UNSUPPORTED_EXTENSION", child("/extensionsUsed", i),
                  tidy(used[i]) + " is not supported — the file is shown without it");
    }
}

}  // namespace core::gltf

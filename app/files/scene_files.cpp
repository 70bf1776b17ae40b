// See scene_files.h. Any member "uri" counts, wherever it stands: extensions and extras have them,
// too, and one too many does no harm.
#include "app/files/scene_files.h"

#include <array>
#include <fstream>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/base/json_file.h"
#include "core/base/check.h"
#include "core/gltf/guard.h"

namespace app {

namespace fs = std::filesystem;

namespace {

/// The JSON of a document; a .glb holds it in its first chunk, and the rest is not read.
std::string documentText(const fs::path& scene)
{
    constexpr uint64_t kMaxBytes = uint64_t{2} << 30;  // as much as is loaded by default
    std::array<char, 20> head{};                       // "glTF", version, length; length, "JSON"
    std::ifstream stream(scene, std::ios::binary);
    stream.read(head.data(), head.size());
    if (!stream || !std::string_view(head.data(), head.size()).starts_with("glTF"))
        return readText(scene, kMaxBytes);
    uint64_t length = 0;
    for (size_t i = 0; i < 4; ++i)
        length |= uint64_t{static_cast<unsigned char>(head.at(12 + i))} << (8 * i);
    std::error_code none;
    if (length > fs::file_size(scene, none)) return {};
    std::string text(length, ' ');
    stream.read(text.data(), static_cast<std::streamsize>(length));
    while (text.ends_with('\0')) text.pop_back();  // padding, which the loader takes away, too
    return text;
}

void addFiles(const nlohmann::ordered_json& json, const fs::path& folder,
              std::vector<fs::path>& files)
{
    if (json.is_object() && json.contains("uri") && json["uri"].is_string()) {
        const std::string uri = json["uri"].get<std::string>();
        std::error_code none;
        if (!core::gltf::isDataUri(uri))
            for (const std::string& name : core::gltf::namesMeant(uri))
                if (fs::is_regular_file(folder / name, none)) files.push_back(folder / name);
    }
    for (const auto& member : json)
        if (member.is_structured()) addFiles(member, folder, files);
}

}  // namespace

std::vector<fs::path> filesNamedBy(const fs::path& scene)
{
    std::vector<fs::path> files;
    try {
        // As the loader does, from where the file really is: names in a document that is reached
        // by a link are not beside the link.
        const fs::path folder = fs::canonical(scene).parent_path();
        addFiles(parseJson(documentText(scene), scene.string()), folder, files);
    } catch (const core::Error&) {
        return {};
    } catch (const fs::filesystem_error&) {
        return {};
    }
    return files;
}

}  // namespace app

// See kept_reference.h.
#include "app/bench/kept_reference.h"

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/base/program_version.h"
#include "app/base/read_value.h"
#include "core/base/check.h"

namespace app {

namespace {

constexpr const char* kKey = "rekindle:reference";  // of the metadata
constexpr const char* kSeconds = "rekindle:seconds";

}  // namespace

ReferenceMaker thisProgram()
{
    return {kVersion, kCommit};
}

std::string referenceKey(const nlohmann::ordered_json& shown, const ReferenceMaker& maker)
{
    nlohmann::ordered_json key{{"version", maker.version}, {"commit", maker.commit}};
    key.update(shown);
    return jsonText(key);
}

std::optional<KeptReference> readReference(const std::filesystem::path& file,
                                           const std::string& key, glm::uvec2 size,
                                           const std::vector<std::string>& layers)
{
    std::error_code none;
    if (!std::filesystem::exists(file, none)) return {};
    try {
        KeptReference kept{core::readExr(file), 0};
        const core::Metadata& metadata = kept.image.metadata;
        const auto found = metadata.find(kKey);
        if (found == metadata.end() || found->second != key) return {};
        for (const std::string& name : layers) {
            const core::Image& layer = kept.image.layer(name);
            if (layer.width != size.x || layer.height != size.y || layer.channels != 3) return {};
        }
        const auto seconds = metadata.find(kSeconds);
        if (seconds != metadata.end()) readValue(seconds->second, {}, kept.seconds);
        return kept;
    } catch (const core::Error&) {
        return {};
    }
}

void keepReference(const std::filesystem::path& file, const std::string& key,
                   std::vector<core::Layer> layers, double seconds)
{
    std::error_code error;
    std::filesystem::create_directories(file.parent_path(), error);
    core::writeExr(file, {std::move(layers), {{kKey, key}, {kSeconds, numberText(seconds)}}});
}

}  // namespace app

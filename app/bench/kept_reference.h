// Pictures that measurements are compared with, kept in EXR files until something that they depend
// on changes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <nlohmann/json_fwd.hpp>

#include "core/image/image.h"

namespace app {

struct KeptReference {
    core::ImageFile image;
    double seconds = 0;  // that it took when it was made
};

/// The program that makes a picture. What it makes may change from one commit to the next; changes
/// that are in no commit have the name of the one before and a "+", all alike.
struct ReferenceMaker {
    std::string version, commit;
};

/// This program.
ReferenceMaker thisProgram();

/// A key from what a reference shows, an object, and from the program that renders it.
std::string referenceKey(const nlohmann::ordered_json& shown,
                         const ReferenceMaker& maker = thisProgram());

/// What is kept in `file`, if it was kept under the same `key` and has layers of these names, of
/// that size and with three channels. A file that cannot be read is no more than out of date.
std::optional<KeptReference> readReference(const std::filesystem::path& file,
                                           const std::string& key, glm::uvec2 size,
                                           const std::vector<std::string>& layers);

/// Writes it; `key` names everything that it depends on. Makes the folder. Throws core::Error.
void keepReference(const std::filesystem::path& file, const std::string& key,
                   std::vector<core::Layer> layers, double seconds);

}  // namespace app

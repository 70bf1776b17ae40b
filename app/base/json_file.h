// JSON text and files, with errors that name the place.
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

namespace app {

/// Throws core::Error "place: not JSON: at byte N" (or what else is wrong with it).
nlohmann::ordered_json parseJson(const std::string& text, const std::string& place);

/// The text of a value on one line, or with that many spaces of indentation. Names of files need
/// not be UTF-8; what is none is replaced.
std::string jsonText(const nlohmann::ordered_json& json, int indent = -1);

/// Reads a file of at most 64 MiB. Throws core::Error.
nlohmann::ordered_json readJson(const std::filesystem::path& file);

}  // namespace app

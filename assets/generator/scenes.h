// The scenes of assets/: each writes NAME.gltf and NAME.bin into a folder that has textures/ in it.
#pragma once

#include <filesystem>

namespace assets {

// enclosures.cpp
void writeCornellBoxes(const std::filesystem::path& folder);
void writeFurnaces(const std::filesystem::path& folder);

// interiors.cpp
void writeHall(const std::filesystem::path& folder);
void writeDoorAjar(const std::filesystem::path& folder);

// features.cpp
void writeTextured(const std::filesystem::path& folder);
void writeGlass(const std::filesystem::path& folder);

// lights.cpp
void writeLights(const std::filesystem::path& folder);
void writeSky(const std::filesystem::path& folder);
void writeAnimated(const std::filesystem::path& folder);

/// All of them and their textures. Throws core::Error.
void writeAll(const std::filesystem::path& folder);

}  // namespace assets

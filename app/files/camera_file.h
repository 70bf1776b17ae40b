// Cameras and camera paths as JSON, in the scene file's own units and axes.
//   A camera: {"position":[x,y,z], "target":[x,y,z] or "forward":[x,y,z], "up":[0,1,0],
//   "yfov":degrees, "aspect":width/height, "aperture_radius":r, "focus_distance":d}; with "ymag"
//   (half the height) it is orthographic. Where "up" is absent and a direction is given, the
//   horizon is level (up is +y). A path: {"keys":[{"frame":0, ...a camera...}, ...]} in order of
//   frames.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/scene/camera.h"
#include "core/scene/world.h"

namespace app {

/// [x, y, z]
nlohmann::ordered_json vectorJson(glm::dvec3 v);

/// `camera` (in world space) as JSON in the file's space. cameraFromJson is its inverse: to the bit
/// for cameras that came from a file, and for others as closely as the file's space can represent.
nlohmann::ordered_json cameraJson(const core::Camera& camera, const core::Placement& placement);

/// Reads a camera into world space; absent members are those of `defaults` (world space). Throws
/// core::Error led by `file` and the place in it.
core::Camera cameraFromJson(const nlohmann::ordered_json& json, const core::Camera& defaults,
                            const core::Placement& placement, const std::string& file);

/// Reads a camera file. Throws core::Error.
core::Camera readCamera(const std::filesystem::path& file, const core::Camera& defaults,
                        const core::Placement& placement);

/// Whether `text`, as chooseCamera takes it, names a file.
bool isCameraFile(const std::string& text);

/// The camera that `text` means: a JSON file, a camera's name, or its index; empty is the first.
/// Throws core::Error with the names there are.
core::Camera chooseCamera(const core::World& world, const std::string& text);

/// A camera that moves through keys.
struct CameraPath {
    struct Key {
        double frame = 0;
        core::Camera camera;
        friend bool operator==(const Key&, const Key&) = default;
    };
    std::vector<Key> keys;  // at least one, frames increasing

    /// The camera at a frame, held before the first and after the last key. Positions follow a
    /// cubic Hermite spline with Catmull and Rom's tangents (finite differences over frames),
    /// orientations turn at even speed between keys (slerp; Shoemake 1985), everything else is
    /// linear.
    core::Camera at(double frame) const;
};

/// A path; what keys leave out is that of the key before, and of `defaults` before the first. Of
/// "up" that is what was said last, not how the key before was rolled; of where it looks, the
/// "target" or "forward" that was said last.
/// Throws core::Error led by `file` and the place in it.
CameraPath cameraPathFromJson(const nlohmann::ordered_json& json, const core::Camera& defaults,
                              const core::Placement& placement, const std::string& file);

/// Reads a path file. Throws core::Error.
CameraPath readCameraPath(const std::filesystem::path& file, const core::Camera& defaults,
                          const core::Placement& placement);

}  // namespace app

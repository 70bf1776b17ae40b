// How the vertices of a primitive make triangles.
#pragma once

#include <optional>
#include <vector>

#include "core/gltf/accessors.h"
#include "core/gltf/json.h"

namespace core::gltf {

/// Triangles as the file orders them, with vertex numbers starting at `first`.
struct Topology {
    std::vector<glm::uvec3> triangles;
    uint64_t first = 0, count = 0;  // the range of vertices in use
};

/// The triangles of a primitive of the given mode; nothing where it has none. `indices` may be
/// null: vertices one after the other. Refuses indices of another type, and those of vertices that
/// there are not.
std::optional<Topology> readTopology(Load& load, const Object& primitive, uint64_t mode,
                                     const Accessor* indices, const Accessor& position);

}  // namespace core::gltf

// The steps of makeWorld, in the order in which they run. Private to world*.cpp.
#pragma once

#include <vector>

#include "core/scene/animation.h"
#include "core/scene/world.h"

namespace core {

/// One use of a mesh: its matrix into the file's space, its node for messages.
struct Instance {
    int mesh = 0;
    int node = 0;
    glm::dmat4 toFile{1};
};

/// Uses of meshes that can show something; those that their scale makes vanish are dropped with a
/// warning.
std::vector<Instance> findInstances(const Scene& scene, const Pose& pose, Warnings& warnings);

/// Centre of the triangles' bounds, and a power of two that brings their radius into [1, 100] when
/// it is outside.
Placement placeScene(const Scene& scene, const std::vector<Instance>& instances);

/// Fills positions, attributes, extra, triangles, bounds and radius. `world.features` decides what
/// is stored.
void flattenInstances(World& world, const Scene& scene, const std::vector<Instance>& instances);

/// Copies the materials in world units and lays out the texels of those textures that `used`
/// materials read.
void layOutMaterials(World& world, const Scene& scene, const std::vector<int>& used);

/// Cameras in the order of the nodes; one that frames the scene when the file has none.
void placeCameras(World& world, const Scene& scene, const Pose& pose);

/// Emissive triangles, punctual lights, environment, sun; their records, the CDF over them, and
/// their feature bits.
void collectEmitters(World& world, const Scene& scene, const Pose& pose);

/// JSON pointer of a node.
std::string nodePointer(int node);

}  // namespace core

// The tree by which an emitter is chosen for a place: built over spheres, cones of normals and
// intensities, split by the surface area orientation heuristic (A. Conty Estevez, C. Kulla,
// "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018); descended by
// shaders/shared/emitter_tree.h.
#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace core {

/// Where an emitter is, where it shines and how strongly. Angles from a cone around `axis` that
/// holds its normals: nothing is emitted farther than acos(cosEmission) from all of them.
/// `intensity` is the largest in any direction, in W/sr.
struct EmitterBounds {
    glm::vec3 low{0}, high{0};
    glm::vec3 axis{0, 0, 1};
    float cosNormals = 1, cosEmission = 0;
    bool bothFaces = false;
    double intensity = 0;
};

/// Nodes from the root to an emitter, at most: the ways that lead to it fit into a word.
inline constexpr uint32_t kMaxTreeDepth = 16;

/// The words of the tree over at least two emitters, as shaders/shared/emitter_tree.h reads them.
std::vector<glm::uvec4> makeEmitterTree(std::span<const EmitterBounds> emitters);

}  // namespace core

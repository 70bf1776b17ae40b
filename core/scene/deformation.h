// Meshes that change their shape: morph targets are added, then vertices follow the joints of a
// skin (glTF 2.0, 3.7.2.2 and 3.7.3). Private to world*.cpp.
#pragma once

#include <vector>

#include "core/scene/world_geometry.h"

namespace core {

/// Which uses of meshes change their shape, and which of these the first animation moves.
class DeformingUses {
public:
    explicit DeformingUses(const Scene& scene)
        : scene_(scene), movingNodes_(movingNodes(scene)),
          morphingNodes_(core::morphingNodes(scene))
    {}

    /// `use` as it deforms: away from its node where it has a skin, moving as its joints and
    /// weights do. As it is where it is rigid.
    Instance of(Instance use) const;

    bool moves(int node) const { return movingNodes_[static_cast<size_t>(node)]; }

private:
    const Scene& scene_;
    std::vector<bool> movingNodes_;
    std::vector<int> morphingNodes_;  // ascending
};

/// Appends the vertices of a deforming use as they are in `pose`, normals by the cofactors of their
/// vertex's matrix. Returns whether most vertices are mirrored, and the triangles with them.
bool appendDeformed(Geometry& geometry, const Scene& scene, const Instance& use, const Pose& pose,
                    const Placement& placement, const Stored& stored);

/// Where the vertices of a deforming use are in `pose`, in the file's space.
std::vector<glm::dvec3> deformedPositions(const Scene& scene, const Instance& use,
                                          const Pose& pose);

/// Bounds of a deforming use in any pose, from boxes around the vertices that follow one joint: a
/// vertex that follows several lies between their places.
class DeformedBounds {
public:
    DeformedBounds(const Scene& scene, const Instance& use);

    /// Adds to `reach` where the use is in `pose`, in the world that `placement` describes.
    void add(const Pose& pose, const Placement& placement, Extent& reach) const;

private:
    const Scene& scene_;
    Instance use_;
    std::vector<Extent> boxes_;    // per joint in use; one without a skin
    std::vector<Extent> targets_;  // of what each morph target adds at a weight of 1
};

}  // namespace core

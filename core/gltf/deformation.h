// How the loader reads what deforms a mesh: see deformation.cpp.
#pragma once

#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "core/gltf/compression.h"
#include "core/gltf/parts.h"

namespace core::gltf {

/// The vertices of a primitive that its mesh has, and those that it has twice.
struct VertexRange {
    uint64_t first = 0, count = 0, positions = 0;  // positions: in the file
    std::vector<uint32_t> twins;                   // Primitive::twins
};

/// What a node makes of its mesh. Nodes that make the same of it share it.
struct ShapeOfUse {
    std::vector<double> weights;  // of morph targets, for good; empty: none
    bool skinned = false;         // vertices follow the joints of a skin
    bool morphing = false;        // weights are animated, and the mesh is read without any

    friend bool operator<(const ShapeOfUse& a, const ShapeOfUse& b)
    {
        return std::tie(a.skinned, a.morphing, a.weights) <
               std::tie(b.skinned, b.morphing, b.weights);
    }
};

/// The first animation's channels of morph weights, by their nodes.
std::map<int, const AnimationChannel*> weightChannels(const Scene& scene);

ShapeOfUse shapeOf(const Scene& scene, const std::map<int, const AnimationChannel*>& channels,
                   const NodePlan& plan, const MeshUse& use);

/// How `mesh`, made of the primitive (`decoded` where that was compressed), deforms; null where it
/// does not. What cannot be used is left out with a warning.
std::shared_ptr<const Deformation>
readDeformation(Load& load, const std::vector<Accessor>& accessors, const DecodedPrimitive* decoded,
                const Object& primitive, const VertexRange& range, const ShapeOfUse& shape,
                const Mesh& mesh);

}  // namespace core::gltf

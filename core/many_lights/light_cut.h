// Cuts through a light tree: the clusters with which one slice is lit.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/many_lights/light_tree.h"

namespace core::many_lights {

/// The receiver for which a cut is made; it stands for its slice.
struct CutQuery {
    glm::vec3 position{0};
    glm::vec3 normal{0};             // unit; zero: light may come from anywhere
    float cosHalf = 1, sinHalf = 0;  // of a cone around the normals that it stands for
    float clampDistance = 0;         // lights do not count as nearer than this
    float spread = 0;                // how far receivers lie from the position, as a rule
};

/// A representative that stands for all lights of its node.
struct LightCluster {
    uint32_t node = 0;
    uint32_t light = 0;
    float scale = 1;  // times what the representative contributes
};

/// No less than what all lights of the node together contribute to a Lambertian receiver of albedo
/// pi at the query's position, whatever is in between; infinite for unclamped lights around it. Of
/// lights that are not Lambertian an estimate, as if they were; of receivers that are spread one
/// too, as if the light were nearer by their spread, though never by more than four times.
float clusterBound(const LightNode& node, LightKind kind, const CutQuery& query);

/// The bound of every light by itself, at its place in `bounds`.
void lightBounds(const LightTree& tree, const CutQuery& query, std::span<float> bounds);

/// Nodes by bound, largest first but for an eighth: those whose bounds agree in exponent and three
/// bits come in the order of a stack. Exact order costs a heap five times the bounds themselves.
class BoundQueue {
public:
    struct Entry {
        uint32_t node;
        LightKind kind;
    };

    void clear();
    void push(float bound, const Entry& entry);
    /// Not of an empty one.
    Entry pop();
    size_t size() const { return size_; }
    template <class Visit> void forEach(Visit&& visit) const
    {
        for (size_t b = 0; b <= top_; ++b)
            for (uint32_t i = heads_[b]; i != shared::kNone; i = entries_[i].next)
                visit(entries_[i].entry);
    }

private:
    static constexpr size_t kBuckets = 2048;  // of a float without sign: 8 bits and 3
    struct Link {
        Entry entry;
        uint32_t next;
    };
    std::array<uint32_t, kBuckets> heads_;
    std::vector<Link> entries_;
    uint32_t free_ = shared::kNone;
    size_t top_ = 0, size_ = 0;
};

/// Memory of a cut, which may be kept between calls.
struct CutMemory {
    BoundQueue queue;
};

/// Replaces a node with one of the largest bounds by its children until there are `clusters` (or
/// every light is one); in the order of the nodes, which is that of neighbouring lights. Depends on
/// no representative, so that it does not bias.
void cutLightTree(const LightTree& tree, const CutQuery& query, uint32_t clusters,
                  CutMemory& memory, std::vector<LightCluster>& out);

}  // namespace core::many_lights

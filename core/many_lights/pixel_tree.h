// A tree over the receivers of a slice, by where they lie and how they face (N. Bus, N. Mustafa, V.
// Biri, "IlluminationCut", 2015).
#pragma once

#include "core/many_lights/slice_rows.h"

namespace core::many_lights {

/// A node stands for adjacent rows; its children are the node after it and `right`.
struct PixelNode {
    glm::vec3 low{0}, high{0};  // bounds of the positions
    CutQuery query;             // their middle, with a cone around the shading normals
    IndexRange rows;
    uint32_t right = 0;      // of inner nodes
    float albedo = 0;        // largest BSDF of its Lambertian rows, of any colour
    uint32_t surface = ~0u;  // a row of another material; none: ~0

    bool isLeaf() const { return rows.size() == 1; }
    float radius() const { return 0.5f * glm::length(high - low); }
};

class PixelTree {
public:
    /// Orders the receivers that `chosen` lists: nodes whose normals differ much are split by
    /// these, others by position, in the middle of the widest extent. Only order() means something
    /// until bound() has been called.
    void build(std::span<const Receiver> receivers, std::span<const uint32_t> chosen);

    /// Receivers, in the order of the rows.
    std::span<const uint32_t> order() const { return order_; }
    /// Where they stand in `chosen`.
    std::span<const uint32_t> places() const { return places_; }

    /// Bounds every node, now that the rows are known; these are in order().
    void bound(const SliceRows& rows, const GatherSettings& settings);

    /// The root comes first; empty without receivers.
    std::span<const PixelNode> nodes() const { return nodes_; }

private:
    uint32_t split(std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                   const IndexRange& range);
    void boundLeaf(PixelNode& node, const SliceRows& rows, const GatherSettings& settings) const;
    void boundInner(PixelNode& node, const SliceRows& rows, const PixelNode& left,
                    const PixelNode& right) const;

    std::vector<uint32_t> order_, places_;
    std::vector<PixelNode> nodes_;
};

}  // namespace core::many_lights

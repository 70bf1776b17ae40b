// A tree over virtual lights, from which every slice takes a cut: nodes near and bright for it as
// small ones, the others as large ones (Walter et al., "Lightcuts", 2005).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/many_lights/virtual_light.h"

namespace core::many_lights {

/// A node stands for `count` lights; its children are the node after it and `right`.
/// Of the size of a cache line: reading nodes is most of what a cut costs.
struct alignas(64) LightNode {
    glm::vec3 low{0}, high{0};       // bounds of the positions; nothing of directional lights
    glm::vec3 axis{0, 0, 1};         // of a cone around the normals
    float cosHalf = 1, sinHalf = 0;  // its half angle; -1: lights shine to all sides
    float importance = 0;            // sum over the lights
    uint32_t count = 1;
    uint32_t right = 0;           // of inner nodes
    uint32_t representative = 0;  // index of a light, drawn in proportion to importance
    float scale = 1;              // importance over that of the representative

    bool isLeaf() const { return count == 1; }
};

struct LightTreeSettings {
    float normalScale = 0.01f;  // metres: in smaller nodes normals count, a unit as that length
    uint32_t seed = 0;          // of the draw of representatives
};

/// One tree for each kind of light. Expected over seeds, the representative's contribution times
/// (importance of the node) / (its own importance) is the sum over the node's lights.
struct LightTree {
    std::vector<LightNode> nodes;               // 2 n - 1 for n lights of a kind
    std::array<uint32_t, kLightKinds> roots{};  // kNone: no such lights
};

/// Builds the tree top-down, splitting at the mean along the first principal axis of positions (and
/// of normals, where a node is small). Does not depend on the number of threads. Nothing when
/// `stop` came first.
std::optional<LightTree> makeLightTree(std::span<const VirtualLight> lights,
                                       const LightTreeSettings& settings,
                                       const std::stop_token& stop = {});

}  // namespace core::many_lights

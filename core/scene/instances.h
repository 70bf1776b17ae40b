// Slots of instances: how triangles that are stored once are told apart where they are shown. The
// table that says it to renderers is that of shared/instances.h.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/world.h"

namespace core {

/// Instance i of a prototype, counted from its first one, has the slots from first + (i << bits).
struct InstanceSlots {
    uint32_t first = 0, bits = 0;

    uint32_t at(uint32_t i) const { return first + (i << bits); }
};

/// Of each prototype; `stored` are its triangles as a device stores them, of which each has a slot.
/// Nothing when there are not enough numbers.
std::optional<std::vector<InstanceSlots>> instanceSlots(std::span<const Prototype> prototypes,
                                                        std::span<const IndexRange> stored);

/// The table for a device on which the prototypes are `stored` so; empty without prototypes.
std::vector<glm::uvec4> makeInstanceTable(const World& world, std::span<const IndexRange> stored);

/// World::triangles of each prototype: how the processor stores them.
std::vector<IndexRange> prototypeTriangles(const World& world);

}  // namespace core

// The part of space that a leaf of a guide answers for.
#pragma once

#include <cstdint>

#include "core/guiding/guide_options.h"

namespace core::guiding {

struct GuideCell {
    glm::vec3 low{0}, high{1};
    uint32_t depth = 0;  // cuts between the root and it

    GuideCell() = default;
    explicit GuideCell(const GuideBox& box) : low(box.low), high(box.low + box.side) {}

    /// One of the two parts that a plane across an axis makes of it.
    GuideCell part(float plane, uint32_t axis, bool above) const
    {
        GuideCell cell = *this;
        (above ? cell.low : cell.high)[int(axis)] = plane;
        ++cell.depth;
        return cell;
    }
};

}  // namespace core::guiding

// A leaf of a guide while it learns: what came from where, how much its surfaces reflect, and how
// each share of the BSDF would have done. See guide.h.
#pragma once

#include <array>
#include <span>
#include <variant>

#include "core/guiding/direction_grid.h"
#include "core/guiding/direction_lobes.h"
#include "core/guiding/lesson.h"

namespace core::guiding {

/// Shares of the BSDF among which a leaf chooses.
inline constexpr std::array<double, 6> kGuideShares{1, 0.8, 0.6, 0.4, 0.25, 0.12};

/// Everything is kept for ever but `moments` and `tested`, in which newer guides count more, and
/// lobes, in which newer lessons do.
struct LearningLeaf {
    double visits = 0, reflected = 0;
    // Per share: the sum of value^2 pdf / (density with that share); records that it is made of.
    std::array<double, kGuideShares.size()> moments{};
    double tested = 0;
    std::variant<DirectionGrid, DirectionLobes> directions;
    float share = 1;

    /// One that knows nothing yet; `kind` as in shared/guide_tables.h.
    explicit LearningLeaf(uint32_t kind);

    /// Half of everything: what a child inherits.
    void halve();

    /// The records of an iteration: first they test the guide that chose their directions, then
    /// they become part of the next one. `decay` is what earlier tests still count.
    void learn(std::span<const Lesson> lessons, double decay, const GuideOptions& options);

    /// shared::guideWords of its kind, in the order that samplers read them.
    void writeWords(std::span<glm::vec4> words) const;

private:
    void test(const Lesson& lesson);
    void choose(const GuideOptions& options);
    bool knowsLight() const;
};

}  // namespace core::guiding

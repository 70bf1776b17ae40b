// A leaf of a guide while it learns: what came from where, how much its surfaces reflect, and how
// each share of the BSDF would have done. See guide.h; how it learns: guide_options.h.
#pragma once

#include <array>
#include <span>
#include <variant>

#include "core/guiding/direction_grid.h"
#include "core/guiding/direction_lobes.h"
#include "core/guiding/direction_tree.h"
#include "core/guiding/guide_cell.h"
#include "core/guiding/learnt_share.h"
#include "core/guiding/lesson.h"
#include "core/guiding/record_store.h"

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
    std::variant<DirectionGrid, DirectionLobes, DirectionTree> directions;
    float share = 1;
    LearntShare learntShare;
    GuideCell cell;
    RecordStore store;
    uint32_t before = 0;  // the leaf it comes from, in the tables of the last iteration

    /// One that knows nothing yet; `kind` as in shared/guide_tables.h.
    explicit LearningLeaf(uint32_t kind);

    /// Half of everything: what a child inherits.
    void halve();

    /// What one of two children inherits that a plane across an axis parts.
    LearningLeaf child(float plane, uint32_t axis, bool above) const;

    /// The records of an iteration: first they test the guide that chose their directions, then
    /// they become part of the next one. `decay` is what earlier tests still count.
    void learn(std::span<const Lesson> lessons, double decay, const GuideOptions& options);

    /// Directions are drawn from what has been learnt; with GuideMemory::residual and a tree from
    /// what the lessons `had`, of the density so far, lack if so many more `come`.
    void aim(const GuideOptions& options, double had, double come);

    /// Appends its words in the order that samplers read them; returns where they are.
    uint32_t write(GuideTables& tables, const GuideOptions& options) const;

private:
    void test(const Lesson& lesson, const GuideOptions& options);
    void teach(std::span<const Lesson> lessons, const GuideOptions& options);
    void addToDirections(std::span<const Lesson> lessons, const GuideOptions& options);
    void choose(const GuideOptions& options);
    bool knowsLight() const;
};

}  // namespace core::guiding

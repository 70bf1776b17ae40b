// A leaf of a guide while it learns: the grid of what came from where, how much its surfaces
// reflect, and how each share of the BSDF would have done. See guide.h.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/guiding/guide.h"

namespace core::guiding {

inline constexpr size_t kGuideCells = size_t(shared::kGuideSide) * shared::kGuideSide;

/// Shares of the BSDF among which a leaf chooses.
inline constexpr std::array<double, 6> kGuideShares{1, 0.8, 0.6, 0.4, 0.25, 0.12};

/// A record as leaves take it.
struct Lesson {
    glm::vec3 position{0};
    float value = 0;  // f |cos| L over `pdf`, a scalar: 0 for paths that brought nothing
    float reflected = 0;
    glm::vec2 square{0};         // the direction
    float pdf = 0, bsdfPdf = 0;  // of the mixture (0: no direction to learn) and the BSDF
    float guidePdf = 0;          // of the tables that chose the direction
    float sharp = 0;             // share of sharp lobes
    uint32_t leaf = 0;
};

/// What a record of a path teaches; `final` is all that the path brought home, `tables` are those
/// that it was sampled with.
Lesson lessonOf(const shared::GuideRecord& record, float final, const GuideTables& tables);

/// Everything is kept for ever but `moments` and `tested`, in which newer guides count more.
struct LearningLeaf {
    double visits = 0, reflected = 0;
    // Per share: the sum of value^2 pdf / (density with that share); records that it is made of.
    std::array<double, kGuideShares.size()> moments{};
    double tested = 0;
    double total = 0;                        // of the cells
    std::array<float, kGuideCells> cells{};  // row by row
    float share = 1;

    /// Half of everything: what a child inherits.
    void halve();

    /// The records of an iteration: first they test the guide that chose their directions, then
    /// they become part of the next one. `decay` is what earlier tests still count.
    void learn(std::span<const Lesson> lessons, double decay, const GuideOptions& options);

    /// A value in the direction of a point of the square, spread over the four nearest cells: what
    /// moving it about by up to half a cell would give on average.
    void deposit(glm::vec2 square, float value);

    /// kGuideQuads words in the order of shared::sampleGuide.
    void writeQuads(std::span<glm::vec4> quads) const;

private:
    void test(const Lesson& lesson);
    void choose(const GuideOptions& options);
};

}  // namespace core::guiding

// Directions of a leaf as a quadtree that learns (shared/guide_tree.h): quarters of the octahedral
// square with more than a hundredth of the light are cut again. T. Mueller, M. Gross, J. Novak,
// "Practical Path Guiding for Efficient Light-Transport Simulation" (2017).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/guiding/lesson.h"
#include "core/guiding/quadtree.h"

namespace core::guiding {

class DirectionTree {
public:
    DirectionTree();

    /// Whether any lesson has brought light.
    bool knowsLight() const { return total_ > 0; }

    /// Half of everything: what a child inherits.
    void halve();

    /// Drops what has been learnt but for the form of the tree that it asks for.
    void forget();

    /// Cuts the tree anew by what is known, and adds the lessons. GuideFilter::spread moves each at
    /// random by half the side of the quarter that it falls in at most: the box filter in one
    /// deposit.
    void learn(std::span<const Lesson> lessons, const GuideOptions& options);

    /// The density that has been learnt: of second moments, their root.
    Quadtree density() const;

    /// The density that samples are drawn from.
    void aim(Quadtree density) { aimed_ = std::move(density); }
    const Quadtree& aimed() const { return aimed_; }

    /// Appends the nodes that samplers read.
    void write(std::vector<glm::uvec4>& nodes) const;

private:
    struct Node {
        std::array<double, 4> sum{};
        std::array<uint16_t, 4> child{};  // 0: none
        uint32_t depth = 1;
    };

    void refine();
    void deposit(glm::vec2 square, double value, uint32_t random, bool spread);
    std::pair<size_t, uint32_t> quarterAt(glm::vec2 square, float& side) const;

    std::vector<Node> nodes_;
    double total_ = 0;
    bool isCut_ = false;  // since the last lessons
    bool moments_ = false;
    Quadtree aimed_;
};

}  // namespace core::guiding

// The directional quadtree of path guiding as a density on the unit square, constant in every leaf.
// T. Mueller, M. Gross, J. Novak, "Practical Path Guiding for Efficient Light-Transport Simulation"
// (2017). How trees are learnt and what the square means as directions is not here. What differs: a
// node's sums count only relative to each other, so that the density integrates to one whatever
// rounding did to the levels above.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/reuse/solve_c.h"

namespace core::guiding {

class Quadtree {
public:
    static constexpr uint32_t kMaxDepth = 20;      // levels of quarters, the root's own included
    static constexpr size_t kMaxNodes = 0x10000u;  // as many as 16 bits can number

    /// One cell and its quarters: bit 0 of a quarter's number is its half in x, bit 1 in y. Sums
    /// fit in fp32 because only their ratios within a node matter (adding up many small terms needs
    /// more precision meanwhile).
    struct Node {
        std::array<float, 4> sum{};       // of what has been recorded in each quarter
        std::array<uint16_t, 4> child{};  // number of the quarter's node; 0: a leaf

        double total() const
        {
            return double(sum[0]) + double(sum[1]) + double(sum[2]) + double(sum[3]);
        }
    };
    static_assert(sizeof(Node) == 24);

    struct Sample {
        glm::dvec2 x{0};
        double pdf = 0;
    };

    /// The uniform density: one node that has recorded nothing.
    Quadtree() : nodes_(1) {}

    /// From the topology and the sums of the leaves; sums of quarters that have a node are computed
    /// from it. Node 0 is the root, children come after their parents and have one parent each.
    /// CHECKs that, the depth, and that sums are finite and not negative.
    explicit Quadtree(std::vector<Node> nodes);

    /// Density at x in [0, 1]^2, per unit area; integrates to one. 0 in quarters that recorded
    /// nothing, and one everywhere if all did.
    double pdf(glm::dvec2 x) const;

    /// A point of that density, and the density there, which is positive. Draws one number per
    /// level, because a single one runs out of bits, and two for the place in the leaf; `random()`
    /// is uniform in [0, 1).
    template <class Random> Sample sample(Random& random) const
    {
        Cell cell;
        uint16_t at = 0;
        do {
            const uint32_t quarter = pick(nodes_[at], random());
            cell = cell.quarter(quarter, fraction(nodes_[at], quarter));
            at = nodes_[at].child[quarter];
        } while (at != 0);
        const double x = random();
        return {cell.at({x, random()}), cell.density};
    }

    /// Everything recorded; 0 for the uniform density.
    double total() const { return nodes_[0].total(); }
    uint32_t depth() const;
    std::span<const Node> nodes() const { return nodes_; }

    /// The share of a quarter in its node: a quarter each if nothing was recorded.
    static double fraction(const Node& node, uint32_t quarter)
    {
        const double total = node.total();
        return total > 0 ? double(node.sum[quarter]) / total : 0.25;
    }

private:
    /// Position of a walk from the root.
    struct Cell {
        glm::dvec2 low{0};
        double side = 1, density = 1;

        Cell quarter(uint32_t i, double share) const
        {
            const double half = side / 2;
            return {low + half * glm::dvec2(i & 1, i >> 1), half, density * 4 * share};
        }
        glm::dvec2 at(glm::dvec2 u) const;  // never in the next cell
    };
    static uint32_t pick(const Node& node, double xi);

    std::vector<Node> nodes_;
};

/// The overlap of two densities q and p, and the mass of p beyond c q.
struct Overlap {
    double overlap = 0;   // O(c), integral of min(c q, p)
    double residual = 0;  // R(c), integral of (p - c q)+; O + R = 1
    reuse::Masses above;  // of the set where p > c q: what reuse::solveC asks for
};

/// Exact but for rounding, by walking both trees at once: time proportional to their nodes. c >= 0.
Overlap overlap(const Quadtree& q, const Quadtree& p, double c);

/// The density (p - c q)+ / R of what is missing where samples of q are reused for p, and its mass
/// R. With R = 0 nothing is missing, and the tree is the uniform one: not to be sampled. Where the
/// leaves of both trees together are more than a tree can have, the finest ones are averaged, so
/// that it is still positive wherever p > c q.
struct Residual {
    Quadtree tree;
    double mass = 0;
};
Residual residual(const Quadtree& q, const Quadtree& p, double c);

/// The best scale of q for N old and n new samples: c n kappa = N R(c) (reuse::solveC).
double bestC(const Quadtree& q, const Quadtree& p, double N, double n, double kappa = 1);

}  // namespace core::guiding

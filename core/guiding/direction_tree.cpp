#include "core/guiding/direction_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "shared/rng.h"

namespace core::guiding {

namespace {

/// A quarter with more than this share of the light is cut (T. Mueller et al., 2017).
constexpr double kMostShare = 0.01;
constexpr double kWholeShare = 0xffff;
static_assert(Quadtree::kMaxDepth == shared::kGuideTreeDepth);

/// The point of the square meant by one that lies next to it: each side of the square meets itself,
/// turned about its middle.
glm::vec2 wrapped(glm::vec2 p)
{
    if (p.x < 0 || p.x > 1) p = {p.x < 0 ? -p.x : 2 - p.x, 1 - p.y};
    if (p.y < 0 || p.y > 1) p = {1 - p.x, p.y < 0 ? -p.y : 2 - p.y};
    return p;
}

}  // namespace

DirectionTree::DirectionTree() : nodes_(1) {}

void DirectionTree::halve()
{
    total_ *= 0.5;
    for (Node& node : nodes_)
        for (double& s : node.sum) s *= 0.5;
}

void DirectionTree::forget()
{
    if (!isCut_) refine();
    isCut_ = true;
    total_ = 0;
    for (Node& node : nodes_) node.sum = {};
}

Quadtree DirectionTree::density() const
{
    std::vector<Quadtree::Node> nodes(nodes_.size());
    for (size_t i = 0; i < nodes.size(); ++i) {
        nodes[i].child = nodes_[i].child;
        const double area = std::ldexp(1.0, -2 * int(nodes_[i].depth));
        for (size_t k = 0; k < 4 && total_ > 0; ++k) {
            const double share = nodes_[i].sum[k] / total_;
            nodes[i].sum[k] = static_cast<float>(moments_ ? std::sqrt(share * area) : share);
        }
    }
    return Quadtree(std::move(nodes));
}

/// The same sums in a tree that is cut where the light is now.
void DirectionTree::refine()
{
    const Quadtree masses = density();
    // A cell of the new tree: a node of the old one, or a part of one of its quarters.
    struct Cell {
        size_t old;
        bool isFlat;
        double sum, mass;
    };
    std::vector<Node> nodes(1);
    std::vector<Cell> cells{{0, false, 0, 1}};
    const auto sumOf = [this](const auto& self, size_t node, size_t k) -> double {
        const Node& n = nodes_[node];
        if (n.child[k] == 0) return n.sum[k];
        double sum = 0;
        for (size_t j = 0; j < 4; ++j) sum += self(self, n.child[k], j);
        return sum;
    };
    for (size_t i = 0; i < nodes.size(); ++i) {  // breadth first: the coarse cuts come first
        const Cell cell = cells[i];
        for (uint32_t k = 0; k < 4; ++k) {
            Cell part = cell;
            if (cell.isFlat) {
                part.sum /= 4;
                part.mass /= 4;
            } else {
                const uint16_t child = nodes_[cell.old].child[k];
                part.mass *= Quadtree::fraction(masses.nodes()[cell.old], k);
                part.isFlat = child == 0;
                part.old = child;
                part.sum = part.isFlat ? nodes_[cell.old].sum[k] : 0;
            }
            const bool cuts = part.mass > kMostShare && nodes[i].depth < Quadtree::kMaxDepth &&
                              nodes.size() < Quadtree::kMaxNodes;
            if (!cuts) {
                nodes[i].sum[k] = part.isFlat ? part.sum : sumOf(sumOf, cell.old, k);
                continue;
            }
            nodes[i].child[k] = static_cast<uint16_t>(nodes.size());
            const uint32_t depth = nodes[i].depth + 1;
            nodes.push_back({});
            nodes.back().depth = depth;
            cells.push_back(part);
        }
    }
    nodes_ = std::move(nodes);
}

void DirectionTree::learn(std::span<const Lesson> lessons, const GuideOptions& options)
{
    moments_ = options.target == GuideTarget::secondMoment;
    if (!isCut_) refine();
    isCut_ = false;
    for (const Lesson& lesson : lessons) {
        if (!(lesson.pdf > 0 && lesson.value > 0)) continue;
        const uint32_t random = shared::hashUint(
            shared::floatAsUint(lesson.position.x) ^
            shared::hashUint(shared::floatAsUint(lesson.position.y) ^
                             shared::hashUint(shared::floatAsUint(lesson.direction.z))));
        deposit(shared::guideSquare(lesson.direction), double(lesson.value), random,
                options.filter == GuideFilter::spread);
    }
}

/// The quarter, as its node and its number, with its side.
std::pair<size_t, uint32_t> DirectionTree::quarterAt(glm::vec2 square, float& side) const
{
    glm::vec2 p = glm::clamp(square, 0.0f, shared::kOneMinusEpsilon);
    side = 1;
    for (size_t at = 0;;) {
        p *= 2.0f;
        side *= 0.5f;
        const uint32_t x = p.x >= 1, y = p.y >= 1, k = x | (y << 1u);
        p -= glm::vec2(float(x), float(y));
        const size_t child = nodes_[at].child[k];
        if (child == 0) return {at, k};
        at = child;
    }
}

void DirectionTree::deposit(glm::vec2 square, double value, uint32_t random, bool spread)
{
    float side = 1;
    std::pair<size_t, uint32_t> quarter = quarterAt(square, side);
    if (spread) {
        const glm::vec2 u(shared::unitFloat(random), shared::unitFloat(shared::hashUint(random)));
        quarter = quarterAt(wrapped(square + side * (u - 0.5f)), side);
    }
    nodes_[quarter.first].sum[quarter.second] += value;
    total_ += value;
}

void DirectionTree::write(std::vector<glm::uvec4>& nodes) const
{
    for (const Quadtree::Node& node : aimed_.nodes()) {
        const double total = knowsLight() ? node.total() : 0;
        glm::uvec4 word(0u);
        for (uint32_t k = 0; k < 4 && total > 0; ++k) {
            const auto share =
                static_cast<uint32_t>(std::lround(kWholeShare * (double(node.sum[k]) / total)));
            // Nobody goes where there is nothing.
            if (share > 0) word[int(k)] = share | (uint32_t(node.child[k]) << 16u);
        }
        nodes.push_back(word);
    }
}

}  // namespace core::guiding

// Density, sampling and pairs of quadtrees. See quadtree.h.
#include "core/guiding/quadtree.h"

#include <algorithm>
#include <cmath>

namespace core::guiding {

namespace {

/// Depth of every node, 1 for the root; CHECKs the shape.
std::vector<uint32_t> depthsOf(std::span<const Quadtree::Node> nodes)
{
    CHECK(!nodes.empty() && nodes.size() <= Quadtree::kMaxNodes);
    std::vector<uint32_t> depths(nodes.size(), 0);
    depths[0] = 1;
    for (size_t i = 0; i < nodes.size(); ++i) {
        CHECK(depths[i] != 0 && depths[i] <= Quadtree::kMaxDepth);  // has a parent before it
        for (const uint16_t child : nodes[i].child) {
            if (child == 0) continue;
            CHECK(child > i && child < nodes.size() && depths[child] == 0);
            depths[child] = depths[i] + 1;
        }
    }
    return depths;
}

}  // namespace

Quadtree::Quadtree(std::vector<Node> nodes) : nodes_(std::move(nodes))
{
    depthsOf(nodes_);
    for (size_t i = nodes_.size(); i-- > 0;) {
        Node& node = nodes_[i];
        for (uint32_t j = 0; j < 4; ++j) {
            if (node.child[j] != 0) node.sum[j] = static_cast<float>(nodes_[node.child[j]].total());
            CHECK(std::isfinite(node.sum[j]) && node.sum[j] >= 0);
        }
    }
}

uint32_t Quadtree::depth() const
{
    const std::vector<uint32_t> depths = depthsOf(nodes_);
    return *std::max_element(depths.begin(), depths.end());
}

double Quadtree::pdf(glm::dvec2 x) const
{
    double density = 1;
    uint16_t at = 0;
    do {
        const glm::dvec2 twice = 2.0 * x;
        const uint32_t right = twice.x >= 1, upper = twice.y >= 1;
        x = twice - glm::dvec2(right, upper);
        const uint32_t quarter = right + 2 * upper;
        density *= 4 * fraction(nodes_[at], quarter);
        at = nodes_[at].child[quarter];
    } while (at != 0 && density > 0);
    return density;
}

uint32_t Quadtree::pick(const Node& node, double xi)
{
    const double total = node.total();
    if (!(total > 0)) return std::min(static_cast<uint32_t>(4 * xi), 3u);
    double cumulated = 0;
    uint32_t last = 0;
    for (uint32_t i = 0; i < 4; ++i) {
        if (!(node.sum[i] > 0)) continue;
        cumulated += double(node.sum[i]);
        last = i;
        if (xi * total < cumulated) break;
    }
    return last;  // rounding cannot lead to an empty quarter
}

glm::dvec2 Quadtree::Cell::at(glm::dvec2 u) const
{
    const auto inside = [this](double start, double offset) {
        const double end = start + side;
        return std::min(start + side * offset, std::nextafter(end, 0.0));
    };
    return {inside(low.x, u.x), inside(low.y, u.y)};
}

namespace {

/// A cell of a tree during a walk through two of them. Inside a leaf the walk goes on without
/// nodes, at the leaf's density.
struct Place {
    const Quadtree* tree;
    const Quadtree::Node* node;  // null inside a leaf
    double density;

    explicit Place(const Quadtree& t) : tree(&t), node(&t.nodes()[0]), density(1) {}

    bool isLeaf() const { return node == nullptr; }
    Place quarter(uint32_t i) const
    {
        Place next = *this;
        if (isLeaf()) return next;
        next.density *= 4 * Quadtree::fraction(*node, i);
        next.node = node->child[i] == 0 ? nullptr : &tree->nodes()[node->child[i]];
        return next;
    }
};

/// Adds a cell of both trees; as deep as the deeper one, at most Quadtree::kMaxDepth.
void addOverlap(Overlap& sum, const Place& q, const Place& p, double c, double area)
{
    if (q.isLeaf() && p.isLeaf()) {
        const double scaled = c * q.density;
        sum.overlap += area * std::min(scaled, p.density);
        if (p.density > scaled) {
            sum.residual += area * (p.density - scaled);
            sum.above.p += area * p.density;
            sum.above.q += area * q.density;
        }
        return;
    }
    for (uint32_t i = 0; i < 4; ++i) addOverlap(sum, q.quarter(i), p.quarter(i), c, area / 4);
}

/// The residual tree, depth first, in double: sums are masses.
class ResidualBuilder {
public:
    ResidualBuilder(double c, size_t nodes) : c_(c)
    {
        nodes_.reserve(std::min(nodes, Quadtree::kMaxNodes));
    }

    /// Makes the node of a cell that is not a leaf of both; returns its mass.
    double build(const Place& q, const Place& p, double area)
    {
        const size_t index = nodes_.size();
        nodes_.emplace_back();
        double mass = 0;
        for (uint32_t i = 0; i < 4; ++i) {
            const Place qi = q.quarter(i), pi = p.quarter(i);
            const bool splits =
                !(qi.isLeaf() && pi.isLeaf()) && nodes_.size() < Quadtree::kMaxNodes;
            const size_t child = splits ? nodes_.size() : 0;
            const double part = splits ? build(qi, pi, area / 4) : massOf(qi, pi, area / 4);
            if (splits && !(part > 0)) nodes_.resize(child);  // nothing below: a leaf will do
            nodes_[index].child[i] = static_cast<uint16_t>(part > 0 ? child : 0);
            nodes_[index].sum[i] = static_cast<float>(part);
            mass += part;
        }
        return mass;
    }

    std::vector<Quadtree::Node> take() { return std::move(nodes_); }

private:
    double massOf(const Place& q, const Place& p, double area) const
    {
        Overlap sum;
        addOverlap(sum, q, p, c_, area);
        return sum.residual;
    }

    double c_;
    std::vector<Quadtree::Node> nodes_;
};

}  // namespace

Overlap overlap(const Quadtree& q, const Quadtree& p, double c)
{
    CHECK(c >= 0);
    Overlap sum;
    addOverlap(sum, Place(q), Place(p), c, 1);
    return sum;
}

Residual residual(const Quadtree& q, const Quadtree& p, double c)
{
    CHECK(c >= 0);
    ResidualBuilder builder(c, q.nodes().size() + p.nodes().size());
    const double mass = builder.build(Place(q), Place(p), 1);
    return {Quadtree(builder.take()), mass};
}

double bestC(const Quadtree& q, const Quadtree& p, double N, double n, double kappa)
{
    return reuse::solveC(
        N, n, [&](double c) { return overlap(q, p, c).above; }, kappa);
}

}  // namespace core::guiding

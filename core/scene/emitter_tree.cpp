// See emitter_tree.h. Top-down, twelve bins along each axis.
#include "core/scene/emitter_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/base/check.h"
#include "shared/emitter_tree.h"

namespace core {

namespace {

using glm::vec3;
using std::numbers::pi;

/// Directions within `angle` of `axis`.
struct Cone {
    glm::dvec3 axis{0, 0, 1};
    double angle = 0;
};

/// A cone that holds both.
Cone hull(Cone a, Cone b)
{
    if (b.angle > a.angle) std::swap(a, b);
    const double between = std::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0));
    if (std::min(between + b.angle, pi) <= a.angle) return a;
    const double angle = 0.5 * (a.angle + between + b.angle);
    if (angle >= pi) return {a.axis, pi};
    const glm::dvec3 pivot = glm::cross(a.axis, b.axis);
    const double length = glm::length(pivot);
    if (!(length > 0)) return {a.axis, pi};
    const double turn = angle - a.angle;
    const glm::dvec3 side = glm::cross(pivot / length, a.axis);
    return {glm::normalize(std::cos(turn) * a.axis + std::sin(turn) * side), angle};
}

/// Bounds of a set of emitters; none has intensity 0.
struct Bounds {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};
    Cone normals;
    double emission = 0;  // angle beyond the normals
    bool bothFaces = false;
    double intensity = 0;
    bool empty = true;

    void add(const Bounds& b)
    {
        if (b.empty) return;
        low = glm::min(low, b.low);
        high = glm::max(high, b.high);
        Cone other = b.normals;
        if (bothFaces && b.bothFaces && glm::dot(normals.axis, other.axis) < 0)
            other.axis = -other.axis;
        normals = empty ? other : hull(normals, other);
        emission = std::max(emission, b.emission);
        bothFaces |= b.bothFaces;
        intensity += b.intensity;
        empty = false;
    }

    double surfaceArea() const
    {
        const glm::dvec3 d = high - low;
        return 2 * (d.x * d.y + d.y * d.z + d.z * d.x);
    }

    /// Solid angle of where the emitters shine, weighted by the cosine outside of the normals'
    /// cone.
    double orientation() const
    {
        const double o = normals.angle, w = std::min(o + emission, pi);
        return 2 * pi * (1 - std::cos(o)) +
               0.5 * pi *
                   (2 * w * std::sin(o) - std::cos(o - 2 * w) - 2 * o * std::sin(o) + std::cos(o));
    }
};

Bounds boundsOf(const EmitterBounds& e)
{
    const auto angle = [](float cosine) {
        return std::acos(std::clamp(static_cast<double>(cosine), -1.0, 1.0));
    };
    return {e.low,
            e.high,
            {glm::dvec3(e.axis), angle(e.cosNormals)},
            angle(e.cosEmission),
            e.bothFaces,
            e.intensity,
            false};
}

/// 16 bits of a cosine, rounded down, so that the cone is none too narrow; the packed axis is off
/// by 7e-5 rad.
uint32_t packCosine(double angle)
{
    const double cosine = std::cos(std::min(angle + 1e-4, pi));
    return static_cast<uint32_t>(std::clamp((cosine + 1) * 0.5 * 65535.0 - 0.01, 0.0, 65535.0));
}

class Builder {
public:
    explicit Builder(std::span<const EmitterBounds> emitters)
        : order_(emitters.size()), nodes_(4 * (emitters.size() - 1)),
          trails_((emitters.size() + 3) / 4, glm::uvec4(0))
    {
        bounds_.reserve(emitters.size());
        for (const EmitterBounds& e : emitters) bounds_.push_back(boundsOf(e));
        std::iota(order_.begin(), order_.end(), 0u);
    }

    std::vector<glm::uvec4> build()
    {
        split(0, static_cast<uint32_t>(order_.size()), 0, 0);
        nodes_.insert(nodes_.end(), trails_.begin(), trails_.end());
        return std::move(nodes_);
    }

private:
    /// Makes the node of emitters [begin, end) of the order, at least two; returns its index.
    uint32_t split(uint32_t begin, uint32_t end, uint32_t depth, uint32_t trail)
    {
        const uint32_t node = next_++;
        const uint32_t middle = part(begin, end, depth);
        child(4 * node, begin, middle, depth, trail);
        child(4 * node + 2, middle, end, depth, trail | (1u << depth));
        return node;
    }

    /// Makes one child of a node, with its words from `word` on.
    void child(uint32_t word, uint32_t begin, uint32_t end, uint32_t depth, uint32_t trail)
    {
        Bounds all;
        for (uint32_t i = begin; i < end; ++i) all.add(bounds_[order_[i]]);
        uint32_t link;
        if (end - begin == 1) {
            const uint32_t emitter = order_[begin];
            link = shared::kEmitterLeaf | emitter;
            trails_[emitter / 4][static_cast<int>(emitter % 4)] = trail;
        } else {
            link = split(begin, end, depth + 1, trail);
        }
        if (all.bothFaces) link |= shared::kEmitterBothFaces;
        pack(all, link, word);
    }

    void pack(const Bounds& b, uint32_t link, uint32_t word)
    {
        const glm::dvec3 centre = 0.5 * (b.low + b.high);
        const vec3 c(centre);
        // From the centre as stored, and outwards by more than what is lost where it is read.
        const double radius =
            glm::distance(glm::dvec3(c), b.high) * (1 + 1e-6) + 1e-7 * glm::length(centre) + 1e-20;
        nodes_[word] = {std::bit_cast<uint32_t>(c.x), std::bit_cast<uint32_t>(c.y),
                        std::bit_cast<uint32_t>(c.z),
                        std::bit_cast<uint32_t>(static_cast<float>(radius))};
        nodes_[word + 1] = {shared::packOct(vec3(b.normals.axis)),
                            packCosine(b.normals.angle) | (packCosine(b.emission) << 16),
                            std::bit_cast<uint32_t>(static_cast<float>(b.intensity)), link};
    }

    /// Reorders [begin, end); returns where the second child begins.
    uint32_t part(uint32_t begin, uint32_t end, uint32_t depth)
    {
        const uint32_t count = end - begin, half = begin + count / 2;
        if (count == 2) return half;
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        for (uint32_t i = begin; i < end; ++i) {
            low = glm::min(low, centre(order_[i]));
            high = glm::max(high, centre(order_[i]));
        }
        // Halving from here on must still end within the trail's bits.
        const uint32_t left = static_cast<uint32_t>(kMaxTreeDepth) - depth;
        const bool deep = static_cast<uint32_t>(std::bit_width(count - 1)) + 1 >= left;
        const Cut cut = deep ? Cut{} : bestCut(begin, end, low, high);
        if (cut.axis < 0) {
            const glm::dvec3 d = high - low;
            const int axis = d.x >= d.y ? (d.x >= d.z ? 0 : 2) : (d.y >= d.z ? 1 : 2);
            std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                             [&](uint32_t a, uint32_t b) {
                                 const double x = centre(a)[axis], y = centre(b)[axis];
                                 return x < y || (x == y && a < b);
                             });
            return half;
        }
        const auto second =
            std::stable_partition(order_.begin() + begin, order_.begin() + end, [&](uint32_t i) {
                return binOf(centre(i)[cut.axis], low[cut.axis], high[cut.axis]) <= cut.bin;
            });
        return static_cast<uint32_t>(second - order_.begin());
    }

    static constexpr int kBins = 12;

    /// The last bin of the first child; no axis where nothing can be told apart.
    struct Cut {
        int axis = -1, bin = 0;
    };

    glm::dvec3 centre(uint32_t i) const { return 0.5 * (bounds_[i].low + bounds_[i].high); }

    static int binOf(double x, double low, double high)
    {
        return std::clamp(static_cast<int>(kBins * ((x - low) / (high - low))), 0, kBins - 1);
    }

    Cut bestCut(uint32_t begin, uint32_t end, const glm::dvec3& low, const glm::dvec3& high) const
    {
        const glm::dvec3 extent = high - low;
        const double longest = std::max({extent.x, extent.y, extent.z});
        Cut best;
        double least = std::numeric_limits<double>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            if (!(extent[axis] > 0)) continue;
            std::array<Bounds, kBins> bins;
            for (uint32_t i = begin; i < end; ++i)
                bins[static_cast<size_t>(binOf(centre(order_[i])[axis], low[axis], high[axis]))]
                    .add(bounds_[order_[i]]);
            std::array<double, kBins> costs{};  // of the first child
            Bounds sum;
            for (size_t b = 0; b + 1 < kBins; ++b) {
                sum.add(bins[b]);
                costs[b] = cost(sum);
            }
            sum = {};
            for (size_t b = kBins - 1; b > 0; --b) {
                sum.add(bins[b]);
                const double both = (costs[b - 1] + cost(sum)) * longest / extent[axis];
                if (!sum.empty && both < least && costs[b - 1] > 0) {
                    least = both;
                    best = {axis, static_cast<int>(b) - 1};
                }
            }
        }
        return best;
    }

    /// Intensity times where it comes from and where it goes to: sets that are worth knowing apart
    /// have little of both.
    static double cost(const Bounds& b)
    {
        if (b.empty) return 0;
        const glm::dvec3 d = b.high - b.low;
        // Flat sets have no volume to meet: their edges still count.
        const double size = b.surfaceArea() + 1e-3 * glm::dot(d, d);
        return (b.intensity + std::numeric_limits<double>::min()) *
               (size + std::numeric_limits<double>::min()) * b.orientation();
    }

    std::vector<Bounds> bounds_;
    std::vector<uint32_t> order_;
    std::vector<glm::uvec4> nodes_, trails_;
    uint32_t next_ = 0;
};

}  // namespace

std::vector<glm::uvec4> makeEmitterTree(std::span<const EmitterBounds> emitters)
{
    CHECK(emitters.size() >= 2 && emitters.size() <= shared::kEmitterIndex);
    return Builder(emitters).build();
}

}  // namespace core

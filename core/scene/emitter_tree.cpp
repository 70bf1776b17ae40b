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

/// A fraction in 16 bits, nearest or rounded down.
uint32_t packSnorm(double x)
{
    return static_cast<uint32_t>(std::lround(std::clamp(x, -1.0, 1.0) * 32767)) & 0xffffu;
}
uint32_t packSnormDown(double x)
{
    return static_cast<uint32_t>(static_cast<int>(std::floor(std::clamp(x, -1.0, 1.0) * 32767))) &
           0xffffu;
}

uint32_t bitsOf(double x)
{
    return std::bit_cast<uint32_t>(static_cast<float>(x));
}

// Cones are wider by what their axes and cosines lose in 16 bits.
constexpr double kConeSlack = 4e-4;

class Builder {
public:
    explicit Builder(std::span<const EmitterBounds> emitters)
        : order_(emitters.size()),
          words_(shared::emitterTreeRoot(static_cast<uint32_t>(emitters.size())), glm::uvec4(0))
    {
        bounds_.reserve(emitters.size());
        for (const EmitterBounds& e : emitters) bounds_.push_back(boundsOf(e));
        std::iota(order_.begin(), order_.end(), 0u);
    }

    std::vector<glm::uvec4> build()
    {
        makeNode(0, static_cast<uint32_t>(order_.size()), 0, 0);
        return std::move(words_);
    }

private:
    /// Emitters [begin, end) of the order.
    struct Part {
        uint32_t begin = 0, end = 0;
        Bounds bounds;

        uint32_t size() const { return end - begin; }
    };

    Part partOf(uint32_t begin, uint32_t end) const
    {
        Part part{begin, end, {}};
        for (uint32_t i = begin; i < end; ++i) part.bounds.add(bounds_[order_[i]]);
        return part;
    }

    /// Makes the node of emitters [begin, end) of the order, at least two; returns where its words
    /// begin. Whichever child is worth most to be known in parts is split, until there are four.
    uint32_t makeNode(uint32_t begin, uint32_t end, uint32_t depth, uint32_t trail)
    {
        // Halving from here on must still end within the trail's bits.
        const bool even = end - begin > 1ull << 2 * (kMaxTreeDepth - depth - 1);
        std::array<Part, 4> parts{partOf(begin, end)};
        size_t count = 1;
        for (; count < parts.size(); ++count) {
            Part* widest = nullptr;
            double most = -1;
            for (size_t i = 0; i < count; ++i) {
                const double worth = even ? parts[i].size() : cost(parts[i].bounds);
                if (parts[i].size() < 2 || !(worth > most)) continue;
                most = worth;
                widest = &parts[i];
            }
            if (widest == nullptr) break;
            const uint32_t first = widest->begin, last = widest->end,
                           middle = split(first, last, even);
            *widest = partOf(first, middle);
            parts[count] = partOf(middle, last);
        }
        const auto word = static_cast<uint32_t>(words_.size());
        words_.resize(words_.size() + shared::kEmitterNodeWords, glm::uvec4(0));
        for (uint32_t lane = 0; lane < count; ++lane) {
            const uint32_t way = trail | (lane << 2 * depth);
            pack(parts[lane].bounds, word, lane);
            const uint32_t link = linkTo(parts[lane], depth, way);
            words_[word + 8][static_cast<int>(lane)] = link;
        }
        return word;
    }

    uint32_t linkTo(const Part& part, uint32_t depth, uint32_t trail)
    {
        if (part.size() > 1) return makeNode(part.begin, part.end, depth + 1, trail);
        const uint32_t emitter = order_[part.begin];
        words_[emitter / 4][static_cast<int>(emitter % 4)] = trail;
        return shared::kEmitterLeaf | emitter;
    }

    void pack(const Bounds& b, uint32_t word, uint32_t child)
    {
        const auto lane = static_cast<int>(child);
        const glm::dvec3 centre = 0.5 * (b.low + b.high);
        const vec3 c(centre);
        // From the centre as stored, and outwards by more than what is lost where it is read.
        const double radius =
            glm::distance(glm::dvec3(c), b.high) * (1 + 1e-6) + 1e-7 * glm::length(centre) + 1e-20;
        for (int k = 0; k < 3; ++k)
            words_[word + static_cast<uint32_t>(k)][lane] = std::bit_cast<uint32_t>(c[k]);
        words_[word + 3][lane] = bitsOf(radius);
        const glm::dvec3& axis = b.normals.axis;
        const uint32_t cosNormals =
            packSnormDown(std::cos(std::min(b.normals.angle + kConeSlack, pi)));
        const double cosine = static_cast<int16_t>(cosNormals) / 32767.0;
        // Never zero: its sign says something.
        const double sine = std::max(std::sqrt(std::max(1 - cosine * cosine, 0.0)), 1e-4);
        words_[word + 4][lane] = packSnorm(axis.x) | (packSnorm(axis.y) << 16);
        words_[word + 5][lane] = packSnorm(axis.z) | (cosNormals << 16);
        words_[word + 6][lane] =
            packSnorm(b.bothFaces ? -sine : sine) |
            (packSnormDown(std::cos(std::min(b.emission + kConeSlack, pi))) << 16);
        words_[word + 7][lane] = bitsOf(b.intensity);
    }

    /// Reorders [begin, end); returns where the second half begins, in the middle if `even`.
    uint32_t split(uint32_t begin, uint32_t end, bool even)
    {
        const uint32_t count = end - begin, half = begin + count / 2;
        if (count == 2) return half;
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
        for (uint32_t i = begin; i < end; ++i) {
            low = glm::min(low, centre(order_[i]));
            high = glm::max(high, centre(order_[i]));
        }
        const Cut cut = even ? Cut{} : bestCut(begin, end, low, high);
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
    std::vector<glm::uvec4> words_;
};

}  // namespace

std::vector<glm::uvec4> makeEmitterTree(std::span<const EmitterBounds> emitters)
{
    CHECK(emitters.size() >= 2 && emitters.size() <= shared::kEmitterIndex);
    return Builder(emitters).build();
}

}  // namespace core

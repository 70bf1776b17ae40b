// Binned SAH for object and spatial splits; see bvh_split.h. Binning is parallel on large ranges:
// minima, maxima and counts do not depend on the order of work, so neither does the tree.
#include "core/trace/bvh_split.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace core::bvh {
namespace {

constexpr int kBins = 16;
constexpr size_t kParallelBinning = 1u << 15;
constexpr size_t kGrain = 1u << 13;

struct Bin {
    Box box;
    size_t count = 0;
};
using Bins = std::array<std::array<Bin, kBins>, 3>;

/// Bins for both kinds of split: spatial ones count where references begin and where they end.
struct SpatialBins {
    std::array<std::array<Box, kBins>, 3> box;
    std::array<std::array<size_t, kBins>, 3> enter{}, leave{};
};

Float4 splat(float x)
{
    return Float4{x, x, x, x};
}

Float4 load(const glm::vec3& v)
{
    return Float4{v.x, v.y, v.z, 0};
}

/// Fewer bins for few references: their evaluation would cost more than it finds.
int binCountFor(size_t references)
{
    return references <= 16 ? 8 : kBins;
}

/// Maps a doubled centroid to bins, all axes at once; flat axes map to bin 0.
struct BinMap {
    Float4 origin, scale;

    BinMap(const Box& centroids, int bins) : origin(centroids.low), scale(splat(0))
    {
        for (int a = 0; a < 3; ++a) {
            const float extent = centroids.high[a] - centroids.low[a];
            const float s = 0.9999f * static_cast<float>(bins) / extent;
            if (extent > 0 && std::isfinite(s)) scale[a] = s;
        }
    }
    Int4 operator()(Float4 centroid) const
    {
        return __builtin_convertvector((centroid - origin) * scale, Int4);
    }
};

void binObjects(Bins& bins, std::span<const Reference> references, const BinMap& map)
{
    for (const Reference& r : references) {
        const Int4 b = map(r.centroidTwice());
        const Box box = r.box();
        for (size_t a = 0; a < 3; ++a) {
            Bin& bin = bins[a][static_cast<size_t>(b[a])];
            bin.box.grow(box);
            ++bin.count;
        }
    }
}

void merge(Bins& into, const Bins& from, int count)
{
    for (size_t a = 0; a < 3; ++a) {
        for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
            into[a][i].box.grow(from[a][i].box);
            into[a][i].count += from[a][i].count;
        }
    }
}

/// Sweeps one axis: `box(i)`, `leftOf(i)` and `rightOf(i)` are a bin's bounds and how many
/// references it adds to the left side when it lies there, or to the right side. Improves `best`;
/// true if it did.
template <class BoxOf, class LeftOf, class RightOf>
bool sweep(int bins, const BoxOf& box, const LeftOf& leftOf, const RightOf& rightOf, Split& best)
{
    std::array<Box, kBins> right;
    std::array<size_t, kBins> rightCount{};
    Box grown;
    size_t count = 0;
    for (int i = bins - 1; i > 0; --i) {
        grown.grow(box(static_cast<size_t>(i)));
        count += rightOf(static_cast<size_t>(i));
        right[static_cast<size_t>(i)] = grown;
        rightCount[static_cast<size_t>(i)] = count;
    }
    Box left;
    count = 0;
    bool improved = false;
    for (int i = 1; i < bins; ++i) {
        const size_t k = static_cast<size_t>(i);
        left.grow(box(k - 1));
        count += leftOf(k - 1);
        if (count == 0 || rightCount[k] == 0) continue;
        const float cost = left.halfArea() * static_cast<float>(count) +
                           right[k].halfArea() * static_cast<float>(rightCount[k]);
        if (cost < best.cost) {
            best.cost = cost;
            best.bin = i;
            best.left = left;
            best.right = right[k];
            best.leftCount = count;
            best.rightCount = rightCount[k];
            improved = true;
        }
    }
    return improved;
}

/// Parallel only where it pays: `body(bins, part)` over parts of the references.
template <class T, class Body, class Merge>
T reduceOver(std::span<const Reference> references, const Body& body, const Merge& mergeInto)
{
    T total{};
    if (references.size() < kParallelBinning) {
        body(total, references);
        return total;
    }
    return tbb::parallel_reduce(
        tbb::blocked_range<size_t>(0, references.size(), kGrain), T{},
        [&](const tbb::blocked_range<size_t>& part, T value) {
            body(value, references.subspan(part.begin(), part.size()));
            return value;
        },
        [&](T a, const T& b) {
            mergeInto(a, b);
            return a;
        });
}

/// The spatial bins' geometry on one axis.
struct Slabs {
    float low = 0, width = 0, scale = 0;

    Slabs(const Box& bounds, int axis)
    {
        low = bounds.low[axis];
        width = (bounds.high[axis] - low) / static_cast<float>(kBins);
        const float s = 1.0f / width;
        scale = width > 0 && std::isfinite(s) ? s : 0.0f;
    }
    int binOf(float x) const
    {
        return std::clamp(static_cast<int>((x - low) * scale), 0, kBins - 1);
    }
    float plane(int i) const { return low + width * static_cast<float>(i); }
};

void binSpace(SpatialBins& bins, const Mesh& mesh, std::span<const Reference> references,
              const std::array<Slabs, 3>& slabs)
{
    for (const Reference& r : references) {
        for (int axis = 0; axis < 3; ++axis) {
            const size_t a = static_cast<size_t>(axis);
            if (!(slabs[a].scale > 0)) continue;
            const int first = slabs[a].binOf(r.low[axis]);
            const int last = std::max(first, slabs[a].binOf(r.high[axis]));
            ++bins.enter[a][static_cast<size_t>(first)];
            ++bins.leave[a][static_cast<size_t>(last)];
            if (first == last) {
                bins.box[a][static_cast<size_t>(first)].grow(r.box());
                continue;
            }
            for (int i = first; i <= last; ++i) {
                const float low = i == first ? -kHuge : slabs[a].plane(i);
                const float high = i == last ? kHuge : slabs[a].plane(i + 1);
                bins.box[a][static_cast<size_t>(i)].grow(
                    clipTriangle(mesh, r.triangle(), r.box(), axis, low, high));
            }
        }
    }
}

}  // namespace

Box boundsOf(const Mesh& mesh, uint32_t triangle)
{
    const WorldTriangle& t = mesh.triangles[triangle];
    Box box;
    for (const uint32_t v : {t.v0, t.v1, t.v2}) box.grow(load(mesh.positions[v]));
    return box;
}

RangeBounds boundsOf(std::span<const Reference> references)
{
    return reduceOver<RangeBounds>(
        references,
        [](RangeBounds& bounds, std::span<const Reference> part) {
            for (const Reference& r : part) bounds.grow(r);
        },
        [](RangeBounds& a, const RangeBounds& b) { a.grow(b); });
}

Split findObjectSplit(std::span<const Reference> references, const RangeBounds& bounds)
{
    const int count = binCountFor(references.size());
    const BinMap map(bounds.centroids, count);
    const Bins bins = reduceOver<Bins>(
        references, [&](Bins& b, std::span<const Reference> part) { binObjects(b, part, map); },
        [count](Bins& a, const Bins& b) { merge(a, b, count); });
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(map.scale[axis] > 0)) continue;
        const auto& lane = bins[static_cast<size_t>(axis)];
        const auto countOf = [&](size_t i) { return lane[i].count; };
        if (sweep(
                count, [&](size_t i) -> const Box& { return lane[i].box; }, countOf, countOf,
                best)) {
            best.axis = axis;
            best.origin = map.origin[axis];
            best.scale = map.scale[axis];
        }
    }
    return best;
}

Split findSpatialSplit(const Mesh& mesh, std::span<const Reference> references, const Box& bounds)
{
    const std::array<Slabs, 3> slabs{Slabs(bounds, 0), Slabs(bounds, 1), Slabs(bounds, 2)};
    const SpatialBins bins = reduceOver<SpatialBins>(
        references,
        [&](SpatialBins& b, std::span<const Reference> part) { binSpace(b, mesh, part, slabs); },
        [](SpatialBins& a, const SpatialBins& b) {
            for (size_t axis = 0; axis < 3; ++axis) {
                for (size_t i = 0; i < kBins; ++i) {
                    a.box[axis][i].grow(b.box[axis][i]);
                    a.enter[axis][i] += b.enter[axis][i];
                    a.leave[axis][i] += b.leave[axis][i];
                }
            }
        });
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        const size_t a = static_cast<size_t>(axis);
        if (!(slabs[a].scale > 0)) continue;
        if (sweep(
                kBins, [&](size_t i) -> const Box& { return bins.box[a][i]; },
                [&](size_t i) { return bins.enter[a][i]; },
                [&](size_t i) { return bins.leave[a][i]; }, best)) {
            best.axis = axis;
            best.plane = slabs[a].plane(best.bin);
        }
    }
    return best;
}

size_t partitionObjects(std::span<Reference> references, const Split& split, RangeBounds& left,
                        RangeBounds& right)
{
    const auto isLeft = [&](const Reference& r) {
        return static_cast<int>((r.centroidTwice()[split.axis] - split.origin) * split.scale) <
               split.bin;
    };
    size_t l = 0, r = references.size();
    while (true) {
        while (l < r && isLeft(references[l])) left.grow(references[l++]);
        while (l < r && !isLeft(references[r - 1])) right.grow(references[--r]);
        if (l == r) return l;
        std::swap(references[l], references[r - 1]);
    }
}

size_t partitionSpace(const Mesh& mesh, std::span<Reference> all, Range& range, const Split& split,
                      RangeBounds& left, RangeBounds& right)
{
    // First those on one side only; what is across gathers between them.
    size_t l = range.begin, across = range.begin, r = range.end;
    while (across < r) {
        Reference& x = all[across];
        if (x.high[split.axis] <= split.plane) {
            left.grow(x);
            std::swap(x, all[l++]);
            ++across;
        } else if (x.low[split.axis] >= split.plane) {
            right.grow(x);
            std::swap(x, all[--r]);
        } else {
            ++across;
        }
    }
    // Each of the others is cut, or goes whole to the side where that costs less (Stich et
    // al., 4.4).
    float leftCount = static_cast<float>(split.leftCount),
          rightCount = static_cast<float>(split.rightCount);
    size_t i = l;
    while (i < r) {
        Reference& x = all[i];
        const Box leftPart =
            clipTriangle(mesh, x.triangle(), x.box(), split.axis, -kHuge, split.plane);
        const Box rightPart =
            clipTriangle(mesh, x.triangle(), x.box(), split.axis, split.plane, kHuge);
        Box leftWhole = split.left, rightWhole = split.right;
        leftWhole.grow(x.box());
        rightWhole.grow(x.box());
        const float a = split.left.halfArea(), b = split.right.halfArea();
        float cut = a * leftCount + b * rightCount;
        const float wholeLeft = leftWhole.halfArea() * leftCount + b * (rightCount - 1);
        const float wholeRight = a * (leftCount - 1) + rightWhole.halfArea() * rightCount;
        if (range.room() == 0) cut = kHuge;
        const bool toLeft =
            rightPart.empty() || (!leftPart.empty() && wholeLeft <= wholeRight && wholeLeft < cut);
        const bool toRight = !toLeft && (leftPart.empty() || wholeRight < cut);
        if (toLeft) {
            rightCount -= 1;
            left.grow(x);
            ++i;
        } else if (toRight) {
            leftCount -= 1;
            right.grow(x);
            std::swap(x, all[--r]);
        } else {
            const Reference rightRef = Reference::make(rightPart, x.triangle());
            x = Reference::make(leftPart, x.triangle());
            left.grow(x);
            right.grow(rightRef);
            all[range.end++] = rightRef;
            ++i;
        }
    }
    return r;
}

size_t partitionMedian(std::span<Reference> references, const RangeBounds& bounds,
                       RangeBounds& left, RangeBounds& right)
{
    const Float4 extent = bounds.centroids.high - bounds.centroids.low;
    const int axis =
        extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : (extent[1] >= extent[2] ? 1 : 2);
    const size_t middle = references.size() / 2;
    std::nth_element(references.begin(), references.begin() + static_cast<std::ptrdiff_t>(middle),
                     references.end(), [axis](const Reference& a, const Reference& b) {
                         const float ca = a.centroidTwice()[axis], cb = b.centroidTwice()[axis];
                         return ca != cb ? ca < cb : a.triangle() < b.triangle();
                     });
    left = boundsOf(references.first(middle));
    right = boundsOf(references.subspan(middle));
    return middle;
}

Box clipTriangle(const Mesh& mesh, uint32_t triangle, const Box& box, int axis, float low,
                 float high)
{
    const WorldTriangle& t = mesh.triangles[triangle];
    const std::array<Float4, 3> v{load(mesh.positions[t.v0]), load(mesh.positions[t.v1]),
                                  load(mesh.positions[t.v2])};
    Box part;
    for (size_t i = 0; i < 3; ++i) {
        const Float4 a = v[i], b = v[i == 2 ? 0 : i + 1];
        const float pa = a[axis], pb = b[axis];
        if (pa >= low && pa <= high) part.grow(a);
        for (const float plane : {low, high}) {
            if ((pa < plane) == (pb < plane) || pa == plane) continue;
            Float4 p = a + (b - a) * splat((plane - pa) / (pb - pa));
            p[axis] = plane;
            part.grow(p);
        }
    }
    if (part.empty()) return part;
    // The intersections are rounded: a few units in the last place of the largest coordinate cover
    // that.
    float magnitude = 0;
    for (int i = 0; i < 3; ++i)
        magnitude = std::max({magnitude, std::abs(part.low[i]), std::abs(part.high[i])});
    const float pad = 4.0f * 1.2e-7f * magnitude;
    part.low = part.low - splat(pad);
    part.high = part.high + splat(pad);
    Box inside = intersection(part, box);
    inside.low[axis] = std::max(inside.low[axis], std::max(low, box.low[axis]));
    inside.high[axis] = std::min(inside.high[axis], std::min(high, box.high[axis]));
    return inside;
}

}  // namespace core::bvh

// Finding splits by binned SAH; see bvh_split.h. Binning is parallel on large ranges:
// minima, maxima and counts do not depend on the order of work, so neither does the tree.
#include "core/trace/bvh_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"

namespace core::bvh {
namespace {

constexpr size_t kParallelBinning = 1u << 15;
constexpr size_t kGrain = 1u << 13, kMostParts = 64;

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
    const size_t grain = std::max(kGrain, references.size() / kMostParts + 1);
    std::vector<T> parts((references.size() + grain - 1) / grain);
    parallelFor(references.size(), grain, [&](size_t begin, size_t end) {
        body(parts[begin / grain], references.subspan(begin, end - begin));
    });
    for (const T& part : parts) mergeInto(total, part);
    return total;
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

Box boundsOf(const Mesh& mesh, uint32_t number)
{
    if (const InstanceLeaf* instance = mesh.instance(number)) return instance->box;
    const WorldTriangle& t = mesh.triangles[number];
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

/// Improves a split by size or reach, of which all but the bin is known.
static Split bestScaleSplit(std::span<const Reference> references, Split best)
{
    using Scales = std::array<Bin, kBins>;
    const Scales scales = reduceOver<Scales>(
        references,
        [&](Scales& bins, std::span<const Reference> part) {
            for (const Reference& r : part) {
                Bin& bin = bins[static_cast<size_t>(scaleBin(r, best))];
                bin.box.grow(r.box());
                ++bin.count;
            }
        },
        [](Scales& a, const Scales& b) {
            for (size_t i = 0; i < kBins; ++i) {
                a[i].box.grow(b[i].box);
                a[i].count += b[i].count;
            }
        });
    const auto countOf = [&](size_t i) { return scales[i].count; };
    const auto boxOf = [&](size_t i) -> const Box& { return scales[i].box; };
    if (sweep(kBins, boxOf, countOf, countOf, best)) best.axis = 0;
    return best;
}

Split findSizeSplit(std::span<const Reference> references, const RangeBounds& bounds)
{
    Split split;
    split.kind = SplitKind::size;
    split.largest = exponentOf(bounds.box.extent());
    return bestScaleSplit(references, split);
}

/// The median of some of the centroids, axis by axis.
static Float4 medianOf(std::span<const Reference> references)
{
    constexpr size_t kMost = 4096;
    const size_t step = references.size() / kMost + 1;
    Float4 median{};
    std::vector<float> places;
    for (int a = 0; a < 3; ++a) {
        places.clear();
        for (size_t i = 0; i < references.size(); i += step)
            places.push_back(0.5f * references[i].centroidTwice()[a]);
        const auto middle = places.begin() + static_cast<ptrdiff_t>(places.size() / 2);
        std::nth_element(places.begin(), middle, places.end());
        median[a] = *middle;
    }
    return median;
}

Split findReachSplit(std::span<const Reference> references, const RangeBounds& bounds)
{
    Split split;
    split.kind = SplitKind::reach;
    split.centre = medianOf(references);
    split.largest = exponentOf(reachOf(bounds.box, split.centre));
    return bestScaleSplit(references, split);
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
            best.kind = SplitKind::space;
            best.axis = axis;
            best.plane = slabs[a].plane(best.bin);
        }
    }
    return best;
}

}  // namespace core::bvh

// Carrying out splits; see bvh_split.h.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/trace/bvh_split.h"

namespace core::bvh {

size_t partitionObjects(std::span<Reference> references, const Split& split, RangeBounds& left,
                        RangeBounds& right)
{
    const auto isLeft = [&](const Reference& r) {
        if (split.kind != SplitKind::centroid) return scaleBin(r, split) < split.bin;
        const float place = (r.centroidTwice()[split.axis] - split.origin) * split.scale;
        return static_cast<int>(place) < split.bin;
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
            Float4 p = a + (b - a) * ((plane - pa) / (pb - pa));
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
    part.low = part.low - pad;
    part.high = part.high + pad;
    Box inside = intersection(part, box);
    inside.low[axis] = std::max(inside.low[axis], std::max(low, box.low[axis]));
    inside.high[axis] = std::min(inside.high[axis], std::min(high, box.high[axis]));
    return inside;
}

}  // namespace core::bvh

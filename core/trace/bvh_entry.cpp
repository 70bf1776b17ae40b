// Where rays begin in a hierarchy whose root leads to something far smaller; see BvhEntry.
#include "core/trace/bvh.h"
#include "core/trace/bvh_grid.h"

namespace core {
namespace {

using bvh::Box;
using bvh::Grid;
using shared::uvec4;

bool meet(const uvec4& a, const uvec4& b)
{
    bool all = true;
    for (int k = 0; k < 3; ++k)
        all = all && (a[k] & 0xffffu) <= b[k] >> 16 && (b[k] & 0xffffu) <= a[k] >> 16;
    return all;
}

/// Whether the box of a leaf below a record meets `cells` of the same grid. What lies on yet
/// another grid, or in another space, counts as a leaf.
bool leafMeets(const Bvh& bvh, const uvec4& record, const uvec4& cells)
{
    if (!meet(record, cells)) return false;
    if ((record.w & shared::kBvhLeaf) != 0) return true;
    const uvec4* children = bvh.node(record.w);
    return leafMeets(bvh, children[0], cells) || leafMeets(bvh, children[1], cells);
}

/// Whether a reference leads to a finer grid in the same space.
bool leadsToFiner(const Bvh& bvh, uint32_t reference)
{
    return bvh::changesGrid(reference) &&
           bvh.node(reference & shared::kBvhIndexMask)[1].w == shared::kBvhDone;
}

}  // namespace

shared::BvhEntry entryOf(const Bvh& bvh)
{
    shared::BvhEntry entry{};
    entry.gridLow = entry.outerLow = bvh.gridLow;
    entry.gridScale = entry.outerScale = bvh.gridScale;
    entry.way = shared::kBvhDone;
    const uvec4* root = bvh.node(0);
    const bool isOver = root[0].w == root[1].w && (root[0].w & shared::kBvhLeaf) == 0;
    if (isOver) root = bvh.node(root[0].w);  // instances have trees before it
    const int part = leadsToFiner(bvh, root[0].w) ? 0 : 1;
    // Of what moves, records change with the pose, and an entry is for all poses.
    if (!bvh.moving.nodes.empty() || root[0].w == root[1].w || !leadsToFiner(bvh, root[part].w))
        return entry;
    const uint32_t change = root[part].w & shared::kBvhIndexMask;
    const uvec4* there = bvh.node(change);
    entry.gridLow = bvh::vectorIn(there[0]);
    entry.gridScale = bvh::vectorIn(there[1]);
    entry.node = there[0].w;
    entry.way = bvh::gridReference(change + 1);
    entry.surroundings = root[1 - part];
    const glm::vec3 high = entry.gridLow + 65535.0f / entry.gridScale;
    const Box whole{bvh::load(entry.gridLow), bvh::load(high)};
    const Grid outer(bvh.gridLow, bvh.gridScale);
    entry.apart = leafMeets(bvh, entry.surroundings, outer.record(whole, 0)) ? 0 : 1;
    return entry;
}

}  // namespace core

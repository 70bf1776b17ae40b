// See lightcuts.h.
#include "core/many_lights/lightcuts.h"

#include <algorithm>

#include "core/base/time.h"
#include "core/many_lights/sphere_bound.h"
#include "core/trace/scene_view.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr uint32_t kTogether = 8;  // nodes of one receiver that are split at once

struct Below {
    bool operator()(const CutEntry& a, const CutEntry& b) const
    {
        return a.bound < b.bound || (a.bound == b.bound && a.node > b.node);
    }
};

}  // namespace

bool LightcutGroup::run(SliceRows& rows, IndexRange range, const std::stop_token& stop)
{
    weights_.resize(rows.count());
    rays_ = 0;
    for (uint32_t k = 0; k < range.size(); ++k) {
        State& state = states_[k];
        state.row = range.begin + k;
        state.query = rows.queryAt(state.row, job_.gather);
        state.cut.clear();
        state.open = 0;
        state.total = 0;
        for (uint32_t kind = 0; kind < kLightKinds; ++kind) {
            const uint32_t root = tree_.roots[kind];
            if (root == shared::kNone) continue;
            const auto kindOf = static_cast<LightKind>(kind);
            ask(rows, k, root, kindOf, boundOf(rows, state, root, kindOf));
        }
    }
    for (bool going = true; going;) {
        if (stop.stop_requested()) return false;
        answer(rows);
        going = false;
        for (uint32_t k = 0; k < range.size(); ++k) going = split(rows, k) || going;
    }
    return true;
}

/// Splits the nodes that may err the most; false where none may err too much.
bool LightcutGroup::split(SliceRows& rows, uint32_t k)
{
    State& state = states_[k];
    const double most = double(error_) * state.total;
    std::array<CutEntry, kTogether> tops;
    uint32_t count = 0;
    size_t size = state.cut.size();
    while (count < kTogether && state.open > 0 &&
           size<clusters_&& double(state.cut.front().bound)> most) {
        const auto begin = state.cut.begin(), end = begin + static_cast<std::ptrdiff_t>(state.open);
        std::pop_heap(begin, end, Below{});
        tops[count++] = state.cut[--state.open];
        state.cut[state.open] = state.cut.back();
        state.cut.pop_back();
        ++size;  // what the cut will have once two children stand for it
    }
    for (uint32_t i = 0; i < count; ++i) {
        const CutEntry& top = tops[i];
        const LightNode& node = tree_.nodes[top.node];
        state.total -= double(shared::luminance(top.unit)) * double(node.importance);
        for (const uint32_t child : {top.node + 1, node.right}) {
            const float bound = boundOf(rows, state, child, top.kind);
            if (tree_.nodes[child].representative == node.representative)
                insert(state, {bound, child, top.kind, top.unit});
            else
                ask(rows, k, child, top.kind, bound);
        }
    }
    return count > 0;
}

/// Has the representative of a node seen.
void LightcutGroup::ask(const SliceRows& rows, uint32_t k, uint32_t node, LightKind kind,
                        float bound)
{
    const uint32_t light = tree_.nodes[node].representative;
    const VirtualLight& of = job_.lights->lights[light];
    const uint32_t row = states_[k].row;
    Pending pending{k,
                    {bound, node, kind, vec3(0)},
                    columnOf(of, 1 / of.importance, light, job_.receivers.frame),
                    0,
                    0};
    rows.weigh(pending.column, job_.gather, {row, row + 1}, weights_);
    pending.weight = weights_[row];
    pending_.push_back(pending);
}

void LightcutGroup::answer(SliceRows& rows)
{
    ShadowPackets packets(*job_.receivers.accel, rows);
    for (Pending& p : pending_) {
        if (!(p.weight > 0)) continue;
        packets.add(ShadowTarget(p.column), states_[p.state].row, &p.visible, 1);
        ++rays_;
    }
    packets.flush();
    for (Pending& p : pending_) {
        State& state = states_[p.state];
        if (p.visible != 0) {
            const IndexRange row{state.row, state.row + 1};
            weights_[state.row] = p.weight;
            rows.clear(row);
            rows.add(p.column, *job_.lights, row, weights_);
            p.entry.unit = rows.radiance(state.row);
        }
        insert(state, p.entry);
    }
    pending_.clear();
}

void LightcutGroup::insert(State& state, const CutEntry& entry)
{
    const LightNode& node = tree_.nodes[entry.node];
    state.total += double(shared::luminance(entry.unit)) * double(node.importance);
    state.cut.push_back(entry);
    if (node.isLeaf() || !(entry.bound > 0)) return;
    std::swap(state.cut[state.open], state.cut.back());
    ++state.open;
    std::push_heap(state.cut.begin(), state.cut.begin() + static_cast<std::ptrdiff_t>(state.open),
                   Below{});
}

float LightcutGroup::boundOf(const SliceRows& rows, const State& state, uint32_t index,
                             LightKind kind) const
{
    const LightNode& node = tree_.nodes[index];
    if (node.isLeaf()) return 0;  // it is exact
    const float response = rows.largestResponse(state.row, node, kind);
    const float loose =
        response * sphereBound(node, kind, state.query.position, 0, state.query.clampDistance);
    // What is small enough by any bound needs no other.
    if (double(loose) <= double(error_) * state.total) return loose;
    return response * clusterBound(node, kind, state.query);
}

vec3 LightcutGroup::radiance(uint32_t k) const
{
    vec3 sum(0);
    for (const CutEntry& entry : states_[k].cut)
        sum += entry.unit * tree_.nodes[entry.node].importance;
    return sum;
}

bool Lightcuts::light(const SliceJob& job, std::span<const Receiver> receivers,
                      std::span<const uint32_t> chosen, uint32_t, const std::stop_token& stop,
                      std::span<vec3> radiance, SliceStats& stats) const
{
    const Clock::time_point start = Clock::now();
    static thread_local SliceRows rows;
    rows.reset(sceneView(job.receivers.accel->world()), receivers, chosen);
    LightcutGroup group(job, tree_, clusters_, error_);
    uint64_t pairs = 0, rays = 0;
    for (uint32_t begin = 0; begin < rows.count(); begin += LightcutGroup::kRows) {
        const uint32_t end = std::min(begin + LightcutGroup::kRows, rows.count());
        if (!group.run(rows, {begin, end}, stop)) return false;
        for (uint32_t k = 0; k < end - begin; ++k) {
            radiance[begin + k] = group.radiance(k);
            pairs += group.cut(k).size();
        }
        rays += group.rays();
    }
    countPairs(stats, chosen.size(), pairs, rays);
    stats.shadingSeconds += secondsSince(start);
    return true;
}

}  // namespace core::many_lights

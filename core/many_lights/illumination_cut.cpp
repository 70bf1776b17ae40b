// See illumination_cut.h.
#include "core/many_lights/illumination_cut.h"

#include <algorithm>
#include <array>

#include "core/base/time.h"
#include "core/completion/row_weights.h"
#include "core/completion/visibility_sampling.h"
#include "core/many_lights/pixel_tree.h"
#include "core/many_lights/shadow_packets.h"
#include "core/many_lights/sphere_bound.h"
#include "core/trace/scene_view.h"

namespace core::many_lights {

namespace {

using glm::vec3;

// Of pairs in the first pass: radius over distance, and cosine of half the cone of their lights.
// The authors' .03 and .99 make it cost more than the second one, without better pictures.
constexpr float kSeparation = 0.1f;
constexpr float kParallel = 0.9f;
constexpr float kDarkest = 0.01f;  // of the mean of a slice: what its darkest receivers count as
// Where the first pass sees next to nothing of what a slice would get with nothing in between,
// receivers count as if they got this part of that: an error in proportion to nothing would make
// the second pass ask for every light by itself.
constexpr double kUnlit = 0.2, kNextToNothing = 1e-3;
constexpr size_t kBatch = 4096;  // rays of the first pass, receivers of the second

/// A node of receivers and a node of lights.
struct Pair {
    uint32_t pixels, lights;
    LightKind kind;
};

/// Lights one slice after the other; keeps its memory.
class SliceCut {
public:
    bool run(const SliceJob& job, const LightTree& tree, float error,
             std::span<const Receiver> receivers, std::span<const uint32_t> chosen, uint32_t slice,
             const std::stop_token& stop, std::span<vec3> radiance, SliceStats& stats)
    {
        job_ = &job;
        tree_ = &tree;
        pixels_.build(receivers, chosen);
        rows_.reset(sceneView(job.receivers.accel->world()), receivers, pixels_.order());
        pixels_.bound(rows_, job.gather);
        weights_.assign(rows_.count(), 0);
        rays_ = entries_ = 0;
        open_ = 0;
        forget();
        Pcg32 random(frameSeed(job.receivers), slice);
        if (!approximate(random, stop)) return false;
        makeThresholds(error);
        rows_.clear({0, rows_.count()});
        if (!refine(stop)) return false;
        for (uint32_t row = 0; row < rows_.count(); ++row)
            radiance[pixels_.places()[row]] = rows_.radiance(row);
        countPairs(stats, chosen.size(), entries_, rays_);
        return true;
    }

private:
    /// A pair of the first pass: its light as one of its receivers sees it.
    struct Probe {
        uint32_t pixels, row;
        Column column;
        float weight;
        uint64_t visible;
    };
    /// A pair of the second pass; its receivers that face the light stand in `lit_`.
    struct Accepted {
        IndexRange rows;
        Column column;
        uint32_t begin, end;  // of lit_
        uint32_t sequence;    // of sampling_
    };
    struct LitRow {
        uint32_t row;
        float weight;
    };

    bool approximate(Pcg32& random, const std::stop_token& stop);
    bool separated(const PixelNode& p, const LightNode& l, LightKind kind) const;
    void probe(const Pair& pair, Pcg32& random);
    void finishProbes();
    void makeThresholds(float error);
    bool refine(const std::stop_token& stop);
    static LightNode enlarged(const PixelNode& p, const LightNode& l);
    float bound(const PixelNode& p, const Pair& pair) const;
    float responseOf(const PixelNode& p, const Pair& pair) const;
    void accept(const Pair& pair);
    void finishAccepted();

    /// Drops what a slice that was given up has left behind.
    void forget()
    {
        probes_.clear();
        accepted_.clear();
        lit_.clear();
        sampling_.clear();
    }
    void pushRoots();
    void splitPixels(const Pair& pair)
    {
        waiting_.push_back({pixels_.nodes()[pair.pixels].right, pair.lights, pair.kind});
        waiting_.push_back({pair.pixels + 1, pair.lights, pair.kind});
    }
    void splitLights(const Pair& pair)
    {
        waiting_.push_back({pair.pixels, tree_->nodes[pair.lights].right, pair.kind});
        waiting_.push_back({pair.pixels, pair.lights + 1, pair.kind});
    }
    Column representative(const LightNode& node) const
    {
        const VirtualLight& light = job_->lights->lights[node.representative];
        return columnOf(light, node.importance / light.importance, node.representative,
                        job_->receivers.frame);
    }

    const SliceJob* job_ = nullptr;
    const LightTree* tree_ = nullptr;
    PixelTree pixels_;
    SliceRows rows_;
    std::vector<float> weights_;
    std::vector<Pair> waiting_;
    std::vector<Probe> probes_;
    std::vector<double> rough_;      // what the first pass finds, by node
    double open_ = 0;                // the mean of that over the slice if all lights were seen
    std::vector<float> thresholds_;  // what a pair may err, by node
    std::vector<Accepted> accepted_;
    std::vector<LitRow> lit_;
    VisibilitySampling sampling_;
    uint64_t rays_ = 0, entries_ = 0;
};

void SliceCut::pushRoots()
{
    waiting_.clear();
    if (pixels_.nodes().empty()) return;
    for (uint32_t kind = 0; kind < kLightKinds; ++kind)
        if (tree_->roots[kind] != shared::kNone)
            waiting_.push_back({0, tree_->roots[kind], static_cast<LightKind>(kind)});
}

/// The first pass: pairs that are far apart for their sizes, a ray each.
bool SliceCut::approximate(Pcg32& random, const std::stop_token& stop)
{
    rough_.assign(pixels_.nodes().size(), 0);
    size_t steps = 0;
    for (pushRoots(); !waiting_.empty();) {
        const Pair pair = waiting_.back();
        waiting_.pop_back();
        if (++steps % kBatch == 0 && stop.stop_requested()) return false;
        const PixelNode& p = pixels_.nodes()[pair.pixels];
        const LightNode& l = tree_->nodes[pair.lights];
        if ((p.isLeaf() && l.isLeaf()) || separated(p, l, pair.kind)) {
            probe(pair, random);
            if (probes_.size() >= kBatch) finishProbes();
        } else if (!l.isLeaf() && (p.isLeaf() || l.cosHalf <= kParallel ||
                                   sphereRadius(l, pair.kind) >= p.radius())) {
            splitLights(pair);
        } else {
            splitPixels(pair);
        }
    }
    finishProbes();
    for (uint32_t i = 0; i < rough_.size(); ++i) {
        if (pixels_.nodes()[i].isLeaf()) continue;
        rough_[i + 1] += rough_[i];
        rough_[pixels_.nodes()[i].right] += rough_[i];
    }
    return !stop.stop_requested();
}

bool SliceCut::separated(const PixelNode& p, const LightNode& l, LightKind kind) const
{
    if (!l.isLeaf() && l.cosHalf <= kParallel) return false;
    const float radius = p.radius();
    if (kind == LightKind::directional)
        return radius <= kSeparation * job_->receivers.accel->world().radius;
    const float lights = sphereRadius(l, kind);
    const float distance = glm::distance(p.query.position, 0.5f * (l.low + l.high));
    return kSeparation * (distance - lights - radius) > std::max(lights, radius);
}

void SliceCut::probe(const Pair& pair, Pcg32& random)
{
    const IndexRange& rows = pixels_.nodes()[pair.pixels].rows;
    const uint32_t row = rows.begin + drawBelow(rows.size(), random);
    Probe probe{pair.pixels, row, representative(tree_->nodes[pair.lights]), 0, 0};
    rows_.weigh(probe.column, job_->gather, {row, row + 1}, weights_);
    probe.weight = weights_[row];
    if (probe.weight > 0) probes_.push_back(probe);
}

void SliceCut::finishProbes()
{
    ShadowPackets packets(*job_->receivers.accel, rows_);
    for (Probe& p : probes_) packets.add(ShadowTarget(p.column), p.row, &p.visible, 1);
    packets.flush();
    rays_ += probes_.size();
    for (const Probe& p : probes_) {
        const IndexRange row{p.row, p.row + 1};
        weights_[p.row] = p.weight;
        rows_.clear(row);
        rows_.add(p.column, *job_->lights, row, weights_);
        const auto light = double(shared::luminance(rows_.radiance(p.row)));
        open_ += light * pixels_.nodes()[p.pixels].rows.size() / rows_.count();
        if (p.visible != 0) rough_[p.pixels] += light;
    }
    probes_.clear();
}

/// What pairs may err: a part of what the darkest of their receivers gets.
void SliceCut::makeThresholds(float error)
{
    double mean = 0;
    for (uint32_t i = 0; i < rough_.size(); ++i)
        if (pixels_.nodes()[i].isLeaf()) mean += rough_[i] / rows_.count();
    const double darkest =
        std::max(double(kDarkest) * mean, kUnlit * (open_ - mean / kNextToNothing));
    thresholds_.resize(rough_.size());
    for (size_t i = rough_.size(); i-- > 0;) {
        const PixelNode& node = pixels_.nodes()[i];
        thresholds_[i] = node.isLeaf() ? error * static_cast<float>(std::max(rough_[i], darkest))
                                       : std::min(thresholds_[i + 1], thresholds_[node.right]);
    }
}

/// The second pass.
bool SliceCut::refine(const std::stop_token& stop)
{
    size_t steps = 0;
    for (pushRoots(); !waiting_.empty();) {
        const Pair pair = waiting_.back();
        waiting_.pop_back();
        if (++steps % kBatch == 0 && stop.stop_requested()) return false;
        const PixelNode& p = pixels_.nodes()[pair.pixels];
        const LightNode& l = tree_->nodes[pair.lights];
        const float allowed = thresholds_[pair.pixels];
        // A light by itself is shaded exactly, so that nothing is gained by less receivers.
        bool small = l.isLeaf();
        if (!small) {
            const float response = responseOf(p, pair);
            small = response * sphereBound(l, pair.kind, p.query.position, p.radius(),
                                           job_->gather.clampDistance) <=
                    allowed;
            const float most = small ? allowed : response * bound(p, pair);
            if (!(most > 0)) continue;
            small = most <= allowed;
        }
        if (small) {
            accept(pair);
            if (lit_.size() >= kBatch) finishAccepted();
        } else if (p.isLeaf() || pair.kind == LightKind::directional ||
                   sphereRadius(l, pair.kind) >= p.radius()) {
            splitLights(pair);
        } else {
            splitPixels(pair);
        }
    }
    finishAccepted();
    return !stop.stop_requested();
}

/// The lights as seen from the middle of the receivers, if their box were larger by the receivers'.
LightNode SliceCut::enlarged(const PixelNode& p, const LightNode& l)
{
    LightNode node = l;
    const vec3 half = 0.5f * (p.high - p.low);
    node.low -= half;
    node.high += half;
    return node;
}

/// The most that the lights bring to any of the receivers if these were of albedo pi.
float SliceCut::bound(const PixelNode& p, const Pair& pair) const
{
    return clusterBound(enlarged(p, tree_->nodes[pair.lights]), pair.kind, p.query);
}

float SliceCut::responseOf(const PixelNode& p, const Pair& pair) const
{
    if (p.surface == ~0u) return p.albedo;
    const LightNode node = enlarged(p, tree_->nodes[pair.lights]);
    return std::max(p.albedo, rows_.largestResponse(p.surface, node, pair.kind));
}

void SliceCut::accept(const Pair& pair)
{
    const LightNode& l = tree_->nodes[pair.lights];
    Accepted a{pixels_.nodes()[pair.pixels].rows, representative(l), 0, 0, 0};
    entries_ += a.rows.size();
    rows_.weigh(a.column, job_->gather, a.rows, weights_);
    a.begin = static_cast<uint32_t>(lit_.size());
    for (uint32_t row = a.rows.begin; row < a.rows.end; ++row)
        if (weights_[row] > 0) lit_.push_back({row, weights_[row]});
    a.end = static_cast<uint32_t>(lit_.size());
    if (a.begin == a.end) return;
    a.sequence = sampling_.add(a.end - a.begin, l.isLeaf());
    accepted_.push_back(a);
}

void SliceCut::finishAccepted()
{
    ShadowPackets packets(*job_->receivers.accel, rows_);
    rays_ += sampling_.run(
        [&](uint32_t sequence, uint32_t i, uint64_t* word, uint64_t bit) {
            const Accepted& a = accepted_[sequence];
            packets.add(ShadowTarget(a.column), lit_[a.begin + i].row, word, bit);
        },
        [&] { packets.flush(); });
    for (const Accepted& a : accepted_) {
        const std::span<const uint64_t> visible = sampling_.visible(a.sequence);
        std::fill(weights_.begin() + a.rows.begin, weights_.begin() + a.rows.end, 0.0f);
        for (uint32_t i = a.begin; i < a.end; ++i)
            if (getBit(visible, i - a.begin)) weights_[lit_[i].row] = lit_[i].weight;
        rows_.add(a.column, *job_->lights, a.rows, weights_);
    }
    accepted_.clear();
    lit_.clear();
    sampling_.clear();
}

}  // namespace

bool IlluminationCut::light(const SliceJob& job, std::span<const Receiver> receivers,
                            std::span<const uint32_t> chosen, uint32_t slice,
                            const std::stop_token& stop, std::span<vec3> radiance,
                            SliceStats& stats) const
{
    const Clock::time_point start = Clock::now();
    static thread_local SliceCut cut;
    const bool whole = cut.run(job, tree_, error_, receivers, chosen, slice, stop, radiance, stats);
    stats.shadingSeconds += secondsSince(start);
    return whole;
}

}  // namespace core::many_lights

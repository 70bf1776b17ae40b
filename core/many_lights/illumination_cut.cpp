// See illumination_cut.h.
#include "core/many_lights/illumination_cut.h"

#include "core/base/time.h"
#include "core/many_lights/accepted_pairs.h"
#include "core/many_lights/dark_rows.h"
#include "core/many_lights/flat_lights.h"
#include "core/many_lights/rough_light.h"
#include "core/many_lights/slice_pairs.h"
#include "core/many_lights/sphere_bound.h"
#include "core/many_lights/whole_pairs.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr size_t kSteps = 4096;  // between looks at whether to stop

/// Lights one slice after the other; keeps its memory.
class SliceCut {
public:
    /// `nodeLights`: null where no pairs are taken as a whole.
    bool run(const SliceJob& job, const LightTree& tree, const NodeLights* nodeLights, float error,
             std::span<const Receiver> receivers, std::span<const uint32_t> chosen, uint32_t slice,
             const std::stop_token& stop, std::span<vec3> radiance, SliceStats& stats)
    {
        pairs_.reset(job, tree, receivers, chosen);
        accepted_.forget();
        SliceRows& rows = pairs_.rows;
        const bool takesWhole = nodeLights != nullptr && areFewFlatPieces(pairs_.pixels, rows);
        Pcg32 random(frameSeed(job.receivers), slice);
        if (!rough_.find(pairs_, takesWhole, random, stop)) return false;
        rows.clear({0, rows.count()});
        if (takesWhole) dark_.find(pairs_, rough_, random);
        rough_.thresholds(pairs_, error, thresholds_);
        if (!(takesWhole
                  ? whole_.run(pairs_, *nodeLights, thresholds_, dark_, accepted_, random, stop)
                  : refine(stop)))
            return false;
        for (uint32_t row = 0; row < rows.count(); ++row)
            radiance[pairs_.pixels.places()[row]] = rows.radiance(row);
        countPairs(stats, chosen.size(), pairs_.entries, pairs_.rays);
        return true;
    }

private:
    bool refine(const std::stop_token& stop);

    SlicePairs pairs_;
    RoughLight rough_;
    std::vector<float> thresholds_;  // what a pair may err, by node
    AcceptedPairs accepted_;
    DarkRows dark_;
    WholePairs whole_;
};

/// The second pass.
bool SliceCut::refine(const std::stop_token& stop)
{
    size_t steps = 0;
    for (pairs_.pushRoots(); !pairs_.waiting.empty();) {
        const Pair pair = pairs_.waiting.back();
        pairs_.waiting.pop_back();
        if (++steps % kSteps == 0 && stop.stop_requested()) return false;
        const PixelNode& p = pairs_.pixels.nodes()[pair.pixels];
        const LightNode& l = pairs_.tree->nodes[pair.lights];
        const float allowed = thresholds_[pair.pixels];
        // A light by itself is shaded exactly, so that nothing is gained by less receivers.
        bool small = l.isLeaf();
        if (!small) {
            const float response = pairs_.responseOf(p, pair);
            small = response * sphereBound(l, pair.kind, p.query.position, p.radius(),
                                           pairs_.job->gather.clampDistance) <=
                    allowed;
            const float most = small ? allowed : response * pairs_.bound(p, pair);
            if (!(most > 0)) continue;
            small = most <= allowed;
        }
        if (small)
            accepted_.add(pairs_, pair);
        else if (p.isLeaf() || pair.kind == LightKind::directional ||
                 sphereRadius(l, pair.kind) >= p.radius())
            pairs_.splitLights(pair);
        else
            pairs_.splitPixels(pair);
    }
    accepted_.finish(pairs_);
    return !stop.stop_requested();
}

}  // namespace

IlluminationCut::IlluminationCut(const LightTree& tree, float error) : tree_(tree), error_(error)
{
    if (lieInFewPlanes(tree)) nodeLights_.emplace(tree);
}

bool IlluminationCut::light(const SliceJob& job, std::span<const Receiver> receivers,
                            std::span<const uint32_t> chosen, uint32_t slice,
                            const std::stop_token& stop, std::span<vec3> radiance,
                            SliceStats& stats) const
{
    const Clock::time_point start = Clock::now();
    static thread_local SliceCut cut;
    const bool whole = cut.run(job, tree_, nodeLights_ ? &*nodeLights_ : nullptr, error_, receivers,
                               chosen, slice, stop, radiance, stats);
    stats.shadingSeconds += secondsSince(start);
    return whole;
}

}  // namespace core::many_lights

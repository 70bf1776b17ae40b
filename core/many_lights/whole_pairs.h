// The second pass of IlluminationCut in rooms of few planes: pairs that may err by far more than
// what is allowed are taken as a whole where samples of their receivers and lights agree that all
// see each other, or that none does. Light of pairs of which everything is seen is summed over
// nearly all their lights, for that costs a thirtieth of rays.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/pcg32.h"
#include "core/many_lights/accepted_pairs.h"
#include "core/many_lights/dark_rows.h"
#include "core/many_lights/pair_samples.h"
#include "core/many_lights/shadow_packets.h"
#include "core/many_lights/slice_pairs.h"

namespace core::many_lights {

/// Keeps its memory from slice to slice.
class WholePairs {
public:
    /// Adds all light to the rows. `thresholds`: what pairs may err, by node of receivers; the
    /// samples of a node include its darkest row. Returns false if it was stopped.
    bool run(SlicePairs& pairs, const NodeLights& lights, std::span<const float> thresholds,
             const DarkRows& dark, AcceptedPairs& accepted, Pcg32& random,
             const std::stop_token& stop);

private:
    static constexpr uint32_t kSamples = 16;  // of a pair

    /// A pair whose samples are asked.
    struct Tried {
        Pair pair;
        float most;
        uint32_t count;           // of samples
        uint64_t asked, visible;  // bits of those that face each other
        std::array<PairSample, kSamples> samples;
    };

    void findOutermost(const DarkRows& dark);
    void step(const Pair& pair, AcceptedPairs& accepted, Pcg32& random);
    void split(const Pair& pair);
    void add(const Pair& pair, float most, Pcg32& random);
    void ask(Tried& tried, uint32_t begin, uint32_t end);
    void finishTried(AcceptedPairs& accepted);
    void shade(const Pair& pair);

    SlicePairs* pairs_ = nullptr;
    const NodeLights* lights_ = nullptr;
    std::span<const float> thresholds_;
    std::vector<Outermost> outermost_;  // rows, by node
    std::vector<Tried> tried_;
    std::optional<ShadowPackets> packets_;  // of their rays
};

/// Whether anything of the lights may be above the horizon of a flat group of receivers, and of
/// these above that of flat lights; cosines of less than a ten thousandth count as none.
bool mayFace(const PixelNode& p, const LightNode& l, LightKind kind);

/// What samples of a pair say about all of it; `asked` and `visible` are bits.
enum class Agreement { none, visible, hidden };
Agreement agreementOf(uint64_t asked, uint64_t visible, bool fewSuffice);

}  // namespace core::many_lights

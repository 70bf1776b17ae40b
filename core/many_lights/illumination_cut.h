// IlluminationCut: N. Bus, N. Mustafa, V. Biri, "IlluminationCut" (2015). One cut through all pairs
// of a node of receivers and a node of lights: a first pass finds roughly what every receiver gets,
// a second one takes pairs as large as what they may err, in relation to that, allows, and guesses
// the visibility of each from samples. Biased by such guesses, and by an error up to the bound.
// What differs: the tree of receivers begins at slices, each of which is lit by itself; the light
// tree is that of all techniques; errors are compared as luminances; and a receiver in deep shadow
// counts as if it had a hundredth of the mean of its slice, since nothing is small in relation to
// nothing.
// In rooms of few planes (flat_lights.h) Lambert's receivers of few flat pieces are lit in another
// way, which is not the paper's (whole_pairs.h): pairs that may err by up to twenty times as much
// are taken as a whole where samples of both sides agree, and are shaded by nearly all their
// lights; what a receiver gets is lowered where a few rays of its own see clearly less
// (dark_rows.h); pairs behind each other's horizon are dropped; and bounds are weighed by the part
// of the samples that face each other. Where things are many and small, samples of so large pairs
// seldom agree, or agree by chance: there it costs more than it saves.
#pragma once

#include <optional>

#include "core/many_lights/light_tree.h"
#include "core/many_lights/pair_samples.h"
#include "core/many_lights/slice_lighter.h"

namespace core::many_lights {

class IlluminationCut final : public SliceLighter {
public:
    /// Keeps the tree by reference. A pair may err by `error` times what its receivers get.
    IlluminationCut(const LightTree& tree, float error);

    bool light(const SliceJob& job, std::span<const Receiver> receivers,
               std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
               std::span<glm::vec3> radiance, SliceStats& stats) const override;

private:
    const LightTree& tree_;
    float error_;
    std::optional<NodeLights> nodeLights_;  // where lights lie in few planes
};

}  // namespace core::many_lights

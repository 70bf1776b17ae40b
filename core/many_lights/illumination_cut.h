// IlluminationCut: N. Bus, N. Mustafa, V. Biri, "IlluminationCut" (2015). One cut through all pairs
// of a node of receivers and a node of lights: a first pass finds roughly what every receiver gets,
// a second one takes pairs as large as what they may err, in relation to that, allows, and guesses
// the visibility of each from samples. Biased by such guesses, and by an error up to the bound.
// What differs: the tree of receivers begins at slices, each of which is lit by itself; the light
// tree is that of all techniques; errors are compared as luminances; and a receiver in deep shadow
// counts as if it had a hundredth of the mean of its slice, since nothing is small in relation to
// nothing.
#pragma once

#include "core/many_lights/light_tree.h"
#include "core/many_lights/slice_lighter.h"

namespace core::many_lights {

class IlluminationCut final : public SliceLighter {
public:
    /// Keeps the tree by reference. A pair may err by `error` times what its receivers get.
    IlluminationCut(const LightTree& tree, float error) : tree_(tree), error_(error) {}

    bool light(const SliceJob& job, std::span<const Receiver> receivers,
               std::span<const uint32_t> chosen, uint32_t slice, const std::stop_token& stop,
               std::span<glm::vec3> radiance, SliceStats& stats) const override;

private:
    const LightTree& tree_;
    float error_;
};

}  // namespace core::many_lights

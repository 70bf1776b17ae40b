// What a technique has ready before the first slice of a frame: the one place that knows them all.
#pragma once

#include <memory>

#include "core/many_lights/column_source.h"
#include "core/many_lights/slice_lighter.h"
#include "core/many_lights/slices.h"
#include "core/many_lights/technique_params.h"

namespace core::many_lights {

/// What there is to work with, by reference; all of it outlives what is made.
struct TechniqueInput {
    const SliceJob& job;  // with its lights, but neither columns nor lighter
    const LightTree& tree;
    std::span<const Receiver> receivers;
    const Slices& slices;
    const SliceSettings& slicing;  // that they were made with
    uint32_t clusters = 0;
    float error = 0;
};

/// One of the two, as choosesColumns says.
struct ReadyTechnique {
    std::unique_ptr<const ColumnSource> columns;
    std::unique_ptr<const SliceLighter> lighter;
};

/// Prepares a technique, on all threads; adds its shadow rays to `rays`. Neither of the two when
/// `stop` came first.
ReadyTechnique makeTechnique(Technique technique, const TechniqueInput& input,
                             const std::stop_token& stop, uint64_t& rays);

}  // namespace core::many_lights

// What lights and slices of a frame take of the machine's memory, asked before it is taken.
#pragma once

#include "core/many_lights/frame.h"

namespace core::many_lights {

/// Bytes of a frame's lights with their tree, about: `pilot` tells how many of them keep a surface.
double lightBytes(const FrameSettings& settings, const LightSet& pilot);

/// Both throw an Error (commandLine) when the machine does not hold what is asked for: the lights
/// of a frame, and what all threads together take for slices of `rows` points.
void requireLights(const FrameSettings& settings, const LightPlan& plan);
void requireSlices(const FrameSettings& settings, size_t lights, size_t rows);

}  // namespace core::many_lights

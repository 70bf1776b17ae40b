// How measurements are timed. Work done by this process (the CPU renderers, Vulkan in software) is
// timed in CPU seconds over the number of cores, which is what undisturbed cores would take; a real
// GPU by its own clock.
#pragma once

#include <functional>
#include <vector>

#include "app/methods/methods.h"

namespace app {

unsigned cores();

/// Seconds that `work` takes on all cores of this process.
double onHost(const std::function<void()>& work);

/// Seconds that a graphics card takes by its own clock, which `work` returns. What comes before
/// does not count: a card that idled while the host was measured has lowered its clock, so `work`
/// is repeated until that has risen again.
double onCard(const std::function<double()>& work);

/// Whether the host's cores do the work of such a device. Throws core::Error (noDevice).
bool worksOnHost(const Target& target);

/// Processor time of all threads of this process so far.
double processSeconds();

/// Processor time of the calling thread so far.
double threadSeconds();

/// The middle one, the upper of two; `values` are not empty.
double median(std::vector<double> values);

}  // namespace app

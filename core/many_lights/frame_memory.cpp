// See frame_memory.h.
#include "core/many_lights/frame_memory.h"

#include <algorithm>
#include <string>

#include "core/base/machine_memory.h"
#include "core/base/parallel.h"

namespace core::many_lights {

namespace {

/// Of a point and a cluster while a slice is lit, about; the numbers of matrices are doubles.
double bytesPerEntry(const FrameSettings& settings)
{
    constexpr double kBits = 0.5;  // what matters, what is seen, what is known: 4 bits, about
    // Three columns of a cluster, one of each colour, in six matrices (matrix_separation.cpp).
    if (settings.technique == Technique::matSep) return kBits + 6 * 3 * sizeof(double);
    if (!choosesColumns(settings.technique)) return 0;
    const CompletionMethod method = settings.completion.method;
    // As many matrices while singular values are thresholded (low_rank.cpp).
    if (method == CompletionMethod::svt) return kBits + sizeof(float) + 6 * sizeof(double);
    // Known columns, and what is predicted.
    if (method == CompletionMethod::amc) return kBits + 2 * sizeof(float);
    return kBits;
}

std::string nameOf(const FrameSettings& settings)
{
    const bool completes =
        choosesColumns(settings.technique) && settings.completion.method != CompletionMethod::full;
    return std::string(completes ? enumName(settings.completion.method)
                                 : enumName(settings.technique));
}

}  // namespace

double lightBytes(const FrameSettings& settings, const LightSet& pilot)
{
    const double surfaces =
        double(pilot.surfaces.size()) / double(std::max<size_t>(pilot.lights.size(), 1));
    // Twice: those of all paths become those of the frame.
    return double(settings.lights) *
           (2 * (sizeof(VirtualLight) + surfaces * sizeof(LightSurface)) + 2 * sizeof(LightNode));
}

void requireLights(const FrameSettings& settings, const LightPlan& plan)
{
    requireMemory(plan.bytes, "a sample of " + std::to_string(settings.lights) + " lights",
                  "ask for fewer (--lights)");
}

void requireSlices(const FrameSettings& settings, size_t lights, size_t rows)
{
    const size_t columns = std::min<size_t>(settings.clusters, lights);
    requireMemory(double(threadCount()) * double(rows) * double(columns) * bytesPerEntry(settings),
                  nameOf(settings) + " of slices of " + std::to_string(rows) + " points and " +
                      std::to_string(columns) + " clusters",
                  "use smaller slices (--slice-size) or fewer clusters (--clusters)");
}

}  // namespace core::many_lights

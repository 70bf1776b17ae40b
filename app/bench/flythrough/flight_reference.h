// The picture that flights are compared with: rendered when it is asked for, kept in a file.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "core/methods/renderer.h"

namespace app::flight {

struct FlightReference {
    core::Image mean, variance;  // variance: of the mean
    double radiance = 0;         // mean over pixels and channels
    double seconds = 0;          // that it took, now or when it was made
    bool kept = false;           // read from the file
};

/// What a reference shows. `view` has the parameters of the flights, of which those that decide
/// what is seen are taken: depth, and where in its pixel a first hit lies.
struct ReferenceOrder {
    std::filesystem::path file;  // EXR; its folder is made when it does not exist
    core::View view;
    double at = 0;         // seconds of the scene's animation
    uint64_t samples = 0;  // per pixel
};

/// Reads `order.file` if it shows what is ordered, to the bit of every number that matters (the
/// program's version and commit and the scene's content among them); else renders with `renderer`,
/// which has the world, and writes it. Path tracing through the same pixels that the flights look
/// through, by independent samples, whose variance is known without bias. Nothing when `stop` came
/// first. Throws core::Error.
std::optional<FlightReference> reference(const ReferenceOrder& order, core::Renderer& renderer,
                                         const core::World& world,
                                         const std::function<void(double)>& progress,
                                         std::stop_token stop);

}  // namespace app::flight

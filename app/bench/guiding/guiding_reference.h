// The picture that guided and plain pictures are compared with: guided path tracing as it is by
// default, with seeds that no other picture has, kept in a file.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>

#include "core/methods/renderer.h"

namespace app::guiding {

struct GuidingReference {
    core::Image mean;
    core::Image variance;  // of the mean, from the difference of its two halves
    core::Image level;     // the mean over 3x3 pixels, what errors are relative to
    double seconds = 0;    // that it took, now or when it was made
    bool kept = false;     // read from the file
};

/// What a reference shows; `view` has the parameters of `guided`, of which the depth
/// of paths is taken: the others do not decide what the true picture is.
struct ReferenceOrder {
    std::filesystem::path file;  // EXR; its folder is made when it does not exist
    core::View view;
    double at = 0;         // seconds of the scene's animation
    uint32_t samples = 0;  // per pixel, of both halves together: even
};

/// Reads `order.file` if it shows what is ordered, else renders with `renderer`, which has the
/// world, and writes it. Two halves of independent seeds tell how noisy their mean is, whatever the
/// sampler. Nothing when `stop` came first. Throws core::Error.
std::optional<GuidingReference> reference(const ReferenceOrder& order, core::Renderer& renderer,
                                          const core::World& world,
                                          const std::function<void(double)>& progress,
                                          std::stop_token stop);

/// Means over 3x3 pixels, or as many of them as the picture has.
core::Image blurred(const core::Image& image);

}  // namespace app::guiding

// Receivers: the points that a picture sees, to which virtual lights shine.
#pragma once

#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/trace/accel.h"
#include "shared/camera.h"
#include "shared/sampler.h"

namespace core::many_lights {

/// A surface point seen through `place` = pixel * receivers per pixel + which of them. Its material
/// is looked up again when its slice is shaded: that costs less than keeping it.
struct Receiver {
    glm::vec3 position{0};
    uint32_t slot = 0;    // of the triangle
    glm::vec3 normal{0};  // geometric, on the side that is seen
    uint32_t place = 0;
    glm::vec2 barycentrics{0};
    glm::vec3 direction{0};           // of the ray that found it
    glm::vec3 throughput{0};          // of what it sends back along that ray
    uint32_t events = 0;              // scattering events between camera and receiver
    uint32_t medium = shared::kNone;  // through which it is seen
};

/// How receivers are found.
struct ReceiverJob {
    const Accel* accel = nullptr;
    shared::PathSettings settings{};
    shared::CameraData camera{};
    uint32_t side = 1;  // a pixel has side x side cells, one receiver each
    uint32_t frame = 0;
    bool centred = false;  // receivers at the centres of cells, through that of the lens
};

/// The numbers of a receiver's path; its vertex is of depth `events`.
shared::SampleStream receiverStream(const ReceiverJob& job, uint32_t place);

/// Follows camera rays through the pixels of `tile` until they meet a surface whose lobes have
/// densities; mirrors and clear glass send them on, with their throughput, and where a surface has
/// both kinds of lobes chance decides, unbiased. Appends receivers pixel by pixel along a Z curve.
/// What is seen beside the light of virtual lights (emission, environment) goes to `direct`, by
/// place. Returns the rays traced.
uint64_t traceReceivers(const ReceiverJob& job, const Tile& tile, std::vector<Receiver>& receivers,
                        std::span<glm::vec3> direct);

}  // namespace core::many_lights

// The reference that errors are measured against, rendered by the core thread on the CPU while one
// looks at the picture.
#pragma once

#include "app/pictures/picture.h"
#include "core/base/worker.h"

namespace app {

struct ReferenceOrder {
    std::shared_ptr<const core::World> world;
    core::Camera camera;
    glm::uvec2 size{0};
    // Its seed is replaced by one of the reference's own: errors must be independent
    core::AnyParams params;
    uint64_t samples = 4096;
};

/// A job for a Worker: publishes a Reference into `box` (under the job's generation) soon after the
/// start and then each time its samples have grown by a half, until all are taken.
core::Worker::Job referenceJob(ReferenceOrder order, std::shared_ptr<core::Mailbox<Reference>> box);

}  // namespace app

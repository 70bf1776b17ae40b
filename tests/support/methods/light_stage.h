// A scene with its virtual lights, which every technique of many lights shows in the same picture.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/many_lights/slice_shading.h"
#include "core/trace/scene_view.h"
#include "tests/support/methods/light_frames.h"

namespace tests {

/// The same lights and points for all techniques.
struct LightStage {
    std::shared_ptr<const core::World> world;
    core::Accel accel;
    core::many_lights::FrameSettings settings;
    core::many_lights::LightPlan plan;
    std::shared_ptr<const core::many_lights::FrameLights> lights;

    LightStage(std::shared_ptr<const core::World> of, uint32_t size, uint32_t lightCount)
        : world(std::move(of)), accel(world), settings(frameSettings(*world, size))
    {
        settings.lights = lightCount;
        settings.clamp = 0.5f;
        settings.centred = true;
        settings.sliceSize = 100;
        plan = core::many_lights::planLights(accel, settings);
        lights = core::many_lights::makeFrameLights(accel, settings, plan, 0, {});
    }

    core::Image image(core::many_lights::Technique technique, uint32_t clusters, float error,
                      uint32_t seed = 1, core::many_lights::FrameStats* stats = nullptr) const
    {
        core::many_lights::FrameSettings s = settings;
        s.technique = technique;
        s.clusters = clusters;
        s.error = error;
        return frameImage(accel, s, plan, lights, seed, stats);
    }
    /// The sum over all lights.
    core::Image all() const { return image(core::many_lights::Technique::clusters, 1u << 30, 0); }
};

/// The receivers of a frame, as rows.
struct StageRows {
    std::vector<core::many_lights::Receiver> receivers;
    std::vector<uint32_t> chosen;
    core::many_lights::SliceRows rows;
    core::many_lights::SliceJob job;

    explicit StageRows(const LightStage& stage)
    {
        const uint32_t size = stage.settings.path.imageWidth;
        job.receivers = {&stage.accel, stage.settings.path, stage.settings.camera, 1, 0, true};
        job.lights = &stage.lights->set;
        job.gather = {stage.settings.path.maxDepth, stage.plan.clampDistance};
        std::vector<glm::vec3> direct(size_t(size) * size);
        core::many_lights::traceReceivers(job.receivers, {0, 0, size, size}, receivers, direct);
        for (uint32_t i = 0; i < receivers.size(); ++i) chosen.push_back(i);
        rows.reset(core::sceneView(*stage.world), receivers, chosen);
    }
};

}  // namespace tests

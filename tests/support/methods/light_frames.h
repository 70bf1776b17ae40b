// Frames of many lights over small pictures of a scene, as tests need them.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "core/image/image.h"
#include "core/many_lights/frame.h"

namespace tests {

/// Square frames, all visibility traced, seen through the middles of pixels' parts or not.
inline core::many_lights::FrameSettings frameSettings(const core::World& world, uint32_t size)
{
    core::many_lights::FrameSettings s;
    s.path = core::worldSettings(world);
    s.path.imageWidth = s.path.imageHeight = size;
    s.path.seed = 7;
    s.path.samplerKind = shared::kSamplerSobol;
    s.path.strategy = shared::kStrategyMis;
    s.path.maxDepth = 8;
    s.path.rouletteDepth = 2;
    s.path.clampIndirect = 0;
    s.camera = core::cameraData(world.cameras.at(0), size, size);
    s.compensates = false;
    s.completion.method = core::many_lights::CompletionMethod::full;
    return s;
}

/// A picture of these lights; `seed` decides about everything but the lights.
inline core::Image frameImage(const core::Accel& accel, core::many_lights::FrameSettings s,
                              const core::many_lights::LightPlan& plan,
                              const std::shared_ptr<const core::many_lights::FrameLights>& lights,
                              uint32_t seed, core::many_lights::FrameStats* stats = nullptr)
{
    s.path.seed = seed;
    const uint32_t width = s.path.imageWidth;
    core::Image image(width, s.path.imageHeight, 3);
    const auto done = [&](size_t pixel, const glm::vec3& L) {
        for (int c = 0; c < 3; ++c) image.pixels[3 * pixel + size_t(c)] = L[c];
    };
    const auto frame = core::many_lights::Frame::begin(
        accel, s, plan, lights, core::many_lights::makeFrameReceivers(accel, s, 0, {}), 0, {},
        done);
    EXPECT_TRUE(frame->advance(core::Clock::now(), 1e9, {}, done));
    if (stats != nullptr) *stats = frame->stats();
    return image;
}

}  // namespace tests

// Flights of a camera past a scene with the method that keeps its samples, on every device.
#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/methods/methods.h"
#include "tests/support/methods/shared_renderer.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/statistics/image_mean.h"

namespace tests {

using core::PixelJitter, core::ReuseParams, core::ReuseStrategy;

/// The scene's camera, swung about what it looks at.
inline core::Camera swung(const core::World& world, double degrees)
{
    core::Camera camera = world.cameras.at(0);
    const double angle = degrees * std::numbers::pi / 180;
    const glm::dvec3 target = camera.position + 3.7 * camera.forward;
    const glm::dvec3 back = camera.position - target;
    const glm::dvec3 turned(back.x * std::cos(angle) + back.z * std::sin(angle), back.y,
                            back.z * std::cos(angle) - back.x * std::sin(angle));
    return core::lookAt(target + turned, target, {0, 1, 0}, camera.yfov);
}

inline ReuseParams with(ReuseStrategy reuse, uint32_t seed, float rays = 1)
{
    ReuseParams params;
    params.rays = rays;
    params.reuse = reuse;
    params.seed = seed;
    params.sampler = core::SamplerKind::independent;
    params.jitter = PixelJitter::never;
    return params;
}

class ReuseFlights : public testing::TestWithParam<app::DeviceKind> {
protected:
    void SetUp() override
    {
        ASSERT_EQ(app::whyNot("reuse", GetParam()), "");
        renderer_ = &sharedRenderer("reuse", GetParam());
    }

    void begin(const std::string& scene, glm::uvec2 size) { begin(asset(scene), size); }

    void begin(std::shared_ptr<const core::World> world, glm::uvec2 size)
    {
        world_ = std::move(world);
        renderer_->setWorld(world_, {});
        size_ = size;
    }

    /// The picture after a swing of `frames` views, `step` degrees apart, that ends at the scene's
    /// own camera; each view has so many passes.
    core::Estimate fly(const ReuseParams& params, uint32_t frames, double step, uint32_t passes = 1)
    {
        for (uint32_t i = 0; i < frames; ++i)
            look(swung(*world_, -step * (frames - 1 - i)), params,
                 i == 0 ? core::Start::anew : core::Start::moved, passes);
        return renderer_->read(core::Reading::everything);
    }

    void look(const core::Camera& camera, const ReuseParams& params, core::Start start,
              uint32_t samples = 1)
    {
        renderer_->setView({camera, size_, params}, start);
        renderer_->advance({.samples = samples}, {});
    }

    /// As good as so many independent samples: in a Cornell box half as many of Sobol's points err
    /// as little at 9 surfaces, a quarter of them at 3.
    core::Estimate reference(uint32_t samples)
    {
        ReuseParams params = with(ReuseStrategy::discard, 991);
        params.sampler = core::SamplerKind::sobol;
        look(swung(*world_, 0), params, core::Start::anew, samples / 2);
        return renderer_->read(core::Reading::everything);
    }

    /// Of each pixel, whether its centre shows a flat pane of glass. (Curved glass bends what is
    /// behind it, and seldom finds a history.)
    std::vector<bool> seenThroughPane() const
    {
        const core::Aovs aovs = renderer_->aovs();
        std::vector<bool> found(size_t(size_.x) * size_.y);
        for (size_t i = 0; i < found.size(); ++i) {
            const int material = static_cast<int>(aovs.ids.pixels[3 * i + 1]);
            if (material < 0) continue;
            const std::string& name = world_->scene->materials.at(size_t(material)).name;
            found[i] = name == "pane";
        }
        return found;
    }

    /// A figure that the renderer tells of the last view.
    double detail(const std::string& name) const
    {
        for (const core::StatsDetail& d : renderer_->stats().details)
            if (d.name == name) return std::get<double>(d.value);
        ADD_FAILURE() << name << " is not told";
        return 0;
    }

    core::Renderer* renderer_ = nullptr;
    std::shared_ptr<const core::World> world_;
    glm::uvec2 size_{};
};

/// The name of a device, for tests that run on each.
struct DeviceName {
    std::string operator()(const testing::TestParamInfo<app::DeviceKind>& where) const
    {
        return std::string(core::enumName(where.param));
    }
};

}  // namespace tests

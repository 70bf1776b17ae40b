// Renders of the guided path tracer on every device, with the path tracer's beside them.
#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "app/methods/methods.h"
#include "core/methods/method.h"
#include "tests/support/methods/shared_renderer.h"
#include "tests/support/scenes/asset.h"

namespace tests {

class GuidedRenders : public testing::TestWithParam<app::DeviceKind> {
protected:
    void SetUp() override
    {
        ASSERT_EQ(app::whyNot("guided", GetParam()), "");
        guided_ = &sharedRenderer("guided", GetParam());
    }

    void begin(const std::string& scene, glm::uvec2 size)
    {
        world_ = asset(scene);
        guided_->setWorld(world_, {});
        size_ = size;
    }

    core::Estimate render(const core::GuidedParams& params, uint32_t samples,
                          core::Start start = core::Start::anew)
    {
        return render(*guided_, {world_->cameras.at(0), size_, params}, samples, start);
    }

    static core::Estimate render(core::Renderer& renderer, const core::View& view, uint32_t samples,
                                 core::Start start = core::Start::anew)
    {
        renderer.setView(view, start);
        renderer.advance({.samples = samples}, {});
        return renderer.read(core::Reading::everything);
    }

    /// The path tracer's picture of the same view.
    core::Estimate plain(core::PathParams params, uint32_t samples) const
    {
        core::Renderer& renderer = sharedRenderer("path", GetParam());
        renderer.setWorld(world_, {});
        return render(renderer, {world_->cameras.at(0), size_, params}, samples);
    }

    template <class T = double> T detail(const std::string& name) const
    {
        for (const core::StatsDetail& d : guided_->stats().details)
            if (d.name == name) return std::get<T>(d.value);
        ADD_FAILURE() << name << " is not told";
        return {};
    }

    std::string guiding() const { return detail<std::string>("guiding"); }

    core::Renderer* guided_ = nullptr;
    std::shared_ptr<const core::World> world_;
    glm::uvec2 size_{};
};

}  // namespace tests

// One small picture by each method that renders light, on each device that has it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/methods/methods.h"
#include "tests/support/methods/shared_renderer.h"

namespace tests {

struct PictureTaken {
    const core::Estimate& estimate;
    std::string method, where;  // where: method and device
};

/// Pictures through the world's first camera, with the method's own settings.
inline void forEachPicture(const std::shared_ptr<const core::World>& world, glm::uvec2 size,
                           uint32_t samples, const std::function<void(const PictureTaken&)>& check)
{
    for (const core::MethodInfo& method : core::methods()) {
        if (method.id() == "ao") continue;
        for (const app::DeviceKind device : {app::DeviceKind::cpu, app::DeviceKind::vulkan}) {
            if (!app::whyNot(method.id(), device).empty()) continue;
            const std::string id(method.id());
            core::Renderer& renderer = sharedRenderer(id, device);
            renderer.setWorld(world, {});
            renderer.setView({world->cameras.front(), size, method.defaults}, core::Start::anew);
            renderer.advance({.samples = samples}, {});
            const core::Estimate estimate = renderer.read(core::Reading::everything);
            check({estimate, id, id + " on " + std::string(core::enumName(device))});
        }
    }
}

}  // namespace tests

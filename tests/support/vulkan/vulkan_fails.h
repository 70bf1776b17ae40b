// What the tests of a failing Vulkan have in common: a fixture that plants faults after the device
// has been named, and a small render.
#pragma once

#include <initializer_list>
#include <memory>
#include <numeric>
#include <string>

#include <gtest/gtest.h>

#include "app/gpu/methods/path.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/vulkan/vulkan_faults.h"

namespace tests {

/// The device that is chosen when nothing fails.
inline const std::string& deviceName()
{
    static const std::string name = [] {
        for (const gpu::DeviceInfo& info : gpu::listDevices()) {
            if (info.missing.empty()) return info.name;
        }
        return std::string("no device");
    }();
    return name;
}

class VulkanFails : public testing::Test {
protected:
    static void SetUpTestSuite() { deviceName(); }  // before anything is planted
};

/// What the action's core::Error says, which must carry `code`; fails the test when there is none.
template <class F> std::string errorOf(core::ExitCode code, F action)
{
    try {
        action();
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return "";
}

inline void expectSays(const std::string& text, std::initializer_list<std::string> parts)
{
    for (const std::string& part : parts)
        EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' in: " << text;
}

inline core::Estimate renderSmall(core::Renderer& renderer,
                                  const std::shared_ptr<const core::World>& world,
                                  uint32_t size = 24)
{
    renderer.setWorld(world, {});
    renderer.setView({world->cameras.at(0), {size, size}, {}}, core::Start::anew);
    renderer.advance({.samples = 1}, {});
    const core::Estimate film = renderer.read(core::Reading::everything);
    return film;
}

inline double brightness(const core::Estimate& film)
{
    return std::accumulate(film.mean.pixels.begin(), film.mean.pixels.end(), 0.0);
}

/// Plants a lie about the device's properties.
template <class F> inline void lieAboutProperties(VulkanFaults& faults, F lie)
{
    faults.replace<&gpu::Api::GetPhysicalDeviceProperties2>(
        [lie](auto driver, VkPhysicalDevice physical, VkPhysicalDeviceProperties2* properties) {
            driver(physical, properties);
            lie(properties->properties);
        });
}

}  // namespace tests

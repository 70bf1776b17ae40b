// A flight on a small circle around the scene's first view. See fly_through.h.
#include "app/commands/fly_through.h"

#include <cmath>
#include <iostream>

#include <glm/gtc/constants.hpp>

#include "app/base/files.h"
#include "app/base/new_folder.h"
#include "app/base/new_name.h"
#include "app/commands/render_command.h"
#include "app/files/load.h"
#include "app/gpu/base/device.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr uint32_t kFrames = 24, kPictureWidth = 256;
constexpr uint64_t kSpp = 8;
constexpr double kCircle = 0.06;  // its radius over the distance of what is looked at

bool hasVulkanDevice()
{
    try {
        for (const gpu::DeviceInfo& device : gpu::listDevices())
            if (device.missing.empty()) return true;
    } catch (const core::Error&) {
        // No Vulkan at all is an answer here: the CPU renders then.
    }
    return false;
}

/// Once round a circle in the plane of the first view's picture, looking at the same point all the
/// time.
CameraPath circle(const core::World& world, const core::Camera& first)
{
    const glm::dvec3 middle = 0.5 * glm::dvec3(world.boundsLow + world.boundsHigh);
    const double ahead = glm::dot(middle - first.position, first.forward);
    const double radius = static_cast<double>(world.radius);
    const double distance = ahead > 0.05 * radius ? ahead : radius;
    const glm::dvec3 target = first.position + distance * first.forward;
    const glm::dvec3 right = glm::normalize(glm::cross(first.forward, first.up));
    CameraPath path;
    for (uint32_t i = 0; i < kFrames; ++i) {
        const double angle = glm::two_pi<double>() * i / kFrames;
        core::Camera camera = first;
        camera.position +=
            kCircle * distance * (std::sin(angle) * right + 0.5 * (1 - std::cos(angle)) * first.up);
        const core::Camera turned = core::lookAt(camera.position, target, first.up, first.yfov);
        camera.forward = turned.forward;
        camera.up = turned.up;
        path.keys.push_back({static_cast<double>(i), camera});
    }
    return path;
}

}  // namespace

int flyThrough(const FlyThroughOptions& options)
{
    RenderOptions o;
    o.scene = options.scene;
    if (o.scene.file.empty()) o.scene.file = defaultScene();
    o.output = newPattern(fs::path("rekindle-frames") / "frame-%04d.png");
    const fs::path folder = o.output.parent_path();
    NewFolder made(folder, numbered(o.output.filename(), 0));
    const bool vulkan = options.device == DeviceKind::vulkan && hasVulkanDevice();
    o.device = vulkan ? DeviceKind::vulkan : DeviceKind::cpu;
    o.deviceIndex = vulkan ? options.deviceIndex : -1;
    o.validation = vulkan && options.validation;
    o.noCache = options.noCache;
    o.params = options.params;
    o.camera = options.camera;
    o.width = kPictureWidth;
    o.spp = kSpp;
    o.frames = FrameRange{0, kFrames - 1};
    const int code = renderFrames(
        o, [&o](const core::World& world) { return circle(world, chooseCamera(world, o.camera)); });
    std::error_code error;
    if (fs::is_empty(folder, error)) return code;  // interrupted before there was anything
    made.keep();
    std::cout << fs::absolute(folder, error).string() << '\n';
    return code;
}

}  // namespace app

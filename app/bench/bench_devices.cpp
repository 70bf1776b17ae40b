// See bench_devices.h.
#include "app/bench/bench_devices.h"

#include "app/bench/bench_clock.h"
#include "core/base/check.h"

namespace app {

static OpenedDevice openDevice(DeviceKind kind, int deviceIndex)
{
    const Target target{.device = kind, .deviceIndex = deviceIndex};
    const std::string name(core::enumName(kind));
    return {{name, name, worksOnHost(target)}, target};
}

std::vector<OpenedDevice> openDevices(MeasuredDevices asked, int deviceIndex, const Say& warn)
{
    std::vector<OpenedDevice> opened;
    if (asked != MeasuredDevices::vulkan) opened.push_back(openDevice(DeviceKind::cpu, -1));
    if (asked == MeasuredDevices::cpu) return opened;
    try {
        opened.push_back(openDevice(DeviceKind::vulkan, deviceIndex));
    } catch (const core::Error& error) {
        if (asked == MeasuredDevices::vulkan || error.code() != core::ExitCode::noDevice) throw;
        warn(std::string("without Vulkan: ") + error.what());
    }
    return opened;
}

std::string clockText(const std::vector<BenchDevice>& devices)
{
    std::string text;
    for (const BenchDevice& d : devices)
        text += (text.empty() ? "" : "; ") + d.name + " (" + d.words + "): " +
                (d.onHost ? "processor seconds of the program, all threads together"
                          : "seconds by the device’s clock");
    return text;
}

}  // namespace app

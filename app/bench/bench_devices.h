// The devices that measurements are made on, and which clock is fair to each.
#pragma once

#include <string>
#include <vector>

#include "app/args/args.h"
#include "app/bench/bench_run.h"
#include "app/methods/methods.h"

namespace app {

struct BenchDevice {
    std::string name;    // "cpu" or "vulkan"
    std::string words;   // what it is
    bool onHost = true;  // the host's cores do its work: time is processor time
};

struct OpenedDevice {
    BenchDevice device;
    Target target;
};

/// Those that were asked for, the CPU first; `both` is told through `warn` where there is no Vulkan
/// device. Throws core::Error when one that was asked for is not there.
std::vector<OpenedDevice> openDevices(MeasuredDevices asked, int deviceIndex, const Say& warn);

/// Seconds of one picture by the clock that fits the device; a sample has `cpuSeconds` of this
/// process and `renderSeconds` by the renderer's clock.
template <class Sample> double secondsOf(const BenchDevice& device, const Sample& sample)
{
    return device.onHost ? sample.cpuSeconds : sample.renderSeconds;
}

/// "cpu (Embree ...): processor seconds ...; vulkan ...", for a page.
std::string clockText(const std::vector<BenchDevice>& devices);

}  // namespace app

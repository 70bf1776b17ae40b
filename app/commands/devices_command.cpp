// The list of devices as text or JSON. See devices_command.h.
#include "app/commands/devices_command.h"

#include <nlohmann/json.hpp>

#include "app/files/stats.h"
#include "app/gpu/base/device.h"
#include "core/base/check.h"

namespace app {

static nlohmann::ordered_json deviceJson(size_t index, const gpu::DeviceInfo& device)
{
    return {{"index", index},
            {"name", device.name},
            {"driver", device.driver},
            {"type", device.type},
            {"api", device.api},
            {"suitable", device.missing.empty()},
            {"missing", device.missing},
            {"heap_bytes", device.heapBytes},
            {"max_storage_range", device.maxStorageRange},
            {"max_texel_elements", device.maxTexelElements}};
}

static void printDevice(size_t index, const gpu::DeviceInfo& device, std::ostream& out)
{
    out << index << "  " << device.name << " (" << device.type << ")\n"
        << "   driver " << device.driver << ", Vulkan " << device.api << ", memory "
        << (device.heapBytes >> 20) << " MiB, largest buffer " << (device.maxStorageRange >> 20)
        << " MiB, texels per buffer " << device.maxTexelElements << '\n';
    if (device.missing.empty()) out << "   suitable\n";
    for (const std::string& what : device.missing) out << "   lacks " << what << '\n';
}

int devicesCommand(const DevicesOptions& options, std::ostream& out)
{
    const std::vector<gpu::DeviceInfo> devices = gpu::listDevices();
    bool suitable = false;
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (size_t i = 0; i < devices.size(); ++i) {
        suitable = suitable || devices[i].missing.empty();
        if (options.json)
            list.push_back(deviceJson(i, devices[i]));
        else
            printDevice(i, devices[i], out);
    }
    if (options.json) out << jsonLines({{"schema", 1}, {"devices", list}});
    return static_cast<int>(suitable ? core::ExitCode::done : core::ExitCode::noDevice);
}

}  // namespace app

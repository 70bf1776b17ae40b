// See machine_memory.h.
#include "core/base/machine_memory.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <limits>

#include <unistd.h>

#include "core/base/check.h"

namespace core {

static std::atomic<double> memoryLimit = std::numeric_limits<double>::infinity();

double machineMemory()
{
    const double present =
        static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    return std::min(present, memoryLimit.load());
}

MemoryLimit::MemoryLimit(double bytes)
{
    memoryLimit = bytes;
}

MemoryLimit::~MemoryLimit()
{
    memoryLimit = std::numeric_limits<double>::infinity();
}

void requireMemory(double bytes, const std::string& what, const std::string& remedy)
{
    const double present = machineMemory();
    if (bytes <= present) return;
    char numbers[96];
    std::snprintf(numbers, sizeof numbers, " needs about %.0f GiB, this machine has %.0f GiB — ",
                  bytes / (1 << 30), present / (1 << 30));
    throw Error(what + numbers + remedy, ExitCode::commandLine);
}

}  // namespace core

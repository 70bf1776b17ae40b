// See system.h. Linux's files and calls.
#include "app/version/system.h"

#include <fstream>
#include <thread>

#include <sys/utsname.h>
#include <unistd.h>

namespace app {

namespace {

/// What follows `key` and its separator in the first line of `file` that begins with it.
std::string valueIn(const char* file, const std::string& key, char separator)
{
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) {
        const size_t at = line.find(separator);
        if (!line.starts_with(key) || at == std::string::npos) continue;
        const std::string blanks = " \t\"";
        const size_t first = line.find_first_not_of(blanks, at + 1);
        if (first == std::string::npos) return {};
        return line.substr(first, line.find_last_not_of(blanks) - first + 1);
    }
    return {};
}

}  // namespace

SystemInfo systemInfo()
{
    SystemInfo info;
    utsname kernel{};
    const bool known = uname(&kernel) == 0;
    info.os = valueIn("/etc/os-release", "PRETTY_NAME", '=');
    if (known) info.kernel = std::string(kernel.sysname) + ' ' + kernel.release;
    info.processor = valueIn("/proc/cpuinfo", "model name", ':');
    if (known) info.processor += (info.processor.empty() ? "" : ", ") + std::string(kernel.machine);
    info.cores = std::thread::hardware_concurrency();
    const long pages = sysconf(_SC_PHYS_PAGES), pageSize = sysconf(_SC_PAGESIZE);
    if (pages > 0 && pageSize > 0)
        info.memoryBytes = static_cast<uint64_t>(pages) * static_cast<uint64_t>(pageSize);
    return info;
}

}  // namespace app

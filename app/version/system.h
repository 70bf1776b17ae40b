// The machine that the program runs on, as a bug report needs it. Facts that cannot be read are
// empty or 0.
#pragma once

#include <cstdint>
#include <string>

namespace app {

struct SystemInfo {
    std::string os;         // the distribution's own name, "Debian GNU/Linux 12 (bookworm)"
    std::string kernel;     // "Linux 6.1.0-18-amd64"
    std::string processor;  // its model and architecture
    unsigned cores = 0;     // that this process may use
    uint64_t memoryBytes = 0;
};

SystemInfo systemInfo();

}  // namespace app

// Renderers that all tests of a process share: a device compiles the kernels of each once.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "app/methods/methods.h"
#include "tests/support/process/kept_objects.h"

namespace tests {

/// The renderer of a method on a device that has it, as the last test has left it.
inline core::Renderer& sharedRenderer(const std::string& method, app::DeviceKind device)
{
    static std::map<std::pair<std::string, app::DeviceKind>, core::Renderer*> all;
    core::Renderer*& mine = all[{method, device}];
    if (mine == nullptr) mine = &kept(app::makeRenderer(method, {.device = device}));
    return *mine;
}

}  // namespace tests

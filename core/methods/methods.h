// The table of methods: every way to render on the CPU, by name.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "core/methods/renderer.h"

namespace core {

struct Method {
    const char* name;
    const char* help;
    std::unique_ptr<Renderer> (*make)();
};

std::span<const Method> methods();

/// A new renderer of that name; throws core::Error (command line) naming the methods there are.
std::unique_ptr<Renderer> makeRenderer(std::string_view name);

// The factories, one per file.
std::unique_ptr<Renderer> makePathTracer();

}  // namespace core

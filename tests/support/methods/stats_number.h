// A number that a renderer tells of itself, by its name.
#pragma once

#include <string_view>

#include <gtest/gtest.h>

#include "core/methods/renderer.h"

namespace tests {

/// Adds a failure to the running test where there is none of that name.
inline double number(const core::Renderer& renderer, std::string_view name)
{
    for (const core::StatsDetail& d : renderer.stats().details)
        if (d.name == name) return std::get<double>(d.value);
    ADD_FAILURE() << "no " << name;
    return -1;
}

}  // namespace tests

// What virtual lights shine from, by its names (shaders/shared/extended_light.h).
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/params.h"

namespace core::many_lights {

enum class LightShape : uint32_t { point, sphere, disc };

}  // namespace core::many_lights

template <> struct core::EnumNames<core::many_lights::LightShape> {
    static constexpr std::array<std::string_view, 3> names{"point", "sphere", "disc"};
};

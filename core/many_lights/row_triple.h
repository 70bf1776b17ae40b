// Numbers of the rows of a slice, by colour or by coordinate.
#pragma once

#include <array>
#include <vector>

namespace core::many_lights {

using RowTriple = std::array<std::vector<float>, 3>;

}  // namespace core::many_lights

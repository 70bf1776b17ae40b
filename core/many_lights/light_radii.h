// How far virtual lights with extent reach: to their neighbours.
#pragma once

#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace core::many_lights {

/// Of each position twice the distance to the tenth nearest that is not the same point, or to the
/// farthest where there are fewer; `alone` where there is none (Wang 2022, 5.7.1, its experiments'
/// choice).
void lightRadii(std::span<const glm::vec3> positions, float alone, std::span<float> radii);

}  // namespace core::many_lights

// Materials of the generated scenes, after the conventions of the test scenes: emitters are single
// sided; a Lambertian surface is roughness 1 with KHR_materials_specular turned off.
#pragma once

#include "assets/generator/gltf_writer.h"

namespace assets {

Json lambertian(const std::string& name, glm::dvec3 color);

/// GGX over a diffuse base, or a metal.
Json glossy(const std::string& name, glm::dvec3 color, double roughness, double metallic = 0);

/// Surface that emits `radiance` on its front and reflects `color`.
Json emitter(const std::string& name, glm::dvec3 radiance, glm::dvec3 color = glm::dvec3(0));

/// Lambertian of `albedo` that also emits `radiance`, on its front only: the wall of a furnace.
Json furnaceWall(double albedo, double radiance);

/// {"index": texture} as materials refer to textures.
Json textureInfo(int texture);

}  // namespace assets

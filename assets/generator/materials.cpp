// Materials as JSON.
#include "assets/generator/materials.h"

#include <algorithm>

namespace assets {

namespace {

void setEmission(Json& material, glm::dvec3 radiance)
{
    const double strength = std::max({radiance.x, radiance.y, radiance.z});
    material["emissiveFactor"] = toJson(radiance / strength);
    material["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
}

}  // namespace

Json glossy(const std::string& name, glm::dvec3 color, double roughness, double metallic)
{
    return {{"name", name},
            {"pbrMetallicRoughness",
             {{"baseColorFactor", toJson(glm::dvec4(color, 1))},
              {"metallicFactor", metallic},
              {"roughnessFactor", roughness}}},
            {"doubleSided", true}};
}

Json lambertian(const std::string& name, glm::dvec3 color)
{
    Json material = glossy(name, color, 1.0);
    material["extensions"] = {{"KHR_materials_specular", {{"specularFactor", 0}}}};
    return material;
}

Json emitter(const std::string& name, glm::dvec3 radiance, glm::dvec3 color)
{
    Json material = lambertian(name, color);
    material["doubleSided"] = false;
    setEmission(material, radiance);
    return material;
}

Json furnaceWall(double albedo, double radiance)
{
    Json material = lambertian("wall", glm::dvec3(albedo));
    material["doubleSided"] = false;
    setEmission(material, glm::dvec3(radiance));
    return material;
}

Json textureInfo(int texture)
{
    return {{"index", texture}};
}

}  // namespace assets

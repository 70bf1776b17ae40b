// What can occur in a scene, as kFeature bits: what cannot is not compiled into kernels, not
// stored, not uploaded.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.h"

namespace core {

/// Names of the bits that materials, lights and cameras decide, bit 0 first, as `info`, the stats
/// and --no-skip have them. The bits above, which follow from how a scene is stored and from the
/// method, have none: code that they stand for needs data that other scenes lack.
std::span<const std::string_view> featureNames();

/// Names of the bits that are set, or of those that are not.
std::vector<std::string> featureList(uint32_t features, bool set);

/// The bit of a name; throws core::Error (command line) listing the names there are.
uint32_t featureBit(std::string_view name);

/// Whether hits on the material need the alpha test.
inline bool hasAlphaTest(const shared::Material& m)
{
    return (m.flags & (shared::kMaterialAlphaMask | shared::kMaterialAlphaBlend)) != 0;
}

/// Whether light may go straight through the material somewhere: smooth or not is a matter of
/// textures.
inline bool mayBePane(const shared::Material& m)
{
    return m.transmission > 0 && (m.flags & shared::kMaterialVolume) == 0;
}

/// Bits that the materials with these indices can need. Textures are scanned for the values that
/// they can take, so that a roughness map that never gets near zero does not bring in mirrors.
/// Exact but for correlations between channels.
uint32_t materialFeatures(const Scene& scene, std::span<const int> materials);

/// Which materials enclose solids: those with a volume that let light through somewhere. Without
/// transmission KHR_materials_volume means nothing.
std::vector<bool> findSolids(const Scene& scene);

/// Whether one of these materials is a solid that refracts without scattering somewhere.
bool anySmoothSolid(const Scene& scene, std::span<const int> materials);

/// Bits that the vertices of these meshes need on top: normals that differ from their faces' by
/// over a thousandth, colours or second coordinates. `features` are those of the materials.
uint32_t meshFeatures(const Scene& scene, std::span<const int> meshes, uint32_t features);

}  // namespace core

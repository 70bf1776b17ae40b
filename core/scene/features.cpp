// Which code a scene needs, from its materials, textures and vertices.
#include "core/scene/features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/check.h"
#include "shared/bsdf.h"
#include "shared/scene.h"
#include "shared/warp.h"

namespace core {

using shared::kNone;

namespace {

constexpr std::array<std::string_view, 20> kNames{
    "shading-normals", "textures",     "normal-maps",   "vertex-extra",      "alpha",
    "specular",        "transmission", "volume",        "clearcoat",         "emissive-triangles",
    "punctual-lights", "environment",  "sun",           "emissive-textures", "thin-lens",
    "delta",           "metal",        "many-emitters", "emitter-tree",      "panes"};

struct ChannelRange {
    float low = 1, high = 1;
};

/// Smallest and largest value of each channel of a texture; look-ups interpolate between them.
class TextureRanges {
public:
    explicit TextureRanges(const Scene& scene) : scene_(scene) {}

    /// Range of a slot's channel (0 red .. 3 alpha); one where the material has no such texture.
    ChannelRange range(const Material& material, uint32_t slot, size_t channel)
    {
        const int use = material.textures[slot];
        if (use < 0) return {};
        const int texture = scene_.textureUses[static_cast<size_t>(use)].texture;
        if (texture < 0) return {};
        auto found = known_.find(texture);
        if (found == known_.end()) {
            found =
                known_.emplace(texture, scan(scene_.textures[static_cast<size_t>(texture)])).first;
        }
        return found->second[channel];
    }

private:
    using Ranges = std::array<ChannelRange, 4>;

    static Ranges scan(const Texture& texture)
    {
        Ranges ranges;
        ranges.fill({std::numeric_limits<float>::infinity(), 0});
        for (const Texel& texel : texture.texels) {
            const std::array<uint16_t, 4> bits{texel.r, texel.g, texel.b, texel.a};
            for (size_t c = 0; c < 4; ++c) {
                const float value = shared::halfAsFloat(bits[c]);
                ranges[c] = {std::min(ranges[c].low, value), std::max(ranges[c].high, value)};
            }
        }
        return ranges;
    }

    const Scene& scene_;
    std::map<int, Ranges> known_;
};

/// Whether light goes through the material somewhere.
bool transmits(const Material& material, TextureRanges& textures)
{
    const shared::Material& m = material.data;
    const float leastMetal =
        m.metallic * textures.range(material, shared::kTextureMetallicRoughness, 2).low;
    return (m.flags & shared::kMaterialUnlit) == 0 && leastMetal < 1 &&
           m.transmission * textures.range(material, shared::kTextureTransmission, 0).high > 0;
}

bool isSolid(const Material& material, TextureRanges& textures)
{
    return (material.data.flags & shared::kMaterialVolume) != 0 && transmits(material, textures);
}

bool isSmoothSolid(const Material& material, TextureRanges& textures)
{
    if (!isSolid(material, textures)) return false;
    const float roughness = material.data.roughness *
                            textures.range(material, shared::kTextureMetallicRoughness, 1).low;
    return shared::interfaceAlpha(roughness, material.data.ior, true) == 0;
}

uint32_t bitsOf(const Material& material, TextureRanges& textures)
{
    const shared::Material& m = material.data;
    uint32_t bits = 0;
    for (uint32_t slot = 0; slot < shared::kTextureSlotCount; ++slot) {
        if (material.textures[slot] >= 0) bits |= shared::kFeatureTextures;
    }
    if (hasAlphaTest(m)) {
        const float lowest = m.alpha * textures.range(material, shared::kTextureBaseColor, 3).low;
        const bool mask = (m.flags & shared::kMaterialAlphaMask) != 0;
        if (lowest < (mask ? m.alphaCutoff : 1.0f)) bits |= shared::kFeatureAlpha;
    }
    if ((m.flags & shared::kMaterialUnlit) != 0) return bits | shared::kFeatureEmissiveTriangles;

    if (material.textures[shared::kTextureNormal] >= 0 && m.normalScale != 0.0f) {
        bits |= shared::kFeatureNormalMaps;
    }
    const auto metalRough = [&](size_t channel) {
        return textures.range(material, shared::kTextureMetallicRoughness, channel);
    };
    const bool metal = m.metallic * metalRough(2).high > 0;
    const bool dielectric = m.metallic * metalRough(2).low < 1;
    const bool specular =
        dielectric && m.specular * textures.range(material, shared::kTextureSpecular, 3).high > 0;
    const bool transmission = transmits(material, textures);
    const bool clearcoat =
        m.clearcoat * textures.range(material, shared::kTextureClearcoat, 0).high > 0;
    if (metal) bits |= shared::kFeatureMetal;
    if (metal || specular || clearcoat) bits |= shared::kFeatureSpecular;
    if (transmission) bits |= shared::kFeatureTransmission;
    if (clearcoat) bits |= shared::kFeatureClearcoat;
    const bool solid = isSolid(material, textures);
    if (solid && (m.absorption.x > 0 || m.absorption.y > 0 || m.absorption.z > 0)) {
        bits |= shared::kFeatureVolume;
    }
    const float coatRoughness =
        m.clearcoatRoughness * textures.range(material, shared::kTextureClearcoatRoughness, 1).low;
    const float roughness = m.roughness * metalRough(1).low;
    if (((metal || specular || transmission) &&
         shared::interfaceAlpha(roughness, m.ior, solid) == 0) ||
        (clearcoat && shared::interfaceAlpha(coatRoughness, shared::kCoatIor, false) == 0)) {
        bits |= shared::kFeatureDelta;
    }
    if (transmission && !solid && shared::interfaceAlpha(roughness, m.ior, false) == 0)
        bits |= shared::kFeaturePanes;
    return bits;
}

/// True when a vertex normal leans away from its face by more than a milliradian or so, or may in
/// another shape of the mesh.
bool hasCurvedNormals(const Mesh& mesh)
{
    if (!mesh.hasNormals || mesh.attributes.empty()) return false;
    if (mesh.deformation) return true;
    for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
        const glm::dvec3 n = glm::cross(b - a, c - a);
        const double length = glm::length(n);
        if (!(length > 0)) continue;
        for (const uint32_t v : {t.x, t.y, t.z}) {
            if (mesh.attributes[v].normal == shared::kNoNormal) continue;
            const glm::dvec3 vertexNormal(shared::unpackOct(mesh.attributes[v].normal));
            if (glm::dot(n, vertexNormal) < (1 - 1e-6) * length) return true;
        }
    }
    return false;
}

}  // namespace

std::span<const std::string_view> featureNames()
{
    return kNames;
}

std::vector<std::string> featureList(uint32_t features, bool set)
{
    std::vector<std::string> names;
    for (size_t bit = 0; bit < kNames.size(); ++bit) {
        if (((features >> bit & 1u) != 0) == set) names.emplace_back(kNames[bit]);
    }
    return names;
}

uint32_t featureBit(std::string_view name)
{
    std::string known;
    for (size_t bit = 0; bit < kNames.size(); ++bit) {
        if (kNames[bit] == name) return 1u << bit;
        known += (bit == 0 ? "" : ", ") + std::string(kNames[bit]);
    }
    throw Error("--no-skip: no feature is called '" + std::string(name) + "' — use one of " + known,
                ExitCode::commandLine);
}

uint32_t materialFeatures(const Scene& scene, std::span<const int> materials)
{
    TextureRanges textures(scene);
    uint32_t bits = 0;
    for (const int material : materials) {
        bits |= bitsOf(scene.materials[static_cast<size_t>(material)], textures);
    }
    return bits;
}

std::vector<bool> findSolids(const Scene& scene)
{
    TextureRanges textures(scene);
    std::vector<bool> solids;
    for (const Material& material : scene.materials) solids.push_back(isSolid(material, textures));
    return solids;
}

bool anySmoothSolid(const Scene& scene, std::span<const int> materials)
{
    TextureRanges textures(scene);
    return std::ranges::any_of(materials, [&](int material) {
        return isSmoothSolid(scene.materials[static_cast<size_t>(material)], textures);
    });
}

uint32_t meshFeatures(const Scene& scene, std::span<const int> meshes, uint32_t features)
{
    uint32_t bits = 0;
    bool colours = false;
    for (const int index : meshes) {
        const Mesh& mesh = scene.meshes[static_cast<size_t>(index)];
        const Material& material = scene.materials[static_cast<size_t>(mesh.material)];
        if (hasCurvedNormals(mesh)) bits |= shared::kFeatureShadingNormals;
        if (mesh.extra.empty()) continue;
        const uint32_t kWhite = 0x3c003c00u;
        bool second = false;
        for (const int use : material.textures) {
            second |= use >= 0 && (scene.textureUses[static_cast<size_t>(use)].record.flags &
                                   shared::kTextureTexCoord1) != 0;
        }
        for (const shared::VertexExtra& v : mesh.extra) {
            colours |= v.colorRg != kWhite || v.colorBa != kWhite;
            if ((v.colorBa >> 16) != 0x3c00u && hasAlphaTest(material.data))
                bits |= shared::kFeatureAlpha;
        }
        if (second || colours) bits |= shared::kFeatureVertexExtra;
    }
    // Normal maps turn the shading normal: the code that reads tangents is enabled by the same bit.
    if ((features & shared::kFeatureNormalMaps) != 0) bits |= shared::kFeatureShadingNormals;
    return bits;
}

}  // namespace core

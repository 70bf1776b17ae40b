// Materials: pbrMetallicRoughness with the KHR extensions that the surface model knows, and their
// uses of textures. KHR_materials_pbrSpecularGlossiness is expressed in the same terms: F0 becomes
// ior and specular colour, the diffuse colour is scaled by what F0 leaves of it; its
// specular-glossiness texture is not supported.
#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

struct Slot {
    uint32_t index;
    bool color;  // encoded in sRGB
};

constexpr Slot kBaseColor{shared::kTextureBaseColor, true};
constexpr Slot kMetallicRoughness{shared::kTextureMetallicRoughness, false};
constexpr Slot kNormal{shared::kTextureNormal, false};
constexpr Slot kEmissive{shared::kTextureEmissive, true};
constexpr Slot kTransmission{shared::kTextureTransmission, false};
constexpr Slot kSpecular{shared::kTextureSpecular, false};
constexpr Slot kSpecularColor{shared::kTextureSpecularColor, true};
constexpr Slot kClearcoat{shared::kTextureClearcoat, false};
constexpr Slot kClearcoatRoughness{shared::kTextureClearcoatRoughness, false};

/// What a texture that cannot be used comes to.
const char* consequenceOf(Slot slot)
{
    return slot.index == kEmissive.index ? "no light" : "no texture";
}

glm::vec3 vector(const std::array<double, 3>& v)
{
    return {v[0], v[1], v[2]};
}

uint32_t wrapFlags(const Object& sampler, const char* key, uint32_t shift)
{
    constexpr uint64_t kRepeat = 10497, kClampToEdge = 33071, kMirroredRepeat = 33648;
    const std::optional<Json> value = sampler.find(key);
    const uint64_t mode = value ? wholeNumber(*value).value_or(0) : kRepeat;
    switch (mode) {
    case kRepeat:
        return shared::kWrapRepeat << shift;
    case kClampToEdge:
        return shared::kWrapClamp << shift;
    case kMirroredRepeat:
        return shared::kWrapMirror << shift;
    default:
        sampler.load().warn("VALUE_NOT_IN_LIST", sampler.at(key),
                            "is " + describe(*value) + ", no wrapping mode — repeats");
        return shared::kWrapRepeat << shift;
    }
}

uint32_t samplerFlags(const Object& sampler)
{
    constexpr uint64_t kNearest = 9728, kLinear = 9729;
    uint32_t flags = wrapFlags(sampler, "wrapS", shared::kTextureWrapSShift) |
                     wrapFlags(sampler, "wrapT", shared::kTextureWrapTShift);
    if (const std::optional<Json> filter = sampler.find("magFilter")) {
        const uint64_t mode = wholeNumber(*filter).value_or(0);
        if (mode == kNearest)
            flags |= shared::kTextureNearest;
        else if (mode != kLinear)
            sampler.load().warn("VALUE_NOT_IN_LIST", sampler.at("magFilter"),
                                "is " + describe(*filter) + ", no filter — linear instead");
    }
    return flags;
}

/// The affine map of KHR_texture_transform: scaled, then rotated, then shifted.
void applyTransform(const Object& transform, shared::TextureReference& record)
{
    const auto offset = transform.softNumbers<2>("offset", {0, 0}, -1e6, 1e6);
    const auto scale = transform.softNumbers<2>("scale", {1, 1}, -1e6, 1e6);
    const double rotation = transform.softNumber("rotation", 0, -1e6, 1e6);
    const double c = std::cos(rotation), s = std::sin(rotation);
    record.row0 = glm::vec3(c * scale[0], s * scale[1], offset[0]);
    record.row1 = glm::vec3(-s * scale[0], c * scale[1], offset[1]);
    const bool identity = record.row0 == glm::vec3(1, 0, 0) && record.row1 == glm::vec3(0, 1, 0);
    if (!identity) record.flags |= shared::kTextureTransformed;
}

class Reader {
public:
    explicit Reader(Load& load) : load_(load) {}

    Material read(const Object& object)
    {
        Material material;
        material.name = object.name();
        shared::Material& m = material.data;
        m = defaults();
        readCommon(object, material);
        if (const auto pbr = object.softObject("pbrMetallicRoughness"))
            readMetallicRoughness(*pbr, material);
        if (const auto x = object.extension("KHR_materials_pbrSpecularGlossiness"))
            readSpecularGlossiness(*x, material);
        else if (const auto ior = object.extension("KHR_materials_ior"))
            readIor(*ior, m);
        if (const auto x = object.extension("KHR_materials_specular")) readSpecular(*x, material);
        if (const auto x = object.extension("KHR_materials_transmission")) {
            m.transmission = static_cast<float>(x->softNumber("transmissionFactor", 0, 0, 1));
            use(*x, "transmissionTexture", kTransmission, material);
        }
        if (const auto x = object.extension("KHR_materials_volume")) readVolume(*x, m);
        if (const auto x = object.extension("KHR_materials_clearcoat"))
            readClearcoat(*x, object, material);
        if (object.extension("KHR_materials_unlit")) m.flags |= shared::kMaterialUnlit;
        return material;
    }

    static shared::Material defaults()
    {
        shared::Material m{};
        m.baseColor = glm::vec3(1);
        m.alpha = 1;
        m.alphaCutoff = 0.5f;
        m.metallic = m.roughness = 1;
        m.ior = 1.5f;
        m.specularColor = glm::vec3(1);
        m.specular = 1;
        m.normalScale = 1;
        return m;
    }

private:
    void readCommon(const Object& object, Material& material)
    {
        shared::Material& m = material.data;
        const auto emissive = object.softNumbers<3>("emissiveFactor", {0, 0, 0}, 0, kHuge);
        double strength = 1;
        if (const auto x = object.extension("KHR_materials_emissive_strength"))
            strength = x->softNumber("emissiveStrength", 1, 0, kHuge);
        m.emissive = vector(emissive) * static_cast<float>(strength);
        // A pattern that is not known must not shine everywhere.
        if (!use(object, "emissiveTexture", kEmissive, material) && object.has("emissiveTexture"))
            m.emissive = glm::vec3(0);
        if (const std::optional<Object> normal = use(object, "normalTexture", kNormal, material))
            m.normalScale = static_cast<float>(normal->softNumber("scale", 1, -kHuge, kHuge));
        if (object.softBoolean("doubleSided", false)) m.flags |= shared::kMaterialDoubleSided;

        const std::string mode =
            object.has("alphaMode") ? object.softString("alphaMode") : "OPAQUE";
        if (mode == "MASK")
            m.flags |= shared::kMaterialAlphaMask;
        else if (mode == "BLEND")
            m.flags |= shared::kMaterialAlphaBlend;
        else if (mode != "OPAQUE")
            load_.warn("VALUE_NOT_IN_LIST", object.at("alphaMode"),
                       "is " + describe(mode) + ", must be OPAQUE, MASK or BLEND — opaque instead");
        m.alphaCutoff = static_cast<float>(object.softNumber("alphaCutoff", 0.5, 0, kHuge));
    }

    void readBase(const std::array<double, 4>& factor, shared::Material& m)
    {
        m.baseColor = glm::vec3(factor[0], factor[1], factor[2]);
        const bool transparent =
            (m.flags & (shared::kMaterialAlphaMask | shared::kMaterialAlphaBlend)) != 0;
        m.alpha = transparent ? static_cast<float>(factor[3]) : 1.0f;
    }

    void readMetallicRoughness(const Object& pbr, Material& material)
    {
        shared::Material& m = material.data;
        readBase(pbr.softNumbers<4>("baseColorFactor", {1, 1, 1, 1}, 0, 1), m);
        m.metallic = static_cast<float>(pbr.softNumber("metallicFactor", 1, 0, 1));
        m.roughness = static_cast<float>(pbr.softNumber("roughnessFactor", 1, 0, 1));
        use(pbr, "baseColorTexture", kBaseColor, material);
        use(pbr, "metallicRoughnessTexture", kMetallicRoughness, material);
    }

    void readSpecularGlossiness(const Object& x, Material& material)
    {
        shared::Material& m = material.data;
        const glm::vec3 f0 = vector(x.softNumbers<3>("specularFactor", {1, 1, 1}, 0, 1));
        const float largest = shared::maxComponent(f0);
        readBase(x.softNumbers<4>("diffuseFactor", {1, 1, 1, 1}, 0, 1), m);
        m.baseColor *= 1 - largest;
        m.metallic = 0;
        m.roughness = 1 - static_cast<float>(x.softNumber("glossinessFactor", 1, 0, 1));
        // F0 = ((n - 1) / (n + 1))^2; an index of 0 stands for a mirror (as in KHR_materials_ior).
        const float root = std::sqrt(largest);
        m.ior = largest < 1 ? (1 + root) / (1 - root) : 0;
        m.specularColor = largest > 0 ? f0 / largest : glm::vec3(1);
        material.textures[kBaseColor.index] = material.textures[kMetallicRoughness.index] = -1;
        use(x, "diffuseTexture", kBaseColor, material);
        if (x.has("specularGlossinessTexture"))
            load_.warn(
                "UNSUPPORTED_FEATURE", x.at("specularGlossinessTexture"),
                "specular-glossiness textures are not supported — the factors alone are used");
    }

    void readIor(const Object& x, shared::Material& m)
    {
        double ior = x.softNumber("ior", 1.5, 0, kHuge);
        if (ior > 0 && ior < 1) {
            load_.warn("VALUE_NOT_IN_RANGE", x.at("ior"),
                       "is " + describe(ior) + ", must be 0 or at least 1 — 1 instead");
            ior = 1;
        }
        m.ior = static_cast<float>(ior);
    }

    void readSpecular(const Object& x, Material& material)
    {
        shared::Material& m = material.data;
        m.specular = static_cast<float>(x.softNumber("specularFactor", 1, 0, 1));
        m.specularColor = vector(x.softNumbers<3>("specularColorFactor", {1, 1, 1}, 0, kHuge));
        use(x, "specularTexture", kSpecular, material);
        use(x, "specularColorTexture", kSpecularColor, material);
    }

    void readVolume(const Object& x, shared::Material& m)
    {
        // Keeps the logarithm finite: a colour of 0 absorbs nearly all
        constexpr double kDarkest = 1e-6;
        const double thickness = x.softNumber("thicknessFactor", 0, 0, kHuge);
        if (thickness > 0) m.flags |= shared::kMaterialVolume;
        const auto color = x.softNumbers<3>("attenuationColor", {1, 1, 1}, 0, 1);
        if (!x.has("attenuationDistance")) return;  // infinite: nothing is absorbed
        const double distance =
            x.softNumber("attenuationDistance", 1, 1e-18, std::numeric_limits<double>::max());
        for (int k = 0; k < 3; ++k)
            m.absorption[k] = static_cast<float>(
                -std::log(std::max(color[static_cast<size_t>(k)], kDarkest)) / distance);
    }

    void readClearcoat(const Object& x, const Object& object, Material& material)
    {
        material.data.clearcoat = static_cast<float>(x.softNumber("clearcoatFactor", 0, 0, 1));
        material.data.clearcoatRoughness =
            static_cast<float>(x.softNumber("clearcoatRoughnessFactor", 0, 0, 1));
        use(x, "clearcoatTexture", kClearcoat, material);
        use(x, "clearcoatRoughnessTexture", kClearcoatRoughness, material);
        const bool coat = x.has("clearcoatNormalTexture"), base = object.has("normalTexture");
        if (coat || (base && material.data.clearcoat > 0))
            load_.warn("UNSUPPORTED_FEATURE",
                       coat ? x.at("clearcoatNormalTexture") : object.at("normalTexture"),
                       "normal maps of clear coats are not supported — the coat follows the "
                       "surface below");
    }

    /// Notes that the material uses a texture in `slot`. The textureInfo, when there is a usable
    /// one.
    std::optional<Object> use(const Object& holder, const char* key, Slot slot, Material& material)
    {
        const char* const consequence = consequenceOf(slot);
        const std::optional<Object> info = holder.softObject(key, consequence);
        if (!info) return std::nullopt;
        if (!info->has("index")) {
            load_.warn("UNDEFINED_PROPERTY", info->pointer(),
                       std::string("'index' is missing — ") + consequence);
            return std::nullopt;
        }
        const int index =
            info->softIndex("index", countOf(load_, "textures"), "textures", consequence);
        if (index < 0) return std::nullopt;

        shared::TextureReference record{};
        record.row0 = glm::vec3(1, 0, 0);
        record.row1 = glm::vec3(0, 1, 0);
        double set = info->softNumber("texCoord", 0, 0, 1e9);
        if (const auto transform = info->extension("KHR_texture_transform")) {
            set = transform->softNumber("texCoord", set, 0, 1e9);
            applyTransform(*transform, record);
        }
        if (set != 0 && set != 1) {
            load_.warn("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", info->pointer(),
                       "uses texture coordinates " + describe(set) +
                           ", only sets 0 and 1 are supported — " + consequence);
            return std::nullopt;
        }
        if (set == 1) record.flags |= shared::kTextureTexCoord1;

        const Object texture = topLevel(load_, "textures", static_cast<size_t>(index));
        const int sampler =
            texture.softIndex("sampler", countOf(load_, "samplers"), "samplers", "default sampler");
        if (sampler >= 0)
            record.flags |= samplerFlags(topLevel(load_, "samplers", static_cast<size_t>(sampler)));
        const int image =
            texture.softIndex("source", countOf(load_, "images"), "images", consequence);
        if (image < 0) {
            if (!texture.has("source"))
                load_.warn("TEXTURE_WITHOUT_SOURCE", texture.pointer(),
                           std::string("has no image that is supported — ") + consequence);
            return std::nullopt;
        }
        const int request = requestTexture({static_cast<size_t>(image), slot.color});
        material.textures[slot.index] = addUse({request, record});
        return info;
    }

    int requestTexture(const TextureRequest& request)
    {
        std::vector<TextureRequest>& requests = load_.textureRequests;
        const auto [entry, isNew] = requestIndex_.try_emplace({request.image, request.color},
                                                              static_cast<int>(requests.size()));
        if (isNew) requests.push_back(request);
        return entry->second;
    }

    int addUse(const TextureUse& use)
    {
        const shared::TextureReference& r = use.record;
        const UseKey key{static_cast<uint32_t>(use.texture), r.flags,
                         std::bit_cast<uint32_t>(r.row0.x),  std::bit_cast<uint32_t>(r.row0.y),
                         std::bit_cast<uint32_t>(r.row0.z),  std::bit_cast<uint32_t>(r.row1.x),
                         std::bit_cast<uint32_t>(r.row1.y),  std::bit_cast<uint32_t>(r.row1.z)};
        std::vector<TextureUse>& uses = load_.scene.textureUses;
        const auto [entry, isNew] = useIndex_.try_emplace(key, static_cast<int>(uses.size()));
        if (isNew) uses.push_back(use);
        return entry->second;
    }

    using UseKey = std::array<uint32_t, 8>;
    std::map<std::pair<size_t, bool>, int> requestIndex_;
    std::map<UseKey, int> useIndex_;
    Load& load_;
};

}  // namespace

MaterialPlan readMaterials(Load& load, const NodePlan& plan)
{
    const size_t count = countOf(load, "materials");
    std::vector<bool> used(count, false), seen(countOf(load, "meshes"), false);
    bool fallback = false;
    for (const MeshUse& meshUse : plan.meshUses) {
        const auto index = static_cast<size_t>(meshUse.mesh);
        if (seen[index]) continue;
        seen[index] = true;
        const Object mesh = topLevel(load, "meshes", index);
        for (size_t i = 0; i < mesh.array("primitives").size(); ++i) {
            const Object primitive = mesh.element("primitives", i);
            const std::optional<Json> value = primitive.find("material");
            const std::optional<uint64_t> material = value ? wholeNumber(*value) : std::nullopt;
            if (material && *material < count)
                used[*material] = true;
            else
                fallback = true;
        }
    }
    MaterialPlan result;
    result.sceneMaterial.assign(count, -1);
    std::vector<Material>& materials = load.scene.materials;
    const bool any = std::find(used.begin(), used.end(), true) != used.end();
    if (fallback || !any) {
        result.fallback = 0;
        materials.push_back({});
        materials.back().name = "default";
        materials.back().data = Reader::defaults();
    }
    Reader reader(load);
    for (size_t i = 0; i < count; ++i) {
        if (!used[i]) continue;
        result.sceneMaterial[i] = static_cast<int>(materials.size());
        materials.push_back(reader.read(topLevel(load, "materials", i)));
    }
    return result;
}

}  // namespace core::gltf

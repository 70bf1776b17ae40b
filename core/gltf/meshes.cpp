// From primitives of the document to meshes of the scene: only what is shown, and of it only what
// its material needs.
#include <algorithm>
#include <map>

#include "core/gltf/compression.h"
#include "core/gltf/deformation.h"
#include "core/gltf/geometry.h"
#include "core/gltf/topology.h"

namespace core::gltf {

namespace {

/// What the textures of a material ask of vertices.
struct Needs {
    bool set0 = false, set1 = false;
    const shared::TextureReference* normalMap = nullptr;  // needs tangents
};

Needs needsOf(const Scene& scene, const Material& material)
{
    Needs needs;
    for (size_t slot = 0; slot < material.textures.size(); ++slot) {
        if (material.textures[slot] < 0) continue;
        const TextureUse& use = scene.textureUses[static_cast<size_t>(material.textures[slot])];
        const bool set1 = (use.record.flags & shared::kTextureTexCoord1) != 0;
        (set1 ? needs.set1 : needs.set0) = true;
        if (slot == shared::kTextureNormal) needs.normalMap = &use.record;
    }
    return needs;
}

/// The coordinates by which a texture is looked up.
std::vector<glm::vec2> coordinatesIn(const shared::TextureReference& use, const Primitive& p)
{
    std::vector<glm::vec2> uv = (use.flags & shared::kTextureTexCoord1) != 0 ? p.uv1 : p.uv0;
    if ((use.flags & shared::kTextureTransformed) != 0)
        for (glm::vec2& c : uv)
            c = {glm::dot(use.row0, glm::vec3(c, 1)), glm::dot(use.row1, glm::vec3(c, 1))};
    return uv;
}

class Reader {
public:
    Reader(Load& load, const std::vector<Accessor>& accessors, const MaterialPlan& materials)
        : load_(load), accessors_(accessors), materials_(materials)
    {}

    std::optional<Mesh> read(const Object& primitive, const ShapeOfUse& shape)
    {
        const uint64_t mode = primitive.integer("mode", kTriangles);
        if (mode > kFan)
            load_.refuse("VALUE_NOT_IN_LIST", primitive.at("mode"),
                         "is " + std::to_string(mode) + ", must be 0..6");
        const std::optional<Object> attributes = primitive.object("attributes");
        decoded_ = decodePrimitive(load_, accessors_, primitive);
        const Accessor* position = attributes ? accessor(*attributes, "POSITION") : nullptr;
        const int indices = primitive.index("indices", accessors_.size(), "accessor");
        if (!position) {
            load_.warn("MESH_PRIMITIVE_NO_POSITION", primitive.pointer(),
                       "has no positions — skipped");
            return std::nullopt;
        }
        if (position->components != 3 || position->matrix)
            load_.refuse(
                "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", attributes->at("POSITION"),
                "has " + std::to_string(position->components) + " components, must have 3");
        if (mode < kTriangles) {
            load_.warn("PRIMITIVE_MODE_IGNORED", primitive.pointer(),
                       "is of points or lines — skipped");
            return std::nullopt;
        }
        const Accessor* source = nullptr;
        if (decoded_)
            source = &decoded_->indices;
        else if (indices >= 0)
            source = &usable(load_, accessors_, indices);
        std::optional<Topology> topology =
            readTopology(load_, primitive, decoded_ ? kTriangles : mode, source, *position);
        if (!topology) return std::nullopt;

        const int material = materialOf(primitive);
        const Needs needs =
            needsOf(load_.scene, load_.scene.materials[static_cast<size_t>(material)]);
        range_ = {topology->first, topology->count};
        Primitive p;
        p.triangles = std::move(topology->triangles);
        readVertices(*attributes, *position, needs, p);
        morph(primitive, shape.weights, p);
        repair(primitive, p, needs);
        const VertexRange range{range_.first, range_.count, position->count, std::move(p.twins)};
        Mesh mesh = packMesh(std::move(p));
        mesh.material = material;
        mesh.deformation =
            readDeformation(load_, accessors_, decoded(), primitive, range, shape, mesh);
        return mesh;
    }

private:
    struct Range {
        uint64_t first = 0, count = 0;
    };

    const Accessor* accessor(const Object& attributes, const char* name) const
    {
        return findAttribute(load_, accessors_, attributes, name, decoded());
    }

    const DecodedPrimitive* decoded() const { return decoded_ ? &*decoded_ : nullptr; }

    int materialOf(const Object& primitive)
    {
        const int index = primitive.softIndex("material", materials_.sceneMaterial.size(),
                                              "materials", "default material");
        return index < 0 ? materials_.fallback
                         : materials_.sceneMaterial[static_cast<size_t>(index)];
    }

    /// An attribute that fits the positions, or null (with a warning when it is there but wrong).
    const Accessor* attribute(const Object& attributes, const char* name, const Accessor& position,
                              std::initializer_list<uint32_t> components, const char* consequence)
    {
        const Accessor* source = accessor(attributes, name);
        if (!source) return nullptr;
        const bool shape = !source->matrix && std::find(components.begin(), components.end(),
                                                        source->components) != components.end();
        if (shape && source->count == position.count && source->componentType != kUnsignedInt)
            return source;
        load_.warn("MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", attributes.at(name),
                   "has " + std::to_string(source->count) + " elements of " +
                       std::to_string(source->components) + " components for " +
                       std::to_string(position.count) + " positions — " + consequence);
        return nullptr;
    }

    template <class T> std::vector<T> values(const Accessor& source) const
    {
        constexpr auto components = static_cast<uint32_t>(sizeof(T) / sizeof(float));
        std::vector<T> result(range_.count);
        readFloats(source, range_.first, range_.count, components, &result[0][0]);
        return result;
    }

    void readVertices(const Object& attributes, const Accessor& position, const Needs& needs,
                      Primitive& p)
    {
        load_.reserveMemory(range_.count * (sizeof(glm::vec3) + sizeof(shared::VertexAttributes) +
                                            sizeof(shared::VertexExtra) + 64),
                            attributes.pointer());
        p.positions = values<glm::vec3>(position);
        if (const Accessor* normal =
                attribute(attributes, "NORMAL", position, {3}, "flat shading instead"))
            p.normals = values<glm::vec3>(*normal);
        tolerance_ = 0.05;
        if (const Accessor* normal = accessor(attributes, "NORMAL"); normal && normal->isFloat())
            tolerance_ = 0.01;
        if (needs.set0) p.uv0 = coordinates(attributes, "TEXCOORD_0", position);
        if (needs.set1) p.uv1 = coordinates(attributes, "TEXCOORD_1", position);
        // Tangents without normals mean nothing (glTF 3.7.2.1).
        if (needs.normalMap && !p.normals.empty())
            if (const Accessor* tangent =
                    attribute(attributes, "TANGENT", position, {4}, "computed instead"))
                p.tangents = values<glm::vec4>(*tangent);
        readColors(attributes, position, p);
    }

    std::vector<glm::vec2> coordinates(const Object& attributes, const char* name,
                                       const Accessor& position)
    {
        if (const Accessor* source = attribute(attributes, name, position, {2}, "all are (0, 0)"))
            return values<glm::vec2>(*source);
        if (!attributes.has(name))
            load_.warn("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS", attributes.pointer(),
                       std::string("has no ") + name +
                           ", which a texture of its material needs — all are (0, 0)");
        return std::vector<glm::vec2>(range_.count, glm::vec2(0));
    }

    void readColors(const Object& attributes, const Accessor& position, Primitive& p)
    {
        const Accessor* color = attribute(attributes, "COLOR_0", position, {3, 4}, "white instead");
        if (!color) return;
        if (color->components == 4) {
            p.colors = values<glm::vec4>(*color);
        } else {
            const std::vector<glm::vec3> rgb = values<glm::vec3>(*color);
            p.colors.reserve(rgb.size());
            for (const glm::vec3& c : rgb) p.colors.emplace_back(c, 1.0f);
        }
        size_t bad = 0;
        bool white = true;
        for (glm::vec4& c : p.colors) {
            if (!(c.r >= 0 && c.g >= 0 && c.b >= 0 && c.a >= 0 && c.r + c.g + c.b + c.a < 1e30f)) {
                ++bad;
                c = glm::vec4(1);
            }
            white = white && c == glm::vec4(1);
        }
        if (bad > 0)
            load_.warn("ACCESSOR_INVALID_FLOAT", attributes.at("COLOR_0"),
                       std::to_string(bad) + " colours are negative or not finite — white instead");
        if (white) p.colors.clear();
    }

    /// Adds the weighted morph targets. Attributes other than positions, normals and tangents stay.
    void morph(const Object& primitive, const std::vector<double>& weights, Primitive& p)
    {
        const size_t targets = primitive.array("targets").size();
        for (size_t i = 0; i < targets && i < weights.size(); ++i) {
            const Object target = primitive.element("targets", i);
            if (weights[i] == 0) continue;
            load_.checkpoint();
            const auto weight = static_cast<float>(weights[i]);
            addTarget(target, "POSITION", weight, p.positions);
            if (!p.normals.empty()) addTarget(target, "NORMAL", weight, p.normals);
            if (p.tangents.empty()) continue;
            std::vector<glm::vec3> directions(p.tangents.size(), glm::vec3(0));
            addTarget(target, "TANGENT", weight, directions);
            for (size_t v = 0; v < directions.size(); ++v)
                p.tangents[v] += glm::vec4(directions[v], 0);
        }
        morphed_ = std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0; });
    }

    void addTarget(const Object& target, const char* name, float weight, std::vector<glm::vec3>& to)
    {
        const Accessor* source = findAttribute(load_, accessors_, target, name);
        if (!source) return;
        if (source->components != 3 || source->matrix ||
            source->count < range_.first + range_.count) {
            load_.warn("MESH_PRIMITIVE_MORPH_TARGET_INVALID", target.at(name),
                       "does not fit the mesh — ignored");
            return;
        }
        if (!source->hasData()) return;  // zeros: a small file can have very many of them
        const std::vector<glm::vec3> offsets = values<glm::vec3>(*source);
        for (size_t v = 0; v < to.size(); ++v) to[v] += weight * offsets[v];
    }

    void repair(const Object& primitive, Primitive& p, const Needs& needs)
    {
        if (const size_t dropped = dropNonFinite(p))
            load_.warn(
                "ACCESSOR_INVALID_FLOAT", primitive.pointer(),
                std::to_string(dropped) +
                    " triangles have positions that are not finite or beyond 1e18 — dropped");
        size_t rescaled = 0;
        const size_t replaced = repairNormals(p, tolerance_, rescaled);
        if (replaced > 0)
            load_.warn("ACCESSOR_INVALID_FLOAT", primitive.at("attributes") + "/NORMAL",
                       std::to_string(replaced) +
                           " normals are zero or not finite — those of the faces instead");
        if (rescaled > 0 && !morphed_)
            load_.warn("ACCESSOR_VECTOR3_NON_UNIT", primitive.at("attributes") + "/NORMAL",
                       std::to_string(rescaled) + " normals are not of unit length — normalised");
        if (!needs.normalMap) return;
        const bool given = !p.tangents.empty();
        // From the coordinates as the map is laid over the surface: turned with them, its bumps
        // would be lit from elsewhere.
        if (!given) makeTangents(p, coordinatesIn(*needs.normalMap, p));
        const size_t bad = repairTangents(p);
        // Computed ones may be undefined, where the coordinates are: that is no fault of the file.
        if (given && bad > 0)
            load_.warn("ACCESSOR_VECTOR3_NON_UNIT", primitive.at("attributes") + "/TANGENT",
                       std::to_string(bad) +
                           " tangents have no direction or handedness — replaced");
    }

    Load& load_;
    const std::vector<Accessor>& accessors_;
    const MaterialPlan& materials_;
    std::optional<DecodedPrimitive> decoded_;  // of the primitive that is read
    Range range_;
    double tolerance_ = 0.01;
    bool morphed_ = false;
};

/// Every primitive must at least refer to things that exist, also in meshes that are not shown.
void checkReferences(const Object& mesh, size_t accessorCount, size_t viewCount)
{
    for (size_t i = 0; i < mesh.array("primitives").size(); ++i) {
        const Object primitive = mesh.element("primitives", i);
        primitive.index("indices", accessorCount, "accessor");
        const auto check = [&](const Object& attributes) {
            for (size_t k = 0; k < attributes.json().size(); ++k)
                attributes.index(attributes.json().member(k).key->c_str(), accessorCount,
                                 "accessor");
        };
        if (const std::optional<Object> attributes = primitive.object("attributes"))
            check(*attributes);
        for (size_t k = 0; k < primitive.array("targets").size(); ++k)
            check(primitive.element("targets", k));
        if (const std::optional<Object> draco = primitive.extension("KHR_draco_mesh_compression"))
            draco->requiredIndex("bufferView", viewCount, "bufferView");
    }
}

/// What renderers store for a node's uses of a mesh, counted before it is made: triangles of their
/// own, or if that is more and none is the `first`, instances. (A world that writes out a few all
/// the same is not much larger.)
void reserveUses(Load& load, const MeshUse& use, IndexRange meshes, bool first)
{
    constexpr uint64_t kTriangleBytes = 16 + 100;  // with its part of a hierarchy
    constexpr uint64_t kVertexBytes = sizeof(glm::vec3) + sizeof(shared::VertexAttributes);
    constexpr uint64_t kInstanceBytes = 400;
    uint64_t bytes = 0;
    bool instanced = load.options.instancing != Instancing::flat;
    for (uint32_t index = meshes.begin; index < meshes.end; ++index) {
        const Mesh& mesh = load.scene.meshes[index];
        bytes += kTriangleBytes * mesh.triangles.size() + kVertexBytes * mesh.positions.size();
        instanced = instanced && !mesh.deformation;
    }
    const std::string where = child("/meshes", static_cast<size_t>(use.mesh));
    const int placements = load.scene.nodes[static_cast<size_t>(use.node)].placements;
    uint64_t uses =
        placements < 0 ? 1 : load.scene.placements[static_cast<size_t>(placements)].size();
    if (uses > 0 && (first || !instanced)) {
        load.reserveMemory(bytes, where);
        --uses;
    }
    const uint64_t each = instanced ? std::min(bytes, kInstanceBytes) : bytes;
    const bool overflows = each > 0 && uses > (uint64_t(1) << 62) / each;
    load.reserveMemory(overflows ? ~uint64_t(0) >> 1 : uses * each, where);
}

}  // namespace

void readMeshes(Load& load, const std::vector<Accessor>& accessors, const NodePlan& plan,
                const MaterialPlan& materials)
{
    const size_t views = countOf(load, "bufferViews");
    for (size_t i = 0; i < countOf(load, "meshes"); ++i)
        checkReferences(topLevel(load, "meshes", i), accessors.size(), views);
    Reader reader(load, accessors, materials);
    const std::map<int, const AnimationChannel*> channels = weightChannels(load.scene);
    std::map<std::pair<int, ShapeOfUse>, IndexRange> made;
    const size_t uses = plan.meshUses.size();
    for (size_t u = 0; u < uses; ++u) {
        const MeshUse& use = plan.meshUses[u];
        const ShapeOfUse shape = shapeOf(load.scene, channels, plan, use);
        const auto [entry, isNew] = made.try_emplace({use.mesh, shape});
        if (isNew) {
            load.stage("meshes", static_cast<double>(u) / static_cast<double>(uses));
            entry->second.begin = static_cast<uint32_t>(load.scene.meshes.size());
            const Object source = topLevel(load, "meshes", static_cast<size_t>(use.mesh));
            const std::string name = source.name();
            const size_t count = source.array("primitives").size();
            if (count == 0)
                load.warn("EMPTY_ENTITY", source.pointer(), "has no primitives — skipped");
            for (size_t i = 0; i < count; ++i) {
                load.checkpoint();
                std::optional<Mesh> mesh = reader.read(source.element("primitives", i), shape);
                if (!mesh) continue;
                mesh->name = name;
                load.scene.meshes.push_back(std::move(*mesh));
            }
            entry->second.end = static_cast<uint32_t>(load.scene.meshes.size());
        }
        checkJoints(load, use, entry->second);
        reserveUses(load, use, entry->second, isNew);
        load.scene.nodes[static_cast<size_t>(use.node)].meshes = entry->second;
    }
}

}  // namespace core::gltf

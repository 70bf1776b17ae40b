// KHR_draco_mesh_compression: what a primitive's accessors say against what its stream holds.
#include "core/gltf/compression.h"
#include "core/gltf/draco_mesh.h"
#include "core/gltf/geometry.h"

namespace core::gltf {

namespace {

constexpr const char* kExtension = "KHR_draco_mesh_compression";

/// An attribute that is in the stream and that the primitive has.
struct Wanted {
    std::string name;
    uint32_t id = 0;
    const Accessor* accessor = nullptr;
};

std::vector<Wanted> wantedOf(Load& load, const std::vector<Accessor>& accessors,
                             const Object& attributes, const Object& compressed)
{
    std::vector<Wanted> result;
    for (size_t i = 0; i < compressed.json().size(); ++i) {
        const char* name = compressed.json().member(i).key->c_str();
        const uint64_t id = compressed.requiredInteger(name);
        if (id > std::numeric_limits<uint32_t>::max())
            load.refuse("VALUE_NOT_IN_RANGE", compressed.at(name),
                        "is " + std::to_string(id) + ", must be less than 2^32");
        const int index = attributes.index(name, accessors.size(), "accessor");
        if (index < 0) {
            load.warn("UNRESOLVED_REFERENCE", compressed.at(name),
                      "is no attribute of the primitive — ignored");
            continue;
        }
        result.push_back({name, static_cast<uint32_t>(id), &usable(load, accessors, index)});
    }
    return result;
}

/// Refuses a stream that has more than the accessors say: sizes are judged by theirs, and what else
/// belongs to the vertices has as many.
void requireAtMost(Load& load, const Object& extension, const char* what, uint64_t found,
                   uint64_t stated)
{
    if (found > stated)
        load.refuse("COMPRESSED_COUNT_MISMATCH", extension.pointer(),
                    "has " + std::to_string(found) + ' ' + what + ", the accessors say " +
                        std::to_string(stated));
}

Accessor accessorOver(const void* data, uint64_t count, uint32_t componentType,
                      uint32_t components = 1)
{
    Accessor result;
    result.count = count;
    result.componentType = componentType;
    result.components = components;
    result.data = static_cast<const std::byte*>(data);
    result.stride = result.elementBytes();
    return result;
}

/// The accessor that takes the place of `stated`. What the stream says of its type counts.
Accessor replaced(Load& load, const Object& compressed, const Wanted& wanted,
                  const DracoAttribute& decoded, uint64_t points)
{
    if (!decoded.found)
        load.refuse("UNRESOLVED_REFERENCE", compressed.at(wanted.name),
                    "refers to attribute " + std::to_string(wanted.id) +
                        ", which the compressed data does not have");
    if (decoded.componentType == 0)
        load.refuse("VALUE_NOT_IN_LIST", compressed.at(wanted.name),
                    "has numbers of a type that glTF does not have");
    const Accessor& stated = *wanted.accessor;
    Accessor result =
        accessorOver(decoded.values.data(), points, decoded.componentType, decoded.components);
    const bool sameType = decoded.componentType == stated.componentType;
    result.normalized = sameType ? stated.normalized : decoded.normalized;
    if (!sameType)
        load.warn("COMPRESSED_TYPE_MISMATCH", compressed.at(wanted.name),
                  "is of type " + std::to_string(decoded.componentType) +
                      " in the compressed data, its accessor says " +
                      std::to_string(stated.componentType) + " — read as it is compressed");
    return result;
}

/// How many triangles the accessor of the indices allows.
uint64_t mostFaces(const Accessor* indices, uint64_t mode)
{
    if (!indices) return std::numeric_limits<uint32_t>::max() / 3;  // the memory limit judges
    if (mode == kTriangles) return indices->count / 3;
    return indices->count - std::min<uint64_t>(indices->count, 2);  // of the strip it once was
}

class Decoding {
public:
    Decoding(Load& load, const std::vector<Accessor>& accessors, const Object& primitive,
             const Object& extension)
        : load_(load), accessors_(accessors), primitive_(primitive), extension_(extension)
    {}

    DecodedPrimitive run(const Object& attributes)
    {
        const Object compressed = requireAttributes();
        const std::vector<Wanted> wanted = wantedOf(load_, accessors_, attributes, compressed);
        if (const int position = attributes.index("POSITION", accessors_.size(), "accessor");
            position >= 0)
            mostPoints_ = usable(load_, accessors_, position).count;
        for (const Wanted& w : wanted) mostPoints_ = std::min(mostPoints_, w.accessor->count);
        const int index = primitive_.index("indices", accessors_.size(), "accessor");
        const Accessor* indices = index < 0 ? nullptr : &usable(load_, accessors_, index);
        const uint64_t mode = primitive_.integer("mode", kTriangles);
        mostFaces_ = mostFaces(indices, mode);

        DracoMesh mesh = decode(wanted);
        DecodedPrimitive result;
        result.indexValues = std::move(mesh.indices);
        result.indices =
            accessorOver(result.indexValues.data(), result.indexValues.size(), kUnsignedInt);
        for (size_t i = 0; i < wanted.size(); ++i) {
            const Wanted& w = wanted[i];
            DracoAttribute& decoded = mesh.attributes[i];
            result.attributes[w.name] = replaced(load_, compressed, w, decoded, mesh.points);
            result.attributeValues.push_back(std::move(decoded.values));
        }
        const bool fewerFaces =
            indices && mode == kTriangles && result.indices.count / 3 < indices->count / 3;
        if (fewerFaces || (!wanted.empty() && mesh.points < mostPoints_))
            load_.warn("COMPRESSED_COUNT_MISMATCH", extension_.pointer(),
                       "has " + std::to_string(result.indices.count / 3) + " triangles and " +
                           std::to_string(mesh.points) +
                           " vertices, less than the accessors say — taken as it is");
        return result;
    }

private:
    Object requireAttributes() const
    {
        const std::optional<Object> compressed = extension_.object("attributes");
        if (!compressed)
            load_.refuse("UNDEFINED_PROPERTY", extension_.pointer(), "'attributes' is missing");
        return *compressed;
    }

    DracoMesh decode(const std::vector<Wanted>& wanted)
    {
        const int view =
            extension_.requiredIndex("bufferView", countOf(load_, "bufferViews"), "bufferView");
        const std::span<const std::byte> bytes = bufferViewBytes(load_, static_cast<size_t>(view));
        std::vector<uint32_t> ids;
        for (const Wanted& w : wanted) ids.push_back(w.id);
        // What decoding takes for a while counts only until it is done; what is decoded stays.
        const uint64_t before = load_.memoryBytes;
        DracoMesh mesh = decodeDraco(bytes, ids, [this](const DracoSizes& sizes) { judge(sizes); });
        load_.memoryBytes = before;
        if (!mesh.problem.empty())
            load_.refuse("COMPRESSED_DATA_INVALID", extension_.pointer(), mesh.problem);
        uint64_t kept = sizeof(uint32_t) * mesh.indices.size();
        for (const DracoAttribute& attribute : mesh.attributes) kept += attribute.values.size();
        load_.reserveMemory(kept, extension_.pointer());
        return mesh;
    }

    void judge(const DracoSizes& sizes)
    {
        load_.checkpoint();
        requireAtMost(load_, extension_, "triangles", sizes.faces, mostFaces_);
        requireAtMost(load_, extension_, "vertices", sizes.points, mostPoints_);
        load_.reserveMemory(sizes.bytes, extension_.pointer());
    }

    Load& load_;
    const std::vector<Accessor>& accessors_;
    const Object& primitive_;
    const Object& extension_;
    uint64_t mostFaces_ = 0, mostPoints_ = std::numeric_limits<uint32_t>::max();
};

}  // namespace

std::optional<DecodedPrimitive> decodePrimitive(Load& load, const std::vector<Accessor>& accessors,
                                                const Object& primitive)
{
    const std::optional<Object> extension = primitive.extension(kExtension);
    const uint64_t mode = primitive.integer("mode", kTriangles);
    if (!extension || mode < kTriangles) return std::nullopt;
    if (mode > kStrip)
        load.refuse("VALUE_NOT_IN_LIST", primitive.at("mode"),
                    "is " + std::to_string(mode) + ", must be 4 or 5 with " + kExtension);
    const std::optional<Object> attributes = primitive.object("attributes");
    if (!attributes) return std::nullopt;
    return Decoding(load, accessors, primitive, *extension).run(*attributes);
}

const Accessor* findAttribute(Load& load, const std::vector<Accessor>& accessors,
                              const Object& attributes, const std::string& name,
                              const DecodedPrimitive* decoded)
{
    if (decoded != nullptr)
        if (const auto found = decoded->attributes.find(name); found != decoded->attributes.end())
            return &found->second;
    const int index = attributes.index(name.c_str(), accessors.size(), "accessor");
    return index < 0 ? nullptr : &usable(load, accessors, index);
}

}  // namespace core::gltf

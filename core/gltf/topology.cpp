// See topology.h.
#include "core/gltf/topology.h"

#include <algorithm>
#include <limits>

#include "core/gltf/geometry.h"

namespace core::gltf {

namespace {

void warnIncomplete(Load& load, const Object& primitive, uint64_t mode, uint64_t count)
{
    const bool complete = mode == kTriangles ? count % 3 == 0 : count >= 3;
    if (!complete)
        load.warn("MESH_PRIMITIVE_INCOMPATIBLE_MODE", primitive.pointer(),
                  "has " + std::to_string(count) +
                      " vertices, which are no whole triangles — the rest is dropped");
}

void requireIndices(Load& load, const Object& primitive, const Accessor& indices)
{
    const bool unsignedType = indices.componentType == kUnsignedByte ||
                              indices.componentType == kUnsignedShort ||
                              indices.componentType == kUnsignedInt;
    if (unsignedType && indices.components == 1 && !indices.normalized) return;
    load.refuse("MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT", primitive.at("indices"),
                "must be an accessor of unsigned integer scalars");
}

/// Where the largest index stands may be in a compressed stream: the primitive is named then.
void requireVertices(Load& load, const Object& primitive, const Accessor& indices,
                     const std::vector<uint32_t>& values, uint64_t vertices)
{
    const auto high = std::max_element(values.begin(), values.end());
    const std::string what =
        "index " + std::to_string(high - values.begin()) + " is " + std::to_string(*high);
    const std::optional<Json> accessor = primitive.find("indices");
    const std::string where = accessor
                                  ? child("/accessors", size_t(wholeNumber(*accessor).value_or(0)))
                                  : primitive.pointer();
    if (*high >= vertices)
        load.refuse("ACCESSOR_INDEX_OOB", where,
                    what + ", there are " + std::to_string(vertices) + " vertices");
    if (*high == restartIndex(indices))
        load.refuse("ACCESSOR_INDEX_PRIMITIVE_RESTART", where,
                    what + ", which means a restart and no vertex of this type");
}

}  // namespace

std::optional<Topology> readTopology(Load& load, const Object& primitive, uint64_t mode,
                                     const Accessor* indices, const Accessor& position)
{
    Topology result;
    if (!indices) {
        if (position.count > std::numeric_limits<uint32_t>::max())
            load.refuse("ACCESSOR_TOO_LONG", primitive.pointer(), "has more than 2^32 vertices");
        load.reserveMemory(12 * position.count, primitive.pointer());
        warnIncomplete(load, primitive, mode, position.count);
        result.triangles = assembleTriangles(mode, nullptr, position.count);
        result.count = position.count;
    } else {
        requireIndices(load, primitive, *indices);
        load.reserveMemory(16 * indices->count, primitive.pointer());
        const std::vector<uint32_t> values = readIndices(*indices);
        requireVertices(load, primitive, *indices, values, position.count);
        warnIncomplete(load, primitive, mode, values.size());
        const auto [low, high] = std::minmax_element(values.begin(), values.end());
        result.first = *low;
        result.count = *high - *low + 1;
        result.triangles = assembleTriangles(mode, values.data(), values.size());
        if (result.first > 0)
            for (glm::uvec3& t : result.triangles)
                t -= glm::uvec3(static_cast<uint32_t>(result.first));
    }
    if (result.triangles.empty()) return std::nullopt;
    return result;
}

}  // namespace core::gltf

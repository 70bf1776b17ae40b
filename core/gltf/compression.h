// Geometry that a file stores compressed: buffer views by meshoptimizer, primitives by Draco. What
// is decoded takes the place of bytes and accessors, so that the rest of the loader need not know.
#pragma once

#include <map>

#include "core/gltf/accessors.h"
#include "core/gltf/json.h"

namespace core::gltf {

/// EXT_meshopt_compression of a buffer view, or KHR_meshopt_compression; nothing without either.
std::optional<Object> meshoptOf(const Object& view);

/// Per buffer, whether compressed views alone refer to it: what it would hold is in another buffer,
/// too, so that it is neither read nor missed.
std::vector<bool> fallbackBuffers(Load& load);

/// Decodes all compressed buffer views into load.decodedViews. Refuses what breaks the extension's
/// rules or cannot be decoded.
void decodeViews(Load& load);

/// A primitive out of KHR_draco_mesh_compression.
struct DecodedPrimitive {
    Accessor indices;  // of a list of triangles, whatever the primitive's mode
    std::map<std::string, Accessor, std::less<>> attributes;  // by name; not all need be here
    std::vector<uint32_t> indexValues;                        // what the accessors point into
    std::vector<Bytes> attributeValues;
};

/// Decodes a primitive that has the extension; nothing for one without it, and for points and
/// lines. Refuses what cannot be decoded, has more triangles or vertices than its accessors say, or
/// needs more memory than allowed.
std::optional<DecodedPrimitive> decodePrimitive(Load& load, const std::vector<Accessor>& accessors,
                                                const Object& primitive);

/// An attribute by its name, null where there is none: out of `decoded`, where that is given and
/// has it, or as the file stores it. Morph targets are stored always.
const Accessor* findAttribute(Load& load, const std::vector<Accessor>& accessors,
                              const Object& attributes, const std::string& name,
                              const DecodedPrimitive* decoded = nullptr);

}  // namespace core::gltf

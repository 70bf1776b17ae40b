// Draco's bitstreams, apart from glTF: bytes in, triangles and arrays out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace core::gltf {

/// What a stream says about itself, before memory is taken for it. `points` are 0 until its
/// triangles are known.
struct DracoSizes {
    uint64_t faces = 0, points = 0;
    uint64_t bytes = 0;  // of memory that the next step of decoding takes, at most
};

/// Asked before each step. It may throw, which ends decoding.
using DracoGuard = std::function<void(const DracoSizes&)>;

/// One attribute, an element per point, tightly packed.
struct DracoAttribute {
    uint32_t componentType = 0;  // glTF's; 0: one that it does not have
    uint32_t components = 0;
    bool normalized = false;
    bool found = false;
    std::vector<std::byte> values;
};

struct DracoMesh {
    std::string problem;  // not empty: it could not be decoded
    uint64_t points = 0;
    std::vector<uint32_t> indices;           // three per triangle, all below `points`
    std::vector<DracoAttribute> attributes;  // parallel to the ids asked for
};

/// Decodes a mesh of bitstream version 2.2, the only one that glTF allows, and copies the
/// attributes of these unique ids. Throws what `guard` throws, and std::bad_alloc.
DracoMesh decodeDraco(std::span<const std::byte> bytes, std::span<const uint32_t> ids,
                      const DracoGuard& guard);

}  // namespace core::gltf

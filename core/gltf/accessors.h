// Buffers, buffer views and accessors: resolved, checked once in 64 bits, then read without further
// checks.
#pragma once

#include <span>
#include <vector>

#include "core/gltf/json.h"
#include "core/gltf/load.h"

namespace core::gltf {

enum ComponentType : uint32_t {
    kByte = 5120,
    kUnsignedByte = 5121,
    kShort = 5122,
    kUnsignedShort = 5123,
    kUnsignedInt = 5125,
    kFloat = 5126,
};

/// A typed view of bytes that are known to be there.
struct Accessor {
    // A type that this loader does not know is refused where it is used: what is wrong, and with
    // which member.
    std::string problem, problemAt;
    uint64_t count = 0;
    uint32_t componentType = kFloat;
    uint32_t components = 1;  // 1..4, 4, 9, 16
    bool matrix = false;
    bool normalized = false;
    const std::byte* data = nullptr;  // null: zeros
    size_t stride = 0;

    // Sparse replacement: `sparseCount` elements, ascending indices.
    uint64_t sparseCount = 0;
    uint32_t sparseType = kUnsignedInt;
    const std::byte* sparseIndices = nullptr;
    const std::byte* sparseValues = nullptr;

    uint32_t elementBytes() const;
    bool isFloat() const { return componentType == kFloat; }
    /// False when there is no buffer view, so that every element is zero.
    bool hasData() const { return data != nullptr || sparseCount > 0; }
};

/// Reads every buffer of the document into load.buffers, except those whose content is compressed
/// in another. Refuses what is missing, outside or too short.
void readBuffers(Load& load);

/// What `buffer`, `byteOffset` and `byteLength` stand for, of a buffer view or of an extension on
/// one. Refuses bad references and extents.
std::span<const std::byte> bufferBytes(Load& load, const Object& place);

/// The bytes of buffer view `index` (of any use), decoded if they are compressed. Refuses bad
/// references and extents.
std::span<const std::byte> bufferViewBytes(Load& load, size_t index);

/// Reads and checks all accessors of the document.
std::vector<Accessor> readAccessors(Load& load);

/// Accessor `index`, to be read. Refuses one of an unknown type, which may stand in a file as long
/// as nothing uses it.
const Accessor& usable(const Load& load, const std::vector<Accessor>& accessors, int index);

/// Elements [first, first + count) as floats, `components` of each (the accessor has at least so
/// many); normalised integers become [0,1] or [-1,1], others keep their value.
void readFloats(const Accessor& accessor, uint64_t first, uint64_t count, uint32_t components,
                float* out);

/// The largest number of the type, which glTF forbids as an index: graphics interfaces take it for
/// the end of a strip.
uint32_t restartIndex(const Accessor& accessor);

/// All elements of a scalar accessor of unsigned integers.
std::vector<uint32_t> readIndices(const Accessor& accessor);

}  // namespace core::gltf

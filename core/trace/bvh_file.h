// A hierarchy as bytes, for files of a cache: what tells whose it is, how it is written and read.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/trace/bvh.h"

namespace core {

/// To be raised whenever buildBvh makes something else of the same triangles, or these bytes mean
/// something else. bvh_file_test notices most such changes.
constexpr uint32_t kBvhFileVersion = 1;

/// Everything that a hierarchy follows from: equal for equal triangles and options of the same
/// builder.
struct BvhKey {
    uint32_t version = kBvhFileVersion, nodeBytes = 2 * sizeof(shared::uvec4);
    uint64_t layout = 0;  // hash of what references are made of, and of the compiler
    uint64_t positions = 0, triangles = 0;  // how many
    uint64_t contents = 0;                  // hash of them and of the options
};
static_assert(sizeof(BvhKey) == 40);  // no padding: its bytes are the key

BvhKey bvhKey(std::span<const glm::vec3> positions, std::span<const WorldTriangle> triangles,
              const BvhOptions& options);

uint64_t bvhByteCount(const Bvh& bvh);
std::vector<std::byte> bvhBytes(const Bvh& bvh);

/// What bvhBytes made into these bytes: equal in every bit. Nothing when they are no hierarchy over
/// these triangles (isSound), whatever else they may be.
std::optional<Bvh> bvhFromBytes(std::span<const std::byte> bytes,
                                std::span<const glm::vec3> positions,
                                std::span<const WorldTriangle> triangles,
                                const BvhOptions& options);

}  // namespace core

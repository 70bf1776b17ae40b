// See reuse_motion.h.
#include "app/gpu/reuse_motion.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "core/base/check.h"

namespace gpu {

namespace {

std::vector<glm::uvec4> wordsOf(std::span<const shared::MovedPiece> pieces)
{
    std::vector<glm::uvec4> words;
    const auto word = [](glm::vec3 v, uint32_t w) {
        return glm::uvec4(std::bit_cast<uint32_t>(v.x), std::bit_cast<uint32_t>(v.y),
                          std::bit_cast<uint32_t>(v.z), w);
    };
    for (const shared::MovedPiece& piece : pieces) {
        words.push_back(word(piece.low, piece.first));
        words.push_back(word(piece.high, piece.count));
    }
    return words;
}

/// The slot in `now` of the triangle in each slot of `before`: both hold the same triangles, each
/// of them once. Buffers have a multiple of four words, and at least four: what lies behind stays
/// where it is.
std::vector<uint32_t> slotsNow(const core::SharedArray<uint32_t>& before,
                               const core::SharedArray<uint32_t>& now, core::IndexRange triangles)
{
    std::vector<uint32_t> slotOf(triangles.size(), shared::kNone);
    std::vector<uint32_t> slots(std::max<size_t>((before.size() + 3) / 4 * 4, 4));
    std::iota(slots.begin(), slots.end(), 0u);
    for (uint32_t slot = 0; slot < now.size(); ++slot) slotOf[now[slot] - triangles.begin] = slot;
    for (size_t slot = 0; slot < before.size(); ++slot)
        slots[slot] = slotOf[before[slot] - triangles.begin];
    return slots;
}

}  // namespace

bool ReuseMotion::take(const GpuScene& scene, const core::World& before,
                       const core::Bvh& hierarchyBefore, std::span<const shared::MovedPiece> pieces,
                       std::span<DescriptorSet* const> sets)
{
    rest();
    const core::Bvh& now = scene.hierarchy();
    // By value: who builds the whole anew finds the same order in what rests.
    if (!(now.still.slots == hierarchyBefore.still.slots) ||
        now.moving.slots.size() != hierarchyBefore.moving.slots.size())
        return false;
    // Kernels ask where triangles are now only if something has moved.
    if (pieces.empty()) return now.moving.slots == hierarchyBefore.moving.slots;
    CHECK(pieces.size() <= shared::kMostMovedPieces);
    constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
    constexpr uint64_t kPieceBytes = shared::kMovedPieceWords * sizeof(glm::uvec4);
    room(shared::kBindMovedPieces, pieces_, shared::kMostMovedPieces * kPieceBytes, kWords, sets)
        .writeAll(wordsOf(pieces));
    constexpr uint64_t kTriangleBytes = 3 * sizeof(glm::vec4);
    scene.writeMovingTriangles(before, room(shared::kBindTrianglesBefore, trianglesBefore_,
                                            now.moving.slots.size() * kTriangleBytes,
                                            VK_FORMAT_R32G32B32A32_SFLOAT, sets));
    const std::vector<uint32_t> slots =
        slotsNow(hierarchyBefore.moving.slots, now.moving.slots, before.movingTriangles);
    room(shared::kBindSlotsNow, slotsNow_, slots.size() * sizeof(uint32_t), VK_FORMAT_R32_UINT,
         sets)
        .writeAll(slots);
    count_ = static_cast<uint32_t>(pieces.size());
    return true;
}

/// A buffer of so many bytes in place of `buffer`, or the same if it has just these: kernels ask
/// for its size.
Buffer& ReuseMotion::room(uint32_t binding, Buffer& buffer, uint64_t bytes, VkFormat format,
                          std::span<DescriptorSet* const> sets)
{
    const uint64_t rounded = std::max<uint64_t>((bytes + 15) & ~uint64_t(15), 16);
    if (buffer.bytes() != rounded) {
        buffer = {};
        buffer = Buffer(device_, "what has moved", bytes, format);
        for (DescriptorSet* set : sets)
            if (set->knows(binding)) set->bind(binding, buffer);
    }
    return buffer;
}

}  // namespace gpu

#include "app/gpu/guided_buffers.h"

#include <algorithm>
#include <bit>

#include "core/base/check.h"

namespace gpu {

namespace {

// Most guides stay below: a buffer of another size makes Mesa's software device compile the kernels
// again.
constexpr uint64_t kNodeBytes = 1u << 16, kLeafBytes = 1u << 16, kDirectionBytes = 1u << 22;

/// Coordinates of the lane of a tile along the Morton curve (frame.glsl).
glm::uvec2 placeInTile(uint32_t lane)
{
    glm::uvec2 at(0);
    for (uint32_t bit = 0; bit < 3; ++bit) {
        at.x |= ((lane >> (2 * bit)) & 1u) << bit;
        at.y |= ((lane >> (2 * bit + 1)) & 1u) << bit;
    }
    return at;
}

}  // namespace

void GuidedBuffers::grow(Buffer& buffer, uint32_t binding, const char* name, uint64_t bytes,
                         VkFormat format, PathBatches& batches)
{
    if (buffer.bytes() >= bytes) return;
    buffer = {};
    buffer = Buffer(context_.device, name, std::bit_ceil(bytes), format);
    batches.bind(binding, buffer);
}

void GuidedBuffers::makeRoom(const Frame& frame, PathBatches& batches)
{
    const uint64_t pixels = uint64_t(frame.width()) * frame.height();
    grow(estimates_, shared::kBindPixelEstimates, "the pixels' estimates",
         std::max<uint64_t>(pixels * sizeof(float), 1u << 18), VK_FORMAT_R32G32B32A32_SFLOAT,
         batches);
    grow(states_, shared::kBindGuidedStates, "the states of guided paths",
         batches.mostLanes() * sizeof(shared::GuidedState), VK_FORMAT_UNDEFINED, batches);
    grow(records_, shared::kBindGuideRecords, "the guide's records",
         uint64_t(kMostRecorded) * shared::kGuideVertices * sizeof(shared::GuideRecord),
         VK_FORMAT_UNDEFINED, batches);
    grow(ends_, shared::kBindPathEnds, "the guide's paths",
         kMostRecorded * sizeof(shared::GuidePathEnd), VK_FORMAT_UNDEFINED, batches);
    zeros_.assign(pixels, 0.0f);
    setEstimates({});
}

void GuidedBuffers::setGuide(const core::guiding::GuideTables& tables, PathBatches& batches)
{
    constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
    const auto put = [&](Buffer& buffer, uint32_t binding, const char* name, VkFormat format,
                         uint64_t least, const auto& items) {
        grow(buffer, binding, name, std::max(least, std::span(items).size_bytes()), format,
             batches);
        buffer.writeAll(items);
    };
    const bool isTree = tables.kind == shared::kGuideTree;  // directions are among the nodes
    put(nodes_, shared::kBindGuideNodes, "the guide's nodes", kWords,
        isTree ? kDirectionBytes : kNodeBytes, tables.nodes);
    put(leaves_, shared::kBindGuideLeaves, "the guide's leaves", kWords, kLeafBytes, tables.leaves);
    put(directions_, shared::kBindGuideDirections, "the guide's directions",
        VK_FORMAT_R32G32B32A32_SFLOAT, kDirectionBytes, tables.directions);
}

void GuidedBuffers::setEstimates(std::span<const float> estimates)
{
    estimates_.write(std::as_bytes(estimates.empty() ? std::span<const float>(zeros_) : estimates));
}

void GuidedBuffers::collect(const Frame& frame, const shared::Batch& batch,
                            std::span<core::guiding::PathRecords> records)
{
    const uint32_t stride = shared::recordStride(frame.data().settings);
    if (stride == 0) return;
    const uint32_t perTile = shared::kGroupSize / stride;
    const uint32_t paths = batch.tileCount * batch.sampleCount * perTile;
    CHECK(paths <= kMostRecorded);
    readEnds_.resize(paths);
    readRecords_.resize(size_t(paths) * shared::kGuideVertices);
    ends_.read(std::as_writable_bytes(std::span(readEnds_)));
    records_.read(std::as_writable_bytes(std::span(readRecords_)));
    const uint32_t tilesPerRow = frame.data().tilesPerRow;
    for (uint32_t i = 0; i < batch.tileCount; ++i) {
        const uint32_t tile = batch.firstTile + i;
        const glm::uvec2 corner = 8u * glm::uvec2(tile % tilesPerRow, tile / tilesPerRow);
        core::guiding::PathRecords& out = records[tile];
        for (uint32_t s = 0; s < batch.sampleCount; ++s) {
            const uint32_t first = (0u - (batch.firstSample + s)) & (stride - 1);
            for (uint32_t r = 0; r < perTile; ++r) {
                const glm::uvec2 pixel = corner + placeInTile(r * stride + first);
                if (pixel.x >= frame.width() || pixel.y >= frame.height()) continue;
                const size_t slot = (size_t(s) * batch.tileCount + i) * perTile + r;
                const shared::GuidePathEnd end = readEnds_[slot];
                if (end.count == 0) continue;
                out.ends.push_back(end);
                const auto at =
                    readRecords_.begin() + std::ptrdiff_t(slot * shared::kGuideVertices);
                out.records.insert(out.records.end(), at, at + end.count);
            }
        }
    }
}

}  // namespace gpu

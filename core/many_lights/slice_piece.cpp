// See slice_piece.h.
#include "core/many_lights/slice_piece.h"

#include <algorithm>
#include <bit>

namespace core::many_lights {

namespace {

/// Entries of a piece: some milliseconds of a slow device.
constexpr uint32_t kPieceEntries = 1u << 20, kExtendedEntries = kPieceEntries / 16;

static_assert(uint32_t(LightKind::surface) == shared::kVirtualSurface &&
              uint32_t(LightKind::point) == shared::kVirtualPoint &&
              uint32_t(LightKind::directional) == shared::kVirtualDirectional);
static_assert(uint32_t(LightShape::point) == shared::kLightShapePoint &&
              uint32_t(LightShape::sphere) == shared::kLightShapeSphere &&
              uint32_t(LightShape::disc) == shared::kLightShapeDisc);

shared::ReceiverRecord packReceiver(const ReceiverJob& job, const Receiver& r)
{
    const uint32_t frame = shared::hashUint(job.frame ^ shared::hashUint(job.settings.seed));
    return {r.direction,
            r.slot,
            r.barycentrics,
            r.events,
            shared::hashUint(r.place ^ frame),
            r.medium,
            0,
            0,
            0};
}

shared::LightRecord packLight(const Column& column, const LightSet& set,
                              std::vector<glm::vec4>& details)
{
    const VirtualLight& light = *column.light;
    shared::LightRecord record{};
    record.position = light.position;
    record.kind = uint32_t(light.kind) | (light.bothSides != 0 ? shared::kVirtualBothSides : 0u) |
                  light.bounces << shared::kVirtualBouncesShift;
    record.normal = light.normal;
    record.radius = column.radius;
    record.intensity = light.intensity * column.scale;
    record.detail = shared::kNone;
    if (light.detail == shared::kNone) return record;
    record.detail = static_cast<uint32_t>(details.size());
    if (light.kind == LightKind::surface) {
        for (uint32_t word = 0; word < shared::kLightSurfaceWords; ++word)
            details.push_back(shared::lightSurfaceWord(set.surfaces[light.detail], word));
    } else {
        const SpotFalloff& spot = set.spots[light.detail];
        details.emplace_back(spot.scale, spot.offset, 0, 0);
    }
    return record;
}

/// Visible, and of any use: the others need not be looked at.
void packBits(const SliceVisibility& visibility, ColumnRange range, SlicePiece& piece)
{
    const uint32_t words = 2 * piece.groups();  // 32 rows each
    piece.values.resize(size_t(words) * piece.columns);
    for (uint32_t j = 0; j < piece.columns; ++j) {
        const std::span<const uint64_t> visible =
            visibility.completed().visible.column(range.begin + j);
        const std::span<const uint64_t> matters = visibility.matters().column(range.begin + j);
        for (uint32_t w = 0; w < words; ++w) {
            const uint64_t both = visible[w / 2] & matters[w / 2];
            piece.values[size_t(w) * piece.columns + j] =
                static_cast<uint32_t>(w % 2 == 0 ? both : both >> 32);
        }
    }
}

void packNumbers(const SliceVisibility& visibility, ColumnRange range, SlicePiece& piece)
{
    const CompletedSlice& completed = visibility.completed();
    const BitMatrix& matters = visibility.matters();
    std::vector<float> numbers(size_t(piece.groups()) * piece.columns * shared::kSliceGroup);
    const auto at = [&](uint32_t row, uint32_t column) -> float& {
        const uint32_t group = row / shared::kSliceGroup, lane = row % shared::kSliceGroup;
        return numbers[(size_t(group) * piece.columns + (column - range.begin)) *
                           shared::kSliceGroup +
                       lane];
    };
    for (uint32_t j = range.begin; j < range.end; ++j)
        for (uint32_t i = 0; i < piece.rows; ++i) {
            if (!matters.get(i, j)) continue;
            at(i, j) = completed.coefficients.empty()
                           ? static_cast<float>(completed.visible.get(i, j))
                           : completed.coefficients[size_t(j) * piece.rows + i];
        }
    for (const ResidualEntry& r : completed.residual)
        if (r.column >= range.begin && r.column < range.end && matters.get(r.row, r.column))
            at(r.row, r.column) += r.weight;
    piece.values.resize(numbers.size());
    for (size_t i = 0; i < numbers.size(); ++i)
        piece.values[i] = std::bit_cast<uint32_t>(numbers[i]);
}

}  // namespace

shared::SliceGroup SlicePiece::group(uint32_t index, bool numbers) const
{
    const uint32_t first = index * shared::kSliceGroup;
    shared::SliceGroup group{};
    group.columns = columns;
    group.firstValue =
        numbers ? first * columns : index * (shared::kSliceGroup / shared::kSliceWord) * columns;
    group.firstReceiver = first;
    group.rows = std::min(rows - first, shared::kSliceGroup);
    return group;
}

bool leavesNumbers(const CompletionParams& params)
{
    const bool real = givesNumbers(params.method) && params.coefficients != Coefficients::bits;
    return real || params.residualRate > 0;
}

uint32_t pieceColumns(uint32_t rows, LightShape shape)
{
    const bool point = shape == LightShape::point;
    return std::clamp((point ? kPieceEntries : kExtendedEntries) / std::max(rows, 1u), 1u,
                      point ? shared::kMostPieceColumns : shared::kMostExtendedColumns);
}

SlicePiece packPiece(const SliceJob& job, const SliceVisibility& visibility,
                     std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                     ColumnRange range)
{
    SlicePiece piece;
    piece.rows = static_cast<uint32_t>(chosen.size());
    piece.columns = range.end - range.begin;
    piece.receivers.reserve(chosen.size());
    for (const uint32_t r : chosen)
        piece.receivers.push_back(packReceiver(job.receivers, receivers[r]));
    piece.lights.reserve(piece.columns);
    for (uint32_t j = range.begin; j < range.end; ++j)
        piece.lights.push_back(packLight(visibility.columns()[j], *job.lights, piece.details));
    if (leavesNumbers(job.completion))
        packNumbers(visibility, range, piece);
    else
        packBits(visibility, range, piece);
    return piece;
}

}  // namespace core::many_lights

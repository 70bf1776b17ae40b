// See piece_sum.h.
#include "core/many_lights/piece_sum.h"

#include <bit>

#include "shared/extended_light.h"

namespace core::many_lights {

namespace {

/// How much of a column the row of a group sees.
float valueAt(const SlicePiece& piece, const shared::SliceGroup& group, uint32_t row,
              uint32_t column, bool numbers)
{
    if (numbers)
        return std::bit_cast<float>(
            piece.values[group.firstValue + column * shared::kSliceGroup + row]);
    const uint32_t word =
        piece.values[group.firstValue + row / shared::kSliceWord * group.columns + column];
    return (word >> row % shared::kSliceWord & 1u) != 0 ? 1.0f : 0.0f;
}

}  // namespace

bool sumPiece(const shared::SceneView& scene, const SlicePiece& piece, const SumRules& rules,
              std::span<glm::vec3> radiance, const std::stop_token& stop)
{
    const shared::LightDetails details{piece.details.data()};
    const auto shape = static_cast<uint32_t>(rules.shape);
    for (uint32_t row = 0; row < piece.rows; ++row) {
        if (stop.stop_requested()) return false;
        const shared::SliceGroup group = piece.group(row / shared::kSliceGroup, rules.numbers);
        const shared::LightReceiver r = shared::lookUpReceiver(scene, piece.receivers[row]);
        glm::vec3 sum(0);
        for (uint32_t j = 0; j < piece.columns; ++j) {
            const float value = valueAt(piece, group, row % shared::kSliceGroup, j, rules.numbers);
            if (value == 0) continue;
            const shared::LightRecord& light = piece.lights[j];
            sum += value *
                   (rules.shape == LightShape::point
                        ? shared::lightContribution(r, details, light, rules.gather)
                        : shared::extendedContribution(r, details, light, rules.gather, shape));
        }
        radiance[row] += sum;
    }
    return true;
}

}  // namespace core::many_lights

#include "tests/support/methods/slice_twin.h"

#include "core/many_lights/piece_sum.h"
#include "core/trace/scene_view.h"

namespace tests {

double SliceTwin::sum(std::span<const core::many_lights::SlicePiece> batch,
                      const core::many_lights::SumRules& rules, std::span<glm::vec3> radiance)
{
    ++batches;
    pieces += batch.size();
    for (const core::many_lights::SlicePiece& piece : batch) {
        core::many_lights::sumPiece(core::sceneView(world_), piece, rules,
                                    radiance.first(piece.rows));
        radiance = radiance.subspan(piece.rows);
    }
    return 0;
}

}  // namespace tests

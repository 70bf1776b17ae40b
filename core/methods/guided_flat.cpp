// Diffuse surfaces in flat colours under lamps of triangles: the classic box.
#define REKINDLE_FEATURES (shared::kFeatureEmissiveTriangles | shared::kFeatureManyEmitters)
#include "core/methods/guided_kernel_body.h"

namespace core {

TileTally renderFlatGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                               guiding::PathRecords& records)
{
    return renderGuidedTile<shadeFlatGuided>(job, tile, film, records);
}

}  // namespace core

// Diffuse surfaces in flat colours under lamps of triangles: the classic box.
#define REKINDLE_FEATURES (shared::kFeatureEmissiveTriangles | shared::kFeatureManyEmitters)
#include "core/methods/path_kernel_body.h"

namespace core {

TileTally renderFlatTile(const PathJob& job, const Tile& tile, Film& film)
{
    return renderTile(job, tile, film);
}

}  // namespace core

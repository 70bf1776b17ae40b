// The same surfaces under so many lamps that they are chosen by place.
#define REKINDLE_FEATURES                                                                          \
    (shared::kFeatureEmissiveTriangles | shared::kFeatureManyEmitters | shared::kFeatureEmitterTree)
#include "core/methods/path_kernel_body.h"

namespace core {

TileTally renderFlatTreeTile(const PathJob& job, const Tile& tile, Film& film)
{
    return renderTile(job, tile, film);
}

}  // namespace core

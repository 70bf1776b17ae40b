// Everything a scene may hold but emitters that are chosen by place.
#define REKINDLE_FEATURES (~shared::kFeatureEmitterTree)
#include "core/methods/path_kernel_body.h"

namespace core {

TileTally renderAnyTile(const PathJob& job, const Tile& tile, Film& film)
{
    return renderTile(job, tile, film);
}

}  // namespace core

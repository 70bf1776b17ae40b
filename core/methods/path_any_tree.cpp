// Everything a scene may hold.
#define REKINDLE_FEATURES 0xffffffffu
#include "core/methods/path_kernel_body.h"

namespace core {

TileTally renderAnyTreeTile(const PathJob& job, const Tile& tile, Film& film)
{
    return renderTile(job, tile, film);
}

}  // namespace core

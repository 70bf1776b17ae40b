// Everything a scene may hold.
#define REKINDLE_FEATURES 0xffffffffu
#include "core/methods/guided_kernel_body.h"

namespace core {

TileTally renderAnyTreeGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                                  guiding::PathRecords& records)
{
    return renderGuidedTile<shadeAnyTreeGuided>(job, tile, film, records);
}

}  // namespace core

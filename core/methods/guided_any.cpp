// Everything a scene may hold but emitters that are chosen by place.
#define REKINDLE_FEATURES (~shared::kFeatureEmitterTree)
#include "core/methods/guided_kernel_body.h"

namespace core {

TileTally renderAnyGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                              guiding::PathRecords& records)
{
    return renderGuidedTile<shadeAnyGuided>(job, tile, film, records);
}

}  // namespace core

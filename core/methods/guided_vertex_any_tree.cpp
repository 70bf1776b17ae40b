// Vertices of guided paths in any scene.
#define REKINDLE_FEATURES 0xffffffffu
#include "core/methods/guided_vertex_body.h"

namespace core {

bool shadeAnyTreeGuided(const GuidedJob& job, const GuidedStep& step)
{
    return shadeGuidedVertex(job, step);
}

}  // namespace core

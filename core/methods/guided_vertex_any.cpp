// Vertices of guided paths in scenes as guided_any.cpp knows them.
#define REKINDLE_FEATURES (~shared::kFeatureEmitterTree)
#include "core/methods/guided_vertex_body.h"

namespace core {

bool shadeAnyGuided(const GuidedJob& job, const GuidedStep& step)
{
    return shadeGuidedVertex(job, step);
}

}  // namespace core

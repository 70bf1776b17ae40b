// Vertices of guided paths between surfaces as guided_flat.cpp knows them.
#define REKINDLE_FEATURES (shared::kFeatureEmissiveTriangles | shared::kFeatureManyEmitters)
#include "core/methods/guided_vertex_body.h"

namespace core {

bool shadeFlatGuided(const GuidedJob& job, const GuidedStep& step)
{
    return shadeGuidedVertex(job, step);
}

}  // namespace core

// The vertices of guided paths that follow the guide or leave records, apart from the loop of the
// others. Included once by each guided_vertex_*.cpp, after REKINDLE_FEATURES is defined.
#include "core/methods/guided_kernel.h"

namespace core {

namespace {

bool shadeGuidedVertex(const GuidedJob& job, const GuidedStep& step)
{
    return shared::shadeGuided(job.path.scene, job.guide, job.path.settings, step.follows,
                               step.numbers, step.hit, step.path, step.state, step.shadow,
                               step.record, step.recorded, step.L);
}

}  // namespace

}  // namespace core

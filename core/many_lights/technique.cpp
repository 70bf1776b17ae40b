// See technique.h.
#include "core/many_lights/technique.h"

#include "core/many_lights/illumination_cut.h"
#include "core/many_lights/light_slice.h"
#include "core/many_lights/lightcuts.h"
#include "core/many_lights/mat_sep.h"
#include "core/many_lights/row_column.h"

namespace core::many_lights {

ReadyTechnique makeTechnique(Technique technique, const TechniqueInput& input,
                             const std::stop_token& stop, uint64_t& rays)
{
    ReadyTechnique ready;
    const SliceJob& job = input.job;
    switch (technique) {
    case Technique::clusters:
        ready.columns = std::make_unique<TreeCut>(input.tree, job.gather, input.clusters);
        break;
    case Technique::lightslice:
        ready.columns = LightSlice::make(input, stop, rays);
        break;
    case Technique::rowColumn:
        ready.columns = RowColumn::make(job, input.receivers, input.clusters, stop, rays);
        break;
    case Technique::lightcuts:
        ready.lighter = std::make_unique<Lightcuts>(input.tree, input.clusters, input.error);
        break;
    case Technique::illuminationCut:
        ready.lighter = std::make_unique<IlluminationCut>(input.tree, input.error);
        break;
    case Technique::matSep: {
        MatSepSettings settings;
        settings.prediction.error = double(input.error);
        ready.lighter = std::make_unique<MatSep>(
            std::make_unique<TreeCut>(input.tree, job.gather, input.clusters), settings);
        break;
    }
    }
    return ready;
}

}  // namespace core::many_lights

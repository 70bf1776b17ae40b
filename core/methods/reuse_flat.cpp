// Diffuse surfaces in flat colours under lamps of triangles; nothing moves but the camera.
#define REKINDLE_FEATURES                                                                          \
    (shared::kFeatureEmissiveTriangles | shared::kFeatureManyEmitters |                            \
     shared::kFeatureKeepsSamples | shared::kFeatureKeepsMeans)
#include "core/methods/reuse_estimator_body.h"

namespace core {

void estimateFlatReuseTile(const ReuseJob& job, const Tile& tile, std::span<shared::ReuseSums> sums,
                           shared::ReuseTally& tally)
{
    TileEstimator(job, tile, sums, tally).estimate();
}

}  // namespace core

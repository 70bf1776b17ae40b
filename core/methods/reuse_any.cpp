// Everything a scene may hold.
#define REKINDLE_FEATURES 0xffffffffu
#include "core/methods/reuse_estimator_body.h"

namespace core {

void estimateAnyReuseTile(const ReuseJob& job, const Tile& tile, std::span<shared::ReuseSums> sums,
                          shared::ReuseTally& tally)
{
    TileEstimator(job, tile, sums, tally).estimate();
}

}  // namespace core

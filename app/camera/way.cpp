// See way.h.
#include "app/camera/way.h"

namespace app {

void Way::go(glm::dvec3 to)
{
    if (!points_.empty() && points_.back() == to) return;
    if (points_.size() + 1 > kMostPoints) {
        size_t kept = 0;
        for (size_t i = 0; i < points_.size(); i += 2) points_[kept++] = points_[i];
        points_.resize(kept);
    }
    points_.push_back(to);
}

}  // namespace app

// Where a camera has gone since it was put somewhere: the corners of a line, few of them.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace app {

class Way {
public:
    static constexpr size_t kMostPoints = 64;

    /// No way yet from here.
    void begin(glm::dvec3 at) { points_ = {at}; }

    /// Straight on. Of a long way every second corner is left out.
    void go(glm::dvec3 to);

    /// At least one, once it has begun.
    const std::vector<glm::dvec3>& points() const { return points_; }

private:
    std::vector<glm::dvec3> points_;
};

}  // namespace app

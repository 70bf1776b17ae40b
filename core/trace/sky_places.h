// Places that paths come to, and what an emitter brings there: see sky_regions.h.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/trace/accel.h"
#include "shared/path.h"

namespace core {

/// A point of a surface, the normal on the side that was seen, and how far from it rays start at
/// least (shared::offsetRay).
struct Place {
    glm::vec3 position{0}, normal{0};
    float offset = 0;
};

/// Where `walks` walks from the scene's cameras, and half as many that begin at its surfaces, come
/// to. Others for another `seed`. In order of the walks, whatever threads there are.
std::vector<Place> findPlaces(const Accel& accel, size_t walks, uint64_t seed);

/// What samples of emitters bring to places where every surface is white: luminance over density,
/// times the cosine, behind panes as much less; 0 where something is between.
class Bringing {
public:
    explicit Bringing(const Accel& accel) : accel_(accel) {}

    /// `weight`: one over the density. What is behind the surface brings nothing.
    void add(const Place& place, const shared::EmitterSample& sample, float weight, float& brings);

    /// Traces what was added; sets what each brings.
    void trace();

private:
    const Accel& accel_;
    std::vector<shared::ShadowRay> shadows_;
    std::vector<float*> brings_;
    std::vector<Ray> rays_;
    std::vector<uint8_t> blocked_;
};

}  // namespace core

// What light paths carry from surface to surface, and what surfaces do with it: flux scatters by
// the adjoint of the BSDF (Veach, "Robust Monte Carlo Methods for Light Transport Simulation",
// 1997, 5.3), and a part of it goes between the horizons of the shading and the geometric normal,
// where paths from the other end see the surface with its normal bent.
#pragma once

#include "core/many_lights/virtual_light.h"
#include "shared/path.h"

namespace core::many_lights {

/// Flux on its way.
struct Particle {
    glm::vec3 origin{0}, direction{0};
    glm::vec3 flux{0};
    shared::SampleStream stream{};
    uint32_t medium = shared::kNone;  // that it goes through
    bool placed = false;              // began at a place, which may lie in a medium
};

/// What a particle meets.
struct Met {
    shared::Vertex v;      // its normal bent to where the particle comes from
    LightSurface surface;  // the same as a light
    float angle;           // between the horizons of the shading and the geometric normal
    float arriving;        // cosine to the geometric normal
    float correction;      // of flux that goes on by the lobes: shading's cosine over that one
};

/// Takes a particle to what it meets, by which its medium dims it. False where nothing is lit.
bool meet(const shared::SceneView& scene, const shared::Hit& hit, Particle& p, Met& met);

/// Scatters a particle there; false where it ends.
bool scatterFlux(const Met& met, shared::VertexNumbers numbers, Particle& p);

}  // namespace core::many_lights

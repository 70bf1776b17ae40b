// A scene at one instant, as renderers read it: every instance flattened into one list of
// triangles, recentred and rescaled, with one pool of texels and one table of emitters. Immutable;
// shared between threads and devices.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/scene.h"

namespace core {

/// world = (file - centre) * scale, computed in double. Undone in reports and saved cameras.
struct Placement {
    glm::dvec3 centre{0};
    double scale = 1;

    glm::dvec3 toWorld(glm::dvec3 p) const { return (p - centre) * scale; }
    glm::dvec3 toFile(glm::dvec3 p) const { return p / scale + centre; }
};

using shared::WorldTriangle;

struct World {
    std::shared_ptr<const Scene> scene;
    Placement placement;
    std::vector<glm::vec3> positions;  // world, plus one unused at the end (Embree reads 16 bytes)
    std::vector<shared::VertexAttributes> attributes;  // as long as positions, or empty
    std::vector<shared::VertexExtra> extra;            // as long as positions, or empty
    std::vector<WorldTriangle> triangles;
    // Per triangle an index into emitters or kNone; empty when none emits
    std::vector<uint32_t> triangleEmitter;
    std::vector<shared::Material> materials;
    std::vector<shared::TextureReference> textureReferences;
    std::vector<Texel> texels;
    std::vector<shared::Emitter> emitters;
    std::vector<float> emitterCdf;  // emitters.size() + 1 values from 0 to 1
    uint32_t environmentEmitter = shared::kNone, sunEmitter = shared::kNone;
    uint32_t environmentWidth = 0, environmentHeight = 0;
    std::vector<glm::vec4> environment;  // radiance without intensity
    // Height + 1 values over rows, then per row width + 1 values
    std::vector<float> environmentCdf;
    float environmentIntensity = 1;
    glm::vec3 boundsLow{0}, boundsHigh{0};
    float radius = 1;       // of the bounding sphere about the origin
    uint32_t features = 0;  // kFeature bits that can occur
    std::vector<Camera> cameras;
    Warnings warnings;  // the scene's and those of flattening
};

/// Flattens `scene` at `time` seconds of its first animation (0: the rest pose when there is none).
/// Degenerate and non-finite triangles are dropped and counted. `forcedFeatures` are kept even if
/// unused (--no-skip): what their code reads is then stored. `World::scene` keeps meshes and texels
/// only when there is an animation: let go of `scene` to free them. `placement` is that of another
/// instant of the same scene, whose world space then stays; without it, the instant's own bounds
/// decide. Throws core::Error when the result exceeds 2^31 indices.
std::shared_ptr<const World> makeWorld(std::shared_ptr<const Scene> scene, double time = 0,
                                       uint32_t forcedFeatures = 0,
                                       const std::optional<Placement>& placement = {});

/// The settings of `PathSettings` that follow from the world alone.
shared::PathSettings worldSettings(const World& world);

}  // namespace core

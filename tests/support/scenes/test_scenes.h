// Small scenes made in code, so that tests of what renders them do not depend on a loader.
#pragma once

#include <memory>
#include <vector>

#include "core/image/film.h"
#include "core/methods/renderer.h"
#include "core/scene/scene.h"
#include "core/scene/world.h"

namespace tests {

/// Purely diffuse: glTF roughness 1 with specular 0.
core::Material lambert(glm::vec3 albedo);

/// Diffuse with emission of radiance `emissive` from the front (from both sides when `twoSided`).
core::Material emitter(glm::vec3 emissive, glm::vec3 albedo = glm::vec3(0), bool twoSided = false);

/// Dielectric over a diffuse base (specular 1, ior 1.5) or, with metallic 1, a metal.
core::Material glossy(glm::vec3 baseColor, float metallic, float roughness);

/// A scene to which meshes, nodes and lights are added; every function returns the index of what it
/// added.
class SceneBuilder {
public:
    int material(const core::Material& material);

    /// Triangles of one material at the root; flat, front by the right-hand rule.
    int mesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles, int material);

    /// A mesh without a node.
    int looseMesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles,
                  int material);

    /// Parallelogram with corner a and edges u, v; front along u x v.
    int quad(glm::vec3 a, glm::vec3 u, glm::vec3 v, int material);

    /// Axis-aligned box; fronts look inward or outward.
    int box(glm::vec3 low, glm::vec3 high, int material, bool inward);

    /// Subdivided octahedron; 8 * 4^levels triangles; fronts outward unless `inward`. `smooth`:
    /// with vertex normals.
    int sphere(glm::vec3 centre, float radius, int levels, int material, bool inward = false,
               bool smooth = false);

    /// A node at the root (or under `parent`) with this matrix, and meshes that follow one another.
    int node(const glm::dmat4& matrix, const std::vector<int>& meshes, int parent = -1);

    int light(const core::PunctualLight& light, const glm::dmat4& toFile);
    int camera(glm::dvec3 position, glm::dvec3 target, double yfov);
    void constantEnvironment(glm::vec3 radiance);

    core::Scene scene;
    std::shared_ptr<const core::World> world(double time = 0) const;
};

/// A Cornell-like room of 2 x 2 x 2 about the origin, lit from the ceiling, with two boxes of
/// `things`; the camera looks in from +Z.
SceneBuilder room(const core::Material& walls, const core::Material& things);

/// The mean over all samples of all pixels and channels, with its variance (samples taken as
/// independent).
struct PictureMean {
    double mean = 0, varianceOfMean = 0, samples = 0;
};
PictureMean estimate(const core::Estimate& picture);
/// Of the pixels low <= p < high alone.
PictureMean estimate(const core::Estimate& picture, glm::uvec2 low, glm::uvec2 high);

/// How many standard errors lie between an estimate and a value, or between two estimates.
double score(const PictureMean& a, double exact);
double score(const PictureMean& a, const PictureMean& b);

/// Relative bias that the test would see with 99 % power.
double detectable(const PictureMean& a, double exact);
double detectable(const PictureMean& a, const PictureMean& b);

/// Independent samples, the CPU path tracer.
core::PathParams independentParams(core::Strategy strategy = core::Strategy::mis,
                                   uint32_t maxDepth = 4096);

/// `spp` samples through camera `camera` of the world; expects that not one was dropped (T25).
core::Estimate render(const std::shared_ptr<const core::World>& world, uint32_t width,
                      uint32_t height, uint32_t spp, const core::AnyParams& params,
                      size_t camera = 0);

}  // namespace tests

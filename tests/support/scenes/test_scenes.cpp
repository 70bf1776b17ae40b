#include "tests/support/scenes/test_scenes.h"

#include <algorithm>
#include <map>
#include <utility>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "core/methods/method.h"
#include "shared/warp.h"
#include "tests/support/statistics/stats.h"

namespace tests {

core::Material lambert(glm::vec3 albedo)
{
    core::Material m;
    m.data.baseColor = albedo;
    m.data.alpha = 1;
    m.data.alphaCutoff = 0.5f;
    m.data.roughness = 1;
    m.data.ior = 1.5f;
    m.data.specularColor = glm::vec3(1);
    m.data.normalScale = 1;
    m.data.flags = shared::kMaterialDoubleSided;
    return m;
}

core::Material emitter(glm::vec3 emissive, glm::vec3 albedo, bool twoSided)
{
    core::Material m = lambert(albedo);
    m.data.emissive = emissive;
    m.data.flags = twoSided ? shared::kMaterialDoubleSided : 0u;
    return m;
}

core::Material glossy(glm::vec3 baseColor, float metallic, float roughness)
{
    core::Material m = lambert(baseColor);
    m.data.metallic = metallic;
    m.data.roughness = roughness;
    m.data.specular = 1;
    return m;
}

int SceneBuilder::material(const core::Material& material)
{
    scene.materials.push_back(material);
    return static_cast<int>(scene.materials.size()) - 1;
}

int SceneBuilder::looseMesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles,
                            int material)
{
    core::Mesh mesh;
    mesh.name = "mesh " + std::to_string(scene.meshes.size());
    mesh.material = material;
    mesh.positions = std::move(positions);
    mesh.triangles = std::move(triangles);
    scene.meshes.push_back(std::move(mesh));
    return static_cast<int>(scene.meshes.size()) - 1;
}

int SceneBuilder::mesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles,
                       int material)
{
    const int index = looseMesh(std::move(positions), std::move(triangles), material);
    node(glm::dmat4(1), {index});
    return index;
}

int SceneBuilder::quad(glm::vec3 a, glm::vec3 u, glm::vec3 v, int material)
{
    return mesh({a, a + u, a + u + v, a + v}, {{0, 1, 2}, {0, 2, 3}}, material);
}

int SceneBuilder::box(glm::vec3 low, glm::vec3 high, int material, bool inward)
{
    std::vector<glm::vec3> positions;
    for (unsigned i = 0; i < 8; ++i) {
        positions.emplace_back((i & 1u) ? high.x : low.x, (i & 2u) ? high.y : low.y,
                               (i & 4u) ? high.z : low.z);
    }
    std::vector<glm::uvec3> triangles{{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},
                                      {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                      {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    if (inward) {
        for (glm::uvec3& t : triangles) std::swap(t.y, t.z);
    }
    return mesh(std::move(positions), std::move(triangles), material);
}

int SceneBuilder::sphere(glm::vec3 centre, float radius, int levels, int material, bool inward,
                         bool smooth)
{
    std::vector<glm::vec3> unit{{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    std::vector<glm::uvec3> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<unsigned, unsigned>, unsigned> middles;
        const auto middle = [&](unsigned a, unsigned b) {
            const auto [it, added] =
                middles.try_emplace(std::minmax(a, b), static_cast<unsigned>(unit.size()));
            if (added) unit.push_back(glm::normalize(unit[a] + unit[b]));
            return it->second;
        };
        std::vector<glm::uvec3> finer;
        for (const glm::uvec3& t : triangles) {
            const unsigned ab = middle(t.x, t.y), bc = middle(t.y, t.z), ca = middle(t.z, t.x);
            finer.insert(finer.end(), {{t.x, ab, ca}, {ab, t.y, bc}, {ca, bc, t.z}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }
    if (inward) {
        for (glm::uvec3& t : triangles) std::swap(t.y, t.z);
    }
    std::vector<glm::vec3> positions;
    for (const glm::vec3& p : unit) positions.push_back(centre + radius * p);
    const int index = mesh(std::move(positions), std::move(triangles), material);
    if (smooth) {
        core::Mesh& m = scene.meshes[static_cast<size_t>(index)];
        m.hasNormals = true;
        for (const glm::vec3& p : unit) {
            m.attributes.push_back({shared::packOct(inward ? -p : p), 0, 0, 0});
        }
    }
    return index;
}

int SceneBuilder::node(const glm::dmat4& matrix, const std::vector<int>& meshes, int parent)
{
    core::Node n;
    n.local = glm::dmat4x3(matrix);
    if (!meshes.empty()) {
        CHECK(meshes.back() - meshes.front() + 1 == static_cast<int>(meshes.size()));
        n.meshes = {static_cast<uint32_t>(meshes.front()),
                    static_cast<uint32_t>(meshes.back() + 1)};
    }
    n.parent = parent;
    scene.nodes.push_back(std::move(n));
    return static_cast<int>(scene.nodes.size()) - 1;
}

int SceneBuilder::light(const core::PunctualLight& light, const glm::dmat4& toFile)
{
    const int index = static_cast<int>(scene.lights.size());
    scene.lights.push_back(light);
    scene.nodes[static_cast<size_t>(node(toFile, {}))].light = index;
    return index;
}

int SceneBuilder::camera(glm::dvec3 position, glm::dvec3 target, double yfov)
{
    const int index = static_cast<int>(scene.cameras.size());
    core::SceneCamera camera;
    camera.yfov = yfov;
    const glm::dvec3 forward = glm::normalize(target - position);
    const glm::dvec3 up = std::abs(forward.y) < 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    camera.node = node(glm::inverse(glm::lookAt(position, target, up)), {});
    scene.nodes[static_cast<size_t>(camera.node)].camera = index;
    scene.cameras.push_back(std::move(camera));
    return index;
}

void SceneBuilder::constantEnvironment(glm::vec3 radiance)
{
    core::Environment environment;
    environment.width = 8;
    environment.height = 4;
    environment.texels.assign(32, glm::vec4(radiance, 1));
    scene.environment = std::move(environment);
}

std::shared_ptr<const core::World> SceneBuilder::world(double time) const
{
    return core::makeWorld(std::make_shared<core::Scene>(scene), time);
}

SceneBuilder room(const core::Material& walls, const core::Material& things)
{
    SceneBuilder b;
    const int wall = b.material(walls);
    core::Material tinted = walls;
    tinted.data.baseColor *= glm::vec3(0.9f, 0.3f, 0.2f);
    const int red = b.material(tinted);
    const int thing = b.material(things);
    const int lamp = b.material(emitter(glm::vec3(12, 10, 8)));
    b.quad({-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, wall);
    b.quad({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, wall);
    b.quad({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, wall);
    b.quad({-1, -1, 1}, {0, 0, -2}, {0, 2, 0}, red);
    b.quad({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, wall);
    b.quad({-0.3f, 0.99f, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}, lamp);
    b.box({-0.7f, -1, -0.6f}, {-0.1f, 0.2f, 0}, thing, false);
    b.box({0.2f, -1, 0}, {0.7f, -0.4f, 0.5f}, thing, false);
    b.camera({0, 0, 3.8}, {0, 0, 0}, 0.68);
    return b;
}

PictureMean estimate(const core::Estimate& picture)
{
    return estimate(picture, {0, 0}, {picture.mean.width, picture.mean.height});
}

PictureMean estimate(const core::Estimate& picture, glm::uvec2 low, glm::uvec2 high)
{
    const double pixels = double(high.x - low.x) * (high.y - low.y);
    PictureMean e;
    e.samples = double(picture.samples) * pixels;
    double variance = 0;
    for (uint32_t y = low.y; y < high.y; ++y) {
        for (uint32_t x = low.x; x < high.x; ++x) {
            for (int c = 0; c < 3; ++c) {
                e.mean += double(picture.mean.at(x, y)[c]) / (3 * pixels);
                // The channels of a sample go together: the variance of their mean is at most the
                // mean of their variances.
                variance += double(picture.variance.at(x, y)[c]) / 3;
            }
        }
    }
    e.varianceOfMean = variance / (pixels * pixels);
    return e;
}

double score(const PictureMean& a, double exact)
{
    return (a.mean - exact) / std::sqrt(a.varianceOfMean + 1e-14 * exact * exact);
}

double score(const PictureMean& a, const PictureMean& b)
{
    return (a.mean - b.mean) / std::sqrt(a.varianceOfMean + b.varianceOfMean);
}

double detectable(const PictureMean& a, double exact)
{
    return (kScore + 2.33) * std::sqrt(a.varianceOfMean) / exact;
}

double detectable(const PictureMean& a, const PictureMean& b)
{
    return (kScore + 2.33) * std::sqrt(a.varianceOfMean + b.varianceOfMean) / a.mean;
}

core::PathParams independentParams(core::Strategy strategy, uint32_t maxDepth)
{
    core::PathParams params;
    params.sampler = core::SamplerKind::independent;
    params.strategy = strategy;
    params.maxDepth = maxDepth;
    return params;
}

core::Estimate render(const std::shared_ptr<const core::World>& world, uint32_t width,
                      uint32_t height, uint32_t spp, const core::AnyParams& params, size_t camera)
{
    const auto renderer = core::makeRenderer(params.id());
    renderer->setWorld(world, {});
    renderer->setView({world->cameras.at(camera), {width, height}, params}, core::Start::anew);
    renderer->advance({.samples = spp}, {});
    const core::Estimate film = renderer->read(core::Reading::everything);
    EXPECT_EQ(film.samples, spp);
    EXPECT_TRUE(film.counters.clean()) << film.counters.nan << " nan, " << film.counters.inf
                                       << " inf, " << film.counters.negative << " negative";
    return film;
}

}  // namespace tests

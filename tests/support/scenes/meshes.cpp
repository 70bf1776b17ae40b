// See meshes.h.
#include "tests/support/scenes/meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/statistics/random_values.h"

namespace tests {
namespace {

void append(Mesh& mesh, const Mesh& part)
{
    const uint32_t base = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
    for (const core::WorldTriangle& t : part.triangles) {
        mesh.triangles.push_back({base + t.v0, base + t.v1, base + t.v2, t.material});
    }
}

void addBox(Mesh& mesh, glm::vec3 low, glm::vec3 high)
{
    const auto corner = [&](int i) {
        return glm::vec3((i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                         (i & 4) != 0 ? high.z : low.z);
    };
    constexpr int quads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                 {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    for (const auto& q : quads) {
        mesh.add(corner(q[0]), corner(q[1]), corner(q[2]));
        mesh.add(corner(q[0]), corner(q[2]), corner(q[3]));
    }
}

}  // namespace

void Mesh::add(glm::vec3 a, glm::vec3 b, glm::vec3 c)
{
    const uint32_t base = static_cast<uint32_t>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({base, base + 1, base + 2, 0});
}

Mesh sphereMesh(uint32_t rings, float radius, float bump, glm::vec3 centre)
{
    Mesh mesh;
    const uint32_t columns = 2 * rings;
    const auto point = [&](uint32_t ring, uint32_t column) {
        const double theta = std::numbers::pi * ring / rings;
        const double phi = 2 * std::numbers::pi * column / columns;
        const double r = static_cast<double>(radius) *
                         (1 + static_cast<double>(bump) * std::sin(7 * theta) * std::sin(5 * phi));
        return centre +
               glm::vec3(glm::dvec3(r * std::sin(theta) * std::cos(phi), r * std::cos(theta),
                                    r * std::sin(theta) * std::sin(phi)));
    };
    mesh.positions.push_back(point(0, 0));
    for (uint32_t ring = 1; ring < rings; ++ring) {
        for (uint32_t column = 0; column < columns; ++column) {
            mesh.positions.push_back(point(ring, column));
        }
    }
    mesh.positions.push_back(point(rings, 0));
    const uint32_t last = static_cast<uint32_t>(mesh.positions.size()) - 1;
    const auto index = [&](uint32_t ring, uint32_t column) {
        return ring == 0 ? 0 : (ring == rings ? last : 1 + (ring - 1) * columns + column % columns);
    };
    for (uint32_t ring = 0; ring < rings; ++ring) {
        for (uint32_t column = 0; column < columns; ++column) {
            const uint32_t a = index(ring, column), b = index(ring, column + 1);
            const uint32_t c = index(ring + 1, column), d = index(ring + 1, column + 1);
            if (ring + 1 < rings) mesh.triangles.push_back({a, c, d, 0});
            if (ring > 0) mesh.triangles.push_back({a, d, b, 0});
        }
    }
    return mesh;
}

Mesh soupMesh(uint32_t count, float size, uint32_t seed)
{
    Mesh mesh;
    Random random(seed);
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 p = random.cube();
        const float s = size * random();
        mesh.add(p, p + s * (random.cube() - 0.5f), p + s * (random.cube() - 0.5f));
    }
    return mesh;
}

Mesh hairMesh(uint32_t strands, uint32_t seed)
{
    Mesh mesh;
    Random random(seed);
    for (uint32_t i = 0; i < strands; ++i) {
        glm::vec3 p = random.cube() - 0.5f;
        glm::vec3 direction = glm::normalize(random.cube() - 0.5f + 1e-3f);
        const glm::vec3 side = 0.002f * glm::normalize(random.cube() - 0.5f + 1e-3f);
        for (int k = 0; k < 8; ++k) {
            const glm::vec3 q = p + 0.15f * direction;
            mesh.add(p - side, p + side, q + side);
            mesh.add(p - side, q + side, q - side);
            p = q;
            direction = glm::normalize(direction + 0.4f * (random.cube() - 0.5f));
        }
    }
    return mesh;
}

Mesh roomMesh(uint32_t seed)
{
    Mesh mesh;
    Random random(seed);
    addBox(mesh, {-4, 0, -3}, {4, 3, 3});
    for (int i = 0; i < 40; ++i) {
        const glm::vec3 low = glm::vec3(-3.9f, 0, -2.9f) + glm::vec3(7, 2, 5) * random.cube();
        addBox(mesh, low, low + 0.05f + 0.7f * random.cube());
    }
    for (int i = 0; i < 12; ++i) {
        const glm::vec3 centre = glm::vec3(-3.5f, 0.4f, -2.5f) + glm::vec3(7, 2, 5) * random.cube();
        append(mesh, sphereMesh(24, 0.1f + 0.3f * random(), 0.1f * random(), centre));
    }
    return mesh;
}

Mesh nestedMesh(uint32_t count)
{
    Mesh mesh;
    for (uint32_t i = 0; i < count; ++i) {
        const float r = 1.0f + static_cast<float>(i) * 1e-3f;
        mesh.add({-r, -r, 0}, {r, 0, -r}, {0, r, r});
    }
    return mesh;
}

Mesh identicalMesh(uint32_t count)
{
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0.25f}, {0.25f, 1, 0}};
    mesh.triangles.assign(count, {0, 1, 2, 0});
    return mesh;
}

Mesh lineMesh(uint32_t count, float ratio)
{
    Mesh mesh;
    float x = 1;
    for (uint32_t i = 0; i < count; ++i) {
        const float s = 0.1f * x;
        mesh.add({x, -s, 0}, {x, s, s}, {x + s, 0, -s});
        x = x * ratio + (ratio == 1.0f ? 1.0f : 0.0f);
        if (!(x > 1e-18f && x < 1e18f)) x = 1;
    }
    return mesh;
}

Mesh onGround(Mesh mesh, float half, uint32_t cells)
{
    float floor = 0;
    for (const glm::vec3& p : mesh.positions) floor = std::min(floor, p.y);
    const auto at = [&](uint32_t i) {
        return half * (2 * static_cast<float>(i) / static_cast<float>(cells) - 1);
    };
    for (uint32_t i = 0; i < cells; ++i) {
        for (uint32_t j = 0; j < cells; ++j) {
            const float y = floor - 0.01f;
            const glm::vec3 a(at(i), y, at(j)), b(at(i + 1), y, at(j)), c(at(i + 1), y, at(j + 1)),
                d(at(i), y, at(j + 1));
            mesh.add(a, c, b);
            mesh.add(a, d, c);
        }
    }
    return mesh;
}

Mesh underDome(Mesh mesh, float radius, uint32_t rings)
{
    append(mesh, sphereMesh(rings, radius, 0, glm::vec3(0)));
    return mesh;
}

std::vector<FarScene> farScenes()
{
    Mesh touching = sphereMesh(40, 0.0005f, 0.1f, glm::vec3(0));
    append(touching, sphereMesh(40, 0.5f, 0, glm::vec3(0.5006f, 0, 0)));
    return {{"ground", onGround(roomMesh(91), 5000, 1), 3, 5000},
            {"many-squares", onGround(roomMesh(92), 5000, 40), 3, 5000},
            {"dome", underDome(roomMesh(93), 2500, 20), 3, 2500},
            {"three-scales", onGround(std::move(touching), 10000, 1), 0.001f, 1}};
}

float distanceError(const Mesh& mesh, uint32_t triangle, glm::vec3 origin, glm::vec3 direction)
{
    const core::WorldTriangle& t = mesh.triangles[triangle];
    const glm::dvec3 a = mesh.positions[t.v0], b = mesh.positions[t.v1], c = mesh.positions[t.v2];
    const glm::dvec3 o = origin;
    const double far =
        std::max({glm::distance(a, o), glm::distance(b, o), glm::distance(c, o), glm::length(o)});
    const double cosine = glm::dot(glm::normalize(glm::cross(b - a, c - a)), glm::dvec3(direction));
    return static_cast<float>(16 * 0x1p-24 * far / std::max(std::abs(cosine), 1e-6));
}

std::shared_ptr<const core::World> worldOf(const Mesh& mesh)
{
    auto world = std::make_shared<core::World>();
    std::vector<glm::vec3> positions = mesh.positions;
    positions.emplace_back(0);
    world->positions = std::move(positions);
    world->triangles = mesh.triangles;
    world->materials = std::vector<shared::Material>(1);
    world->boundsLow = glm::vec3(3e38f);
    world->boundsHigh = glm::vec3(-3e38f);
    for (const glm::vec3& p : mesh.positions) {
        world->boundsLow = glm::min(world->boundsLow, p);
        world->boundsHigh = glm::max(world->boundsHigh, p);
    }
    return world;
}

core::Bvh bvhOf(const Mesh& mesh, const core::BvhOptions& options)
{
    return core::buildBvh(mesh.positions, mesh.triangles, options);
}

}  // namespace tests

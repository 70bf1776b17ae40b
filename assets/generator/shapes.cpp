// Positions are computed in double and rounded once, shared corners from the same numbers: surfaces
// close exactly.
#include "assets/generator/shapes.h"

#include <array>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace assets {

namespace {

template <class T> void appendAll(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

/// Point of the unit sphere; u about the vertical, v from the top down.
glm::dvec3 spherePoint(double u, double v)
{
    const double phi = 2 * glm::pi<double>() * u, theta = glm::pi<double>() * v;
    return {std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)};
}

}  // namespace

void append(MeshData& mesh, const MeshData& part)
{
    const auto first = uint32_t(mesh.positions.size());
    appendAll(mesh.positions, part.positions);
    appendAll(mesh.normals, part.normals);
    appendAll(mesh.texCoords, part.texCoords);
    appendAll(mesh.texCoords1, part.texCoords1);
    appendAll(mesh.tangents, part.tangents);
    appendAll(mesh.colors, part.colors);
    for (const glm::uvec3& t : part.triangles) mesh.triangles.push_back(t + first);
}

MeshData makeQuad(glm::vec3 corner, glm::vec3 edgeU, glm::vec3 edgeV)
{
    MeshData quad;
    quad.positions = {corner, corner + edgeU, corner + edgeU + edgeV, corner + edgeV};
    quad.normals.assign(
        4, glm::vec3(glm::normalize(glm::cross(glm::dvec3(edgeU), glm::dvec3(edgeV)))));
    quad.texCoords = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    quad.triangles = {{0, 1, 2}, {0, 2, 3}};
    return quad;
}

MeshData makeBox(glm::vec3 low, glm::vec3 high, float degrees, bool inward)
{
    const glm::dvec3 middle = 0.5 * (glm::dvec3(low) + glm::dvec3(high));
    const glm::dvec3 half = 0.5 * (glm::dvec3(high) - glm::dvec3(low));
    const double angle = glm::radians(double(degrees));
    const auto turn = [&](glm::dvec3 v) {
        return glm::dvec3(std::cos(angle) * v.x + std::sin(angle) * v.z, v.y,
                          std::cos(angle) * v.z - std::sin(angle) * v.x);
    };
    MeshData box;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            glm::dvec3 n(0), u(0), v(0);
            n[axis] = side;
            u[(axis + 1) % 3] = 1;
            v[(axis + 2) % 3] = 1;
            // u x v = +axis; the face's front has to look along side * axis, or against it for a
            // room.
            if ((side < 0) != inward) std::swap(u, v);
            const glm::dvec3 corner = middle + turn((n - u - v) * half);
            append(box, makeQuad(glm::vec3(corner), glm::vec3(turn(2.0 * u * half)),
                                 glm::vec3(turn(2.0 * v * half))));
        }
    return box;
}

MeshData makeSphere(glm::vec3 centre, float radius, uint32_t segments, uint32_t rings, bool smooth)
{
    MeshData sphere;
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t segment = 0; segment <= segments; ++segment) {
            const double u = double(segment) / segments, v = double(ring) / rings;
            // The seam and the poles are computed once, so that the surface closes to the last bit.
            const bool pole = ring == 0 || ring == rings;
            const glm::dvec3 n = pole ? glm::dvec3(0, ring == 0 ? 1 : -1, 0)
                                      : spherePoint(segment == segments ? 0.0 : u, v);
            sphere.positions.push_back(glm::vec3(glm::dvec3(centre) + double(radius) * n));
            if (!smooth) continue;
            sphere.normals.push_back(glm::vec3(n));
            sphere.texCoords.emplace_back(u, v);
        }
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t segment = 0; segment < segments; ++segment) {
            const uint32_t a = ring * (segments + 1) + segment, b = a + segments + 1;
            if (ring > 0) sphere.triangles.emplace_back(a, b, a + 1);
            if (ring + 1 < rings) sphere.triangles.emplace_back(a + 1, b, b + 1);
        }
    return sphere;
}

MeshData makeTetrahedron(float radius)
{
    const float s = radius / std::sqrt(3.0f);
    const std::array<glm::vec3, 4> corners{glm::vec3(s, s, s), glm::vec3(s, -s, -s),
                                           glm::vec3(-s, s, -s), glm::vec3(-s, -s, s)};
    constexpr std::array<std::array<size_t, 3>, 4> kFaces{
        {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
    MeshData mesh;
    for (const auto& face : kFaces) {
        const auto first = uint32_t(mesh.positions.size());
        glm::vec3 sum(0);
        for (const size_t corner : face) {
            mesh.positions.push_back(corners[corner]);
            sum += corners[corner];
        }
        for (int i = 0; i < 3; ++i) mesh.normals.push_back(glm::normalize(sum));
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    return mesh;
}

}  // namespace assets

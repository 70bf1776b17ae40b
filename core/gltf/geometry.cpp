// Work on one primitive: assembling triangles, repairing vertices, tangents, packing.
#include "core/gltf/geometry.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/warp.h"

namespace core::gltf {

namespace {

constexpr float kFarthest = 1e18f;

bool usable(const glm::vec3& p)
{
    return std::abs(p.x) < kFarthest && std::abs(p.y) < kFarthest && std::abs(p.z) < kFarthest;
}

/// Area-weighted normals of the faces around the vertices for which `wanted` is true.
std::vector<glm::dvec3> faceNormals(const Primitive& primitive, const std::vector<bool>& wanted)
{
    std::vector<glm::dvec3> normals(primitive.positions.size(), glm::dvec3(0));
    for (const glm::uvec3& t : primitive.triangles) {
        if (!wanted[t.x] && !wanted[t.y] && !wanted[t.z]) continue;
        const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]),
            c(primitive.positions[t.z]);
        const glm::dvec3 n = glm::cross(b - a, c - a);
        for (int k = 0; k < 3; ++k) normals[t[k]] += n;
    }
    return normals;
}

/// Length without overflow; 0 for what is not finite.
double safeLength(const glm::dvec3& v)
{
    const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    if (!(largest > 0) || !std::isfinite(v.x + v.y + v.z)) return 0;
    return glm::length(v / largest) * largest;
}

uint32_t packHalf2(float a, float b)
{
    return glm::packHalf2x16(glm::clamp(glm::vec2(a, b), glm::vec2(0), glm::vec2(65504)));
}

}  // namespace

std::vector<glm::uvec3> assembleTriangles(uint64_t mode, const uint32_t* indices, size_t count)
{
    const auto vertex = [&](size_t i) { return indices ? indices[i] : static_cast<uint32_t>(i); };
    std::vector<glm::uvec3> triangles;
    if (mode != kStrip && mode != kFan) {
        triangles.resize(count / 3);
        for (size_t i = 0; i < triangles.size(); ++i)
            triangles[i] = {vertex(3 * i), vertex(3 * i + 1), vertex(3 * i + 2)};
        return triangles;
    }
    if (count < 3) return triangles;
    triangles.resize(count - 2);
    for (size_t i = 0; i < triangles.size(); ++i) {
        if (mode == kFan)
            triangles[i] = {vertex(i + 1), vertex(i + 2), vertex(0)};
        else
            triangles[i] = {vertex(i), vertex(i + 1 + i % 2), vertex(i + 2 - i % 2)};
    }
    return triangles;
}

size_t dropNonFinite(Primitive& primitive)
{
    std::vector<glm::vec3>& positions = primitive.positions;
    if (std::all_of(positions.begin(), positions.end(), usable)) return 0;
    const auto bad = [&](const glm::uvec3& t) {
        return !usable(positions[t.x]) || !usable(positions[t.y]) || !usable(positions[t.z]);
    };
    const size_t dropped = std::erase_if(primitive.triangles, bad);
    // No triangle refers to them any more; a plain value keeps later arithmetic free of traps.
    for (glm::vec3& p : positions)
        if (!usable(p)) p = glm::vec3(0);
    return dropped;
}

size_t repairNormals(Primitive& primitive, double tolerance, size_t& rescaled)
{
    std::vector<bool> bad;
    size_t replaced = 0;
    rescaled = 0;
    for (size_t i = 0; i < primitive.normals.size(); ++i) {
        glm::vec3& n = primitive.normals[i];
        const float length2 = glm::dot(n, n);
        if (std::abs(length2 - 1) < 1e-6f) continue;
        const double length = safeLength(glm::dvec3(n));
        if (length > 0) {
            if (std::abs(length - 1) > tolerance) ++rescaled;
            n = glm::vec3(glm::dvec3(n) / length);
            continue;
        }
        bad.resize(primitive.normals.size(), false);
        bad[i] = true;
        ++replaced;
    }
    if (replaced == 0) return 0;
    const std::vector<glm::dvec3> faces = faceNormals(primitive, bad);
    for (size_t i = 0; i < bad.size(); ++i) {
        if (!bad[i]) continue;
        const double length = safeLength(faces[i]);
        primitive.normals[i] = length > 0 ? glm::vec3(faces[i] / length) : glm::vec3(0, 0, 1);
    }
    return replaced;
}

namespace {

/// What the triangles of one handedness say about a vertex.
struct Side {
    std::vector<glm::vec3> alongU;
    std::vector<float> angle;

    explicit Side(size_t count) : alongU(count, glm::vec3(0)), angle(count, 0) {}
};

/// Handedness of a triangle's coordinates (0: positive, 1: negative, -1: none) and its direction of
/// growing u.
int handednessOf(const Primitive& primitive, const std::vector<glm::vec2>& uv, const glm::uvec3& t,
                 glm::dvec3& direction)
{
    const glm::dvec3 a(primitive.positions[t.x]);
    const glm::dvec3 e1 = glm::dvec3(primitive.positions[t.y]) - a;
    const glm::dvec3 e2 = glm::dvec3(primitive.positions[t.z]) - a;
    const glm::dvec2 d1 = uv[t.y] - uv[t.x], d2 = uv[t.z] - uv[t.x];
    const double determinant = d1.x * d2.y - d1.y * d2.x;
    const glm::dvec3 gradient = e1 * d2.y - e2 * d1.y;
    const double length = safeLength(gradient);
    if (!std::isfinite(determinant) || determinant == 0 || !(length > 0)) return -1;
    direction = gradient * ((determinant > 0 ? 1 : -1) / length);
    // Green of a normal map points up in the image, against v: hence the order.
    return determinant > 0 ? 1 : 0;
}

double angleAt(const Primitive& primitive, const glm::uvec3& t, int corner)
{
    const glm::dvec3 p(primitive.positions[t[corner]]);
    const glm::dvec3 left = glm::dvec3(primitive.positions[t[(corner + 1) % 3]]) - p;
    const glm::dvec3 right = glm::dvec3(primitive.positions[t[(corner + 2) % 3]]) - p;
    const double lengths = safeLength(left) * safeLength(right);
    return lengths > 0 ? std::acos(std::clamp(glm::dot(left, right) / lengths, -1.0, 1.0)) : 0;
}

/// A second vertex with the same attributes.
uint32_t duplicate(Primitive& primitive, size_t vertex)
{
    const auto copy = [&](auto& values) {
        if (values.empty()) return;
        const auto value = values[vertex];
        values.push_back(value);
    };
    copy(primitive.normals);
    copy(primitive.colors);
    copy(primitive.uv0);
    copy(primitive.uv1);
    copy(primitive.tangents);
    copy(primitive.positions);
    primitive.twins.push_back(static_cast<uint32_t>(vertex));
    return static_cast<uint32_t>(primitive.positions.size() - 1);
}

}  // namespace

void makeTangents(Primitive& primitive, const std::vector<glm::vec2>& uv)
{
    const size_t count = primitive.positions.size();
    std::array<Side, 2> sides{Side(count), Side(count)};
    std::vector<int8_t> handedness(primitive.triangles.size(), -1);
    for (size_t i = 0; i < primitive.triangles.size(); ++i) {
        const glm::uvec3& t = primitive.triangles[i];
        glm::dvec3 direction(0);
        const int side = handednessOf(primitive, uv, t, direction);
        handedness[i] = static_cast<int8_t>(side);
        if (side < 0) continue;
        for (int k = 0; k < 3; ++k) {
            const double angle = angleAt(primitive, t, k);
            sides[static_cast<size_t>(side)].alongU[t[k]] += glm::vec3(direction * angle);
            sides[static_cast<size_t>(side)].angle[t[k]] += static_cast<float>(angle);
        }
    }
    primitive.tangents.resize(count);
    std::vector<uint32_t> negative(count);  // the vertex for triangles of negative handedness
    for (size_t v = 0; v < count; ++v) {
        const bool positive = !(sides[1].angle[v] > 0) || sides[0].angle[v] > 0;
        primitive.tangents[v] = glm::vec4(sides[positive ? 0 : 1].alongU[v], positive ? 1 : -1);
        negative[v] = static_cast<uint32_t>(v);
        if (!positive || !(sides[1].angle[v] > 0)) continue;
        negative[v] = duplicate(primitive, v);
        primitive.tangents.back() = glm::vec4(sides[1].alongU[v], -1);
    }
    for (size_t i = 0; i < handedness.size(); ++i)
        if (handedness[i] == 1)
            for (int k = 0; k < 3; ++k)
                primitive.triangles[i][k] = negative[primitive.triangles[i][k]];
}

size_t repairTangents(Primitive& primitive)
{
    size_t replaced = 0;
    for (size_t i = 0; i < primitive.tangents.size(); ++i) {
        glm::vec4& tangent = primitive.tangents[i];
        glm::dvec3 t(tangent.x, tangent.y, tangent.z);
        const bool hasNormal = !primitive.normals.empty();
        const glm::dvec3 n = hasNormal ? glm::dvec3(primitive.normals[i]) : glm::dvec3(0);
        const double before = safeLength(t);
        if (before > 0) t /= before;
        t -= n * glm::dot(n, t);
        const double length = safeLength(t);
        const bool handed = tangent.w == 1 || tangent.w == -1;
        if (!(before > 0) || !(length > 1e-4)) {
            t = glm::dvec3(
                shared::makeFrame(hasNormal ? primitive.normals[i] : glm::vec3(0, 0, 1))[0]);
            ++replaced;
        } else {
            t /= length;
            if (!handed) ++replaced;
        }
        tangent = glm::vec4(glm::vec3(t), tangent.w < 0 ? -1.0f : 1.0f);
    }
    return replaced;
}

Mesh packMesh(Primitive&& primitive)
{
    Mesh mesh;
    mesh.hasNormals = !primitive.normals.empty();
    mesh.hasTexCoords = !primitive.uv0.empty() || !primitive.uv1.empty();
    mesh.hasTangents = !primitive.tangents.empty();
    const size_t count = primitive.positions.size();
    const auto coordinate = [](float x) { return std::isfinite(x) ? x : 0.0f; };
    if (mesh.hasNormals || !primitive.uv0.empty() || mesh.hasTangents) {
        mesh.attributes.resize(count);
        for (size_t i = 0; i < count; ++i) {
            shared::VertexAttributes& a = mesh.attributes[i];
            a.normal = mesh.hasNormals ? shared::packOct(primitive.normals[i]) : shared::kNoNormal;
            a.u = primitive.uv0.empty() ? 0 : coordinate(primitive.uv0[i].x);
            a.v = primitive.uv0.empty() ? 0 : coordinate(primitive.uv0[i].y);
            a.tangent = 0;
            if (mesh.hasTangents) {
                const glm::vec4 t = primitive.tangents[i];
                a.tangent = shared::packTangent(glm::vec3(t.x, t.y, t.z), t.w);
            }
        }
    }
    if (!primitive.uv1.empty() || !primitive.colors.empty()) {
        mesh.extra.resize(count);
        for (size_t i = 0; i < count; ++i) {
            const glm::vec4 color = primitive.colors.empty() ? glm::vec4(1) : primitive.colors[i];
            mesh.extra[i] = {primitive.uv1.empty() ? 0 : coordinate(primitive.uv1[i].x),
                             primitive.uv1.empty() ? 0 : coordinate(primitive.uv1[i].y),
                             packHalf2(color.r, color.g), packHalf2(color.b, color.a)};
        }
    }
    mesh.positions = std::move(primitive.positions);
    mesh.triangles = std::move(primitive.triangles);
    return mesh;
}

}  // namespace core::gltf

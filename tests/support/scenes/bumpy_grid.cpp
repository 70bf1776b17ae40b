// See bumpy_grid.h.
#include "tests/support/scenes/bumpy_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "shared/warp.h"

namespace test {

BumpyGrid bumpyGrid(uint32_t side)
{
    BumpyGrid grid;
    grid.side = side;
    const auto last = static_cast<float>(side - 1);
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const float u = static_cast<float>(x) / last, v = static_cast<float>(y) / last;
            const glm::vec3 normal = glm::normalize(glm::vec3(2 * u - 1, 2 * v - 1, 1));
            for (const float p : {u, v, 0.2f * u * (1 - u) * v}) grid.positions.push_back(p);
            for (const float n : {normal.x, normal.y, normal.z}) grid.normals.push_back(n);
            for (const float t : {u, v}) grid.coordinates.push_back(t);
        }
    for (uint32_t y = 0; y + 1 < side; ++y)
        for (uint32_t x = 0; x + 1 < side; ++x) {
            const uint32_t a = x + side * y, b = a + 1, c = a + side, d = c + 1;
            for (const uint32_t i : {a, b, c, c, b, d}) grid.indices.push_back(i);
        }
    return grid;
}

Document texturedPrimitive()
{
    Document document =
        texturedTriangle(encodeImage("png", 2, 2, 3, std::vector<uint8_t>(12, 200)));
    Json& views = document.json["bufferViews"];  // the image's is the last
    views = Json::array({views.back()});
    document.json["images"][0]["bufferView"] = 0;
    document.json["accessors"] = Json::array();
    document.attributes() = Json::object();
    document.primitive().erase("indices");
    return document;
}

Document plainGrid(const BumpyGrid& grid)
{
    Document document = texturedPrimitive();
    document.attributes()["POSITION"] = document.values(grid.positions, kFloat, "VEC3", 3);
    document.attributes()["NORMAL"] = document.values(grid.normals, kFloat, "VEC3", 3);
    document.attributes()["TEXCOORD_0"] = document.values(grid.coordinates, kFloat, "VEC2", 2);
    document.primitive()["indices"] = document.values(grid.indices, kUnsignedInt, "SCALAR", 1);
    return document;
}

namespace {

/// The same for a triangle whichever of its vertices comes first.
std::array<size_t, 3> canonical(size_t a, size_t b, size_t c)
{
    std::array<size_t, 3> triangle{a, b, c};
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                triangle.end());
    return triangle;
}

}  // namespace

void expectGrid(const core::Mesh& mesh, const BumpyGrid& grid, float position, float normal,
                float coordinate)
{
    ASSERT_EQ(mesh.triangles.size(), grid.indices.size() / 3);
    ASSERT_EQ(mesh.attributes.size(), mesh.positions.size());
    EXPECT_TRUE(mesh.hasNormals && mesh.hasTexCoords);
    std::vector<size_t> original;  // the grid's vertex of each of the mesh
    const auto last = static_cast<float>(grid.side - 1);
    for (size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::vec3 p = mesh.positions[i];
        const size_t at = static_cast<size_t>(std::lround(p.x * last)) +
                          grid.side * static_cast<size_t>(std::lround(p.y * last));
        ASSERT_LT(at, grid.vertices());
        original.push_back(at);
        const float* q = &grid.positions[3 * at];
        EXPECT_LE(glm::distance(p, glm::vec3(q[0], q[1], q[2])), position) << at;
        const float* n = &grid.normals[3 * at];
        EXPECT_LE(glm::distance(shared::unpackOct(mesh.attributes[i].normal),
                                glm::vec3(n[0], n[1], n[2])),
                  normal)
            << at;
        EXPECT_NEAR(mesh.attributes[i].u, grid.coordinates[2 * at], coordinate) << at;
        EXPECT_NEAR(mesh.attributes[i].v, grid.coordinates[2 * at + 1], coordinate) << at;
    }
    std::set<std::array<size_t, 3>> expected, found;
    for (size_t i = 0; i < grid.indices.size(); i += 3)
        expected.insert(canonical(grid.indices[i], grid.indices[i + 1], grid.indices[i + 2]));
    for (const glm::uvec3& t : mesh.triangles)
        found.insert(canonical(original[t.x], original[t.y], original[t.z]));
    EXPECT_EQ(found, expected);
}

bool refusesDamaged(const std::string& text, const core::LoadOptions& options)
{
    try {
        const auto scene = core::loadGltfFromMemory(bytesOf(text), "damaged", options);
        for (const core::Mesh& mesh : scene->meshes)
            for (const glm::uvec3& t : mesh.triangles)
                EXPECT_LT(std::max({t.x, t.y, t.z}), mesh.positions.size());
        return false;
    } catch (const core::LoadError&) {
        return true;
    }
}

}  // namespace test

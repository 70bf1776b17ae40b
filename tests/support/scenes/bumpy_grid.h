// A curved surface with normals and texture coordinates, to be compressed and compared.
#pragma once

#include <vector>

#include "tests/support/scenes/gltf_fixture.h"

namespace test {

/// A square of side * side vertices over [0,1]^2 with a bump; vertex x + side * y lies at
/// (x, y) / (side - 1), which is its texture coordinate, too.
struct BumpyGrid {
    uint32_t side = 0;
    std::vector<float> positions, normals, coordinates;  // 3, 3 and 2 per vertex
    std::vector<uint32_t> indices;

    size_t vertices() const { return size_t{side} * side; }
};

BumpyGrid bumpyGrid(uint32_t side);

/// A primitive with a texture, so that coordinates are kept, and no geometry: accessors and views
/// are to be added.
Document texturedPrimitive();

/// The grid as it is stored uncompressed.
Document plainGrid(const BumpyGrid& grid);

/// Expects the grid's triangles, each once, and its values within the tolerances, in whatever order
/// triangles and vertices are.
void expectGrid(const core::Mesh& mesh, const BumpyGrid& grid, float position, float normal,
                float coordinate);

/// Whether the loader refuses a damaged document. Expects of one that it takes that all triangles
/// have vertices.
bool refusesDamaged(const std::string& text, const core::LoadOptions& options = {});

}  // namespace test

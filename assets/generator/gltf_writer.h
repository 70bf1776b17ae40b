// A small writer of glTF 2.0 for scenes made by program: one .gltf, one .bin, deterministic to the
// byte.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

namespace assets {

/// Keeps keys in the order of writing.
using Json = nlohmann::ordered_json;

/// Triangles with optional attributes: each is empty or as long as `positions`. Counter-clockwise
/// is the front.
struct MeshData {
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> texCoords, texCoords1;
    std::vector<glm::vec4> tangents;
    std::vector<glm::u8vec4> colors;  // linear RGBA
    std::vector<glm::uvec3> triangles;
};

/// [x, y, ...] of a GLM vector.
template <glm::length_t N, class T> Json toJson(const glm::vec<N, T>& v)
{
    Json array = Json::array();
    for (glm::length_t i = 0; i < N; ++i) array.push_back(v[i]);
    return array;
}

class GltfWriter {
public:
    explicit GltfWriter(std::string name, std::string note);

    // Each adds an object to the list of its kind and returns its index.
    int addMaterial(Json material);
    int addMesh(const std::string& name, const MeshData& data, int material);
    int addTexture(const std::string& uri, Json sampler);
    int addLight(Json punctual);
    int addNode(Json node, bool root = true);

    /// A mesh and a root node of the same name that shows it; returns the node.
    int addShape(const std::string& name, const MeshData& data, int material);

    /// Keyframes of `path` of a node: `values` holds one entry per time (three for CUBICSPLINE).
    template <class Vector>
    void addChannel(int node, const char* path, const char* interpolation,
                    const std::vector<float>& times, const std::vector<Vector>& values);

    /// A perspective camera in a node of its own that looks from `eye` to `target`; returns the
    /// node.
    int addCamera(glm::dvec3 eye, glm::dvec3 target, double yfov, double aspect);

    /// Entry of `scenes[0].extras`.
    void setExtra(const std::string& key, Json value);

    /// Writes folder/NAME.gltf and folder/NAME.bin. Throws core::Error.
    void save(const std::filesystem::path& folder) const;

private:
    int append(const char* list, Json object);
    template <class T>
    int addAccessor(const std::vector<T>& values, const char* type, int componentType, int target,
                    bool bounds);

    std::string name_;
    Json root_;
    std::vector<char> binary_;
};

extern template void GltfWriter::addChannel(int, const char*, const char*,
                                            const std::vector<float>&,
                                            const std::vector<glm::vec3>&);
extern template void GltfWriter::addChannel(int, const char*, const char*,
                                            const std::vector<float>&,
                                            const std::vector<glm::vec4>&);

}  // namespace assets

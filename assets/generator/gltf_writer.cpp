// JSON and binary of a glTF 2.0 file; accessors are packed one after the other at multiples of four
// bytes.
#include "assets/generator/gltf_writer.h"

#include <cstring>
#include <fstream>
#include <limits>
#include <set>
#include <type_traits>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/check.h"

namespace assets {

namespace {

constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123, kUnsignedByte = 5121;
constexpr int kVertexBuffer = 34962, kIndexBuffer = 34963, kNoTarget = 0;

/// Smallest and largest value per component.
template <class T> void addBounds(Json& accessor, const std::vector<T>& values)
{
    T low = values.front(), high = values.front();
    for (const T& v : values) {
        low = glm::min(low, v);
        high = glm::max(high, v);
    }
    if constexpr (std::is_arithmetic_v<T>) {
        accessor["min"] = Json::array({low});
        accessor["max"] = Json::array({high});
    } else {
        accessor["min"] = toJson(low);
        accessor["max"] = toJson(high);
    }
}

/// Names of all extensions used below `json`.
void collectExtensions(const Json& json, std::set<std::string>& names)
{
    if (json.is_object())
        for (const auto& [key, value] : json.items()) {
            if (key == "extensions")
                for (const auto& extension : value.items()) names.insert(extension.key());
            collectExtensions(value, names);
        }
    if (json.is_array())
        for (const Json& value : json) collectExtensions(value, names);
}

/// One line per element of each top-level list: compact, and a change shows as the lines it
/// touches.
std::string format(const Json& root)
{
    std::string text = "{\n";
    size_t left = root.size();
    for (const auto& [key, value] : root.items()) {
        text += Json(key).dump() + ": ";
        if (value.is_array() && !value.empty()) {
            text += "[\n";
            for (size_t i = 0; i < value.size(); ++i)
                text += "  " + value[i].dump() + (i + 1 < value.size() ? ",\n" : "\n]");
        } else {
            text += value.dump();
        }
        text += --left > 0 ? ",\n" : "\n";
    }
    return text + "}\n";
}

void writeBytes(const std::filesystem::path& file, const char* data, size_t size)
{
    std::ofstream stream(file, std::ios::binary);
    stream.write(data, static_cast<std::streamsize>(size));
    stream.close();
    if (!stream) throw core::Error(file.string() + ": cannot be written");
}

}  // namespace

GltfWriter::GltfWriter(std::string name, std::string note) : name_(std::move(name))
{
    root_["asset"] = {{"version", "2.0"}, {"generator", "rekindle make_assets"}};
    root_["scene"] = 0;
    root_["scenes"] = Json::array({{{"name", name_}, {"nodes", Json::array()}}});
    setExtra("note", std::move(note));
}

int GltfWriter::append(const char* list, Json object)
{
    if (!root_.contains(list)) root_[list] = Json::array();
    root_[list].push_back(std::move(object));
    return int(root_[list].size()) - 1;
}

void GltfWriter::setExtra(const std::string& key, Json value)
{
    root_["scenes"][0]["extras"][key] = std::move(value);
}

template <class T>
int GltfWriter::addAccessor(const std::vector<T>& values, const char* type, int componentType,
                            int target, bool bounds)
{
    CHECK(!values.empty());
    while (binary_.size() % 4 != 0) binary_.push_back(0);
    const size_t offset = binary_.size(), size = values.size() * sizeof(T);
    binary_.resize(offset + size);
    std::memcpy(binary_.data() + offset, values.data(), size);
    Json view = {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}};
    if (target != kNoTarget) view["target"] = target;
    Json accessor = {{"bufferView", append("bufferViews", view)},
                     {"componentType", componentType},
                     {"count", values.size()},
                     {"type", type}};
    if (componentType == kUnsignedByte) accessor["normalized"] = true;
    if (bounds) addBounds(accessor, values);
    return append("accessors", std::move(accessor));
}

int GltfWriter::addMaterial(Json material)
{
    return append("materials", std::move(material));
}

int GltfWriter::addMesh(const std::string& name, const MeshData& data, int material)
{
    Json attributes;
    const auto add = [&](const char* key, const auto& values, const char* type, int componentType) {
        if (values.empty()) return;
        CHECK(values.size() == data.positions.size());
        attributes[key] = addAccessor(values, type, componentType, kVertexBuffer,
                                      std::strcmp(key, "POSITION") == 0);
    };
    add("POSITION", data.positions, "VEC3", kFloat);
    add("NORMAL", data.normals, "VEC3", kFloat);
    add("TANGENT", data.tangents, "VEC4", kFloat);
    add("TEXCOORD_0", data.texCoords, "VEC2", kFloat);
    add("TEXCOORD_1", data.texCoords1, "VEC2", kFloat);
    add("COLOR_0", data.colors, "VEC4", kUnsignedByte);
    const bool small = data.positions.size() <= std::numeric_limits<uint16_t>::max();
    std::vector<uint16_t> shortIndices;
    std::vector<uint32_t> indices;
    for (const glm::uvec3& t : data.triangles)
        for (int corner = 0; corner < 3; ++corner)
            if (small)
                shortIndices.push_back(uint16_t(t[corner]));
            else
                indices.push_back(t[corner]);
    const int index = small
                          ? addAccessor(shortIndices, "SCALAR", kUnsignedShort, kIndexBuffer, false)
                          : addAccessor(indices, "SCALAR", kUnsignedInt, kIndexBuffer, false);
    const Json primitive = {{"attributes", attributes}, {"indices", index}, {"material", material}};
    return append("meshes", {{"name", name}, {"primitives", Json::array({primitive})}});
}

int GltfWriter::addTexture(const std::string& uri, Json sampler)
{
    const int samplerIndex = append("samplers", std::move(sampler));
    const int imageIndex = append("images", {{"uri", uri}});
    return append("textures", {{"sampler", samplerIndex}, {"source", imageIndex}});
}

int GltfWriter::addLight(Json punctual)
{
    Json& lights = root_["extensions"]["KHR_lights_punctual"]["lights"];
    lights.push_back(std::move(punctual));
    return int(lights.size()) - 1;
}

int GltfWriter::addNode(Json node, bool root)
{
    const int index = append("nodes", std::move(node));
    if (root) root_["scenes"][0]["nodes"].push_back(index);
    return index;
}

int GltfWriter::addShape(const std::string& name, const MeshData& data, int material)
{
    return addNode({{"name", name}, {"mesh", addMesh(name, data, material)}});
}

template <class Vector>
void GltfWriter::addChannel(int node, const char* path, const char* interpolation,
                            const std::vector<float>& times, const std::vector<Vector>& values)
{
    const size_t perKey = std::strcmp(interpolation, "CUBICSPLINE") == 0 ? 3 : 1;
    CHECK(values.size() == perKey * times.size());
    if (!root_.contains("animations"))
        append("animations", {{"samplers", Json::array()}, {"channels", Json::array()}});
    const int input = addAccessor(times, "SCALAR", kFloat, kNoTarget, true);
    const int output =
        addAccessor(values, Vector::length() == 3 ? "VEC3" : "VEC4", kFloat, kNoTarget, false);
    Json& animation = root_["animations"][0];
    const size_t sampler = animation["samplers"].size();
    animation["samplers"].push_back(
        {{"input", input}, {"interpolation", interpolation}, {"output", output}});
    animation["channels"].push_back(
        {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
}

template void GltfWriter::addChannel(int, const char*, const char*, const std::vector<float>&,
                                     const std::vector<glm::vec3>&);
template void GltfWriter::addChannel(int, const char*, const char*, const std::vector<float>&,
                                     const std::vector<glm::vec4>&);

int GltfWriter::addCamera(glm::dvec3 eye, glm::dvec3 target, double yfov, double aspect)
{
    const int camera = append(
        "cameras", {{"type", "perspective"},
                    {"perspective", {{"aspectRatio", aspect}, {"yfov", yfov}, {"znear", 0.01}}}});
    const glm::dmat3 axes(glm::transpose(glm::lookAt(eye, target, glm::dvec3(0, 1, 0))));
    const glm::quat q(glm::quat_cast(axes));
    return addNode({{"name", "camera"},
                    {"camera", camera},
                    {"translation", toJson(glm::vec3(eye))},
                    {"rotation", Json::array({q.x, q.y, q.z, q.w})}});
}

void GltfWriter::save(const std::filesystem::path& folder) const
{
    Json root = root_;
    std::set<std::string> extensions;
    collectExtensions(root, extensions);
    if (!extensions.empty()) root["extensionsUsed"] = extensions;
    root["buffers"] = Json::array({{{"uri", name_ + ".bin"}, {"byteLength", binary_.size()}}});
    const std::string text = format(root);
    writeBytes(folder / (name_ + ".gltf"), text.data(), text.size());
    writeBytes(folder / (name_ + ".bin"), binary_.data(), binary_.size());
}

}  // namespace assets

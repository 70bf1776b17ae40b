// See deforming_scenes.h.
#include "tests/support/scenes/deforming_scenes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>

#include "shared/warp.h"

namespace tests {

using Path = core::AnimationChannel::Path;

namespace {

constexpr int kStripRows = 8;

/// Of the upper joint, at `time`, 0 to 2.
double angleAt(double time)
{
    return std::numbers::pi / 2 * std::min(time, 1.0) +
           std::numbers::pi / 3 * std::max(time - 1, 0.0);
}

/// The strip's vertices at rest, two to a row.
std::vector<glm::vec3> restingVertices()
{
    std::vector<glm::vec3> positions;
    for (int row = 0; row <= kStripRows; ++row)
        for (const float x : {-0.2f, 0.2f})
            positions.emplace_back(x, 0.25f * static_cast<float>(row), 0.0f);
    return positions;
}

void addSkin(SceneBuilder& b, const std::vector<glm::vec3>& positions, const glm::dvec3& place,
             Strip& strip, core::Deformation& shape)
{
    // A third joint, between the two in the list, that no vertex follows
    const int idle = b.node(glm::dmat4(0.5), {});
    strip.lower = b.node(glm::dmat4(1), {}, b.node(glm::translate(glm::dmat4(1), place), {}));
    strip.upper = b.node(glm::translate(glm::dmat4(1), {0, 1, 0}), {}, strip.lower);
    for (const int joint : {strip.lower, strip.upper})
        b.scene.nodes[static_cast<size_t>(joint)].local = core::Transform();
    std::get<core::Transform>(b.scene.nodes[static_cast<size_t>(strip.upper)].local).translation = {
        0, 1, 0};
    core::Skin skin;
    skin.joints = {strip.lower, idle, strip.upper};
    skin.inverseBinds.assign(3, glm::mat4x3(1));
    skin.inverseBinds[2][3] = {0, -1, 0};
    b.scene.nodes[static_cast<size_t>(strip.node)].skin = static_cast<int>(b.scene.skins.size());
    b.scene.skins.push_back(skin);
    shape.joints = {0, 2};
    shape.first = {0};
    for (const glm::vec3& p : positions) {
        const auto weight = static_cast<float>(upperWeight(static_cast<double>(p.y)));
        if (weight < 1) shape.influences.push_back({0, 1 - weight});
        if (weight > 0) shape.influences.push_back({1, weight});
        shape.first.push_back(static_cast<uint32_t>(shape.influences.size()));
    }
    const float h = std::sqrt(0.5f);
    const auto end = static_cast<float>(0.5 * angleAt(2));
    animate(b.scene, {channelOf(strip.upper, Path::rotation,
                                {{0, 0, 0, 1}, {h, 0, 0, h}, {std::sin(end), 0, 0, std::cos(end)}}),
                      channelOf(strip.lower, Path::translation,
                                {{0, 0, 0, 0}, {0.1f, 0, 0, 0}, {0.2f, 0, 0, 0}})});
}

void addTargets(SceneBuilder& b, const std::vector<glm::vec3>& positions, const Strip& strip,
                core::Deformation& shape)
{
    core::MorphTarget leaning, moving;
    for (uint32_t v = 0; v < positions.size(); ++v) {
        leaning.vertices.push_back(v);
        leaning.positions.emplace_back(0, 0, 0.3f * positions[v].y);
        leaning.normals.emplace_back(0, -0.3f, 0);
        if (positions[v].y <= 1) continue;
        moving.vertices.push_back(v);
        moving.positions.emplace_back(0.2f, 0, 0);
    }
    shape.targets = {leaning, moving};
    core::AnimationChannel channel;
    channel.node = strip.node;
    channel.path = Path::weights;
    channel.keys = std::make_shared<const core::Keyframes>(
        core::Keyframes{{0, 1, 2}, {}, {0, 0, 1, 0, 1, -2}});
    animate(b.scene, {channel});
}

}  // namespace

double upperWeight(double y)
{
    return std::clamp(y - 0.5, 0.0, 1.0);
}

Strip addStrip(SceneBuilder& b, int material, const Bends& bends, const glm::dvec3& place)
{
    const std::vector<glm::vec3> positions = restingVertices();
    std::vector<glm::uvec3> triangles;
    for (uint32_t v = 0; v + 3 < positions.size(); v += 2) {
        triangles.emplace_back(v, v + 1, v + 3);
        triangles.emplace_back(v, v + 3, v + 2);
    }
    const int index = b.looseMesh(positions, triangles, material);
    Strip strip;
    const glm::dmat4 elsewhere =
        glm::rotate(glm::translate(glm::dmat4(3), {5, 6, 7}), 1.0, {0.6, 0.8, 0});
    strip.node = b.node(bends.skin ? elsewhere : glm::translate(glm::dmat4(1), place), {index});
    core::Deformation shape;
    if (bends.skin) addSkin(b, positions, place, strip, shape);
    if (bends.targets) addTargets(b, positions, strip, shape);
    core::Mesh& mesh = b.scene.meshes[static_cast<size_t>(index)];
    mesh.hasNormals = true;
    mesh.attributes.assign(positions.size(), {shared::packOct(glm::vec3(0, 0, 1)), 0, 0, 0});
    mesh.deformation = std::make_shared<const core::Deformation>(std::move(shape));
    return strip;
}

StripVertex stripVertex(const Bends& bends, glm::dvec2 xy, double time)
{
    const double leaning = bends.targets ? std::min(time, 1.0) : 0;
    const double moving = bends.targets ? -2 * std::max(time - 1, 0.0) : 0;
    glm::dvec3 p(xy.x + (xy.y > 1 ? 0.2 * moving : 0), xy.y, 0.3 * leaning * xy.y);
    glm::dvec3 n(0, -0.3 * leaning, 1);
    if (bends.skin) {
        const double w = upperWeight(xy.y), angle = angleAt(time);
        const double c = std::cos(angle), s = std::sin(angle);
        const glm::dvec3 turned(p.x, 1 + (p.y - 1) * c - p.z * s, (p.y - 1) * s + p.z * c);
        p = (1 - w) * p + w * turned + glm::dvec3(0.1 * time, 0, 0);
        // The blend of no turn and a turn is, in the plane yz, a turn and a scale: a - b, b a.
        const double a = 1 - w + w * c, b = w * s;
        n = glm::dvec3(0, a * n.y - b * n.z, b * n.y + a * n.z);
    }
    return {p, glm::normalize(n)};
}

SceneBuilder deformingRoom()
{
    SceneBuilder b = movingRoom();
    addStrip(b, b.material(lambert(glm::vec3(0.7f, 0.5f, 0.3f))), {true, false},
             {-0.5, -0.97, -0.4});
    addStrip(b, b.material(glossy(glm::vec3(0.5f), 0, 0.4f)), {false, true}, {0.05, -0.95, -0.55});
    addStrip(b, b.material(emitter(glm::vec3(0.3f), glm::vec3(0), true)), {true, true},
             {0.5, -0.96, -0.3});
    return b;
}

}  // namespace tests

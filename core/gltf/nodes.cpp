// The forest of nodes: checked iteratively (no recursion, one parent each, no loops), then cut to
// the shown scene.
#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "core/base/text.h"
#include "core/gltf/parts.h"

namespace core::gltf {

namespace {

constexpr size_t kMaxDepth = 4096;
constexpr size_t kMaxNodes = 1'000'000;

/// Parent and children of every node of the document.
struct Forest {
    std::vector<int> parent;
    std::vector<int> below;     // all children, those of a node side by side
    std::vector<size_t> first;  // where those of each node begin in `below`, and where the last end

    std::span<const int> children(size_t node) const
    {
        return std::span(below).subspan(first[node], first[node + 1] - first[node]);
    }
};

/// Element `i` of a list of nodes, which is member `key` of `holder`.
size_t nodeIn(const Object& holder, const char* key, const Json& list, size_t i, size_t limit)
{
    const std::optional<uint64_t> index = wholeNumber(list[i]);
    if (!index)
        holder.load().refuse("TYPE_MISMATCH", child(holder.at(key), i),
                             "is " + describe(list[i]) + ", must be a whole number, not negative");
    if (*index >= limit)
        holder.load().refuse("UNRESOLVED_REFERENCE", child(holder.at(key), i),
                             "refers to node " + std::to_string(*index) + ", there are " +
                                 std::to_string(limit));
    return *index;
}

Forest readForest(Load& load)
{
    const size_t count = countOf(load, "nodes");
    // The node itself, and what this file and NodePlan hold about it
    constexpr uint64_t kBytes = sizeof(Node) + sizeof(MeshUse) + 10 * sizeof(int);
    load.reserveMemory(count * kBytes, "/nodes");
    Forest forest{std::vector<int>(count, -1), {}, {0}};
    forest.first.reserve(count + 1);
    const Json nodes = load.document.root().find("nodes").value_or(Json::emptyArray());
    for (size_t i = 0; i < count; ++i) {
        const Json value = nodes[i];
        if (value.isObject() && !value.find("children")) {  // as most, whose place is not needed
            forest.first.push_back(forest.below.size());
            continue;
        }
        const Object node(load, value, child("/nodes", i));
        const Json children = node.array("children");
        for (size_t k = 0; k < children.size(); ++k) {
            const size_t c = nodeIn(node, "children", children, k, count);
            if (c == i)
                load.refuse("NODE_LOOP", child(node.at("children"), k),
                            "node " + std::to_string(i) + " is its own child");
            if (forest.parent[c] >= 0) {
                load.warn("NODE_PARENT_OVERRIDE", child(node.at("children"), k),
                          "node " + std::to_string(c) + " already is a child of node " +
                              std::to_string(forest.parent[c]) + " — this one is ignored");
                continue;
            }
            forest.parent[c] = static_cast<int>(i);
            forest.below.push_back(static_cast<int>(c));
        }
        forest.first.push_back(forest.below.size());
    }
    return forest;
}

/// With one parent each, nodes that no root reaches are in a loop or below one.
void requireNoLoops(Load& load, const Forest& forest)
{
    const size_t count = forest.parent.size();
    std::vector<int> reached;
    reached.reserve(count);
    std::vector<uint32_t> depth(count, 0);
    for (size_t i = 0; i < count; ++i)
        if (forest.parent[i] < 0) reached.push_back(static_cast<int>(i));
    for (size_t next = 0; next < reached.size(); ++next) {
        const auto node = static_cast<size_t>(reached[next]);
        for (const int c : forest.children(node)) {
            const auto below = static_cast<size_t>(c);
            depth[below] = depth[node] + 1;
            if (depth[below] > kMaxDepth)
                load.refuse("NODE_TOO_DEEP", child("/nodes", below),
                            "lies deeper than " + std::to_string(kMaxDepth) + " levels");
            reached.push_back(c);
        }
    }
    if (reached.size() == count) return;
    std::vector<bool> fine(count, false);
    for (const int node : reached) fine[static_cast<size_t>(node)] = true;
    const auto bad = static_cast<size_t>(std::find(fine.begin(), fine.end(), false) - fine.begin());
    load.refuse("NODE_LOOP", child("/nodes", bad), "is in a loop of nodes, or below one");
}

/// A quaternion of length 1, whatever the file has.
glm::dquat readRotation(Load& load, const Object& node)
{
    std::array<double, 4> q{0, 0, 0, 1};
    if (!node.numbers("rotation", q)) return {1, 0, 0, 0};
    // Scaled by the largest component first, so that 1e-200 and 1e200 have a length.
    const double largest =
        std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2]), std::abs(q[3])});
    if (!(largest > 0) || !std::isfinite(largest)) {
        load.warn("ROTATION_NON_UNIT", node.at("rotation"), "has length 0 — no rotation instead");
        return {1, 0, 0, 0};
    }
    const glm::dquat scaled(q[3] / largest, q[0] / largest, q[1] / largest, q[2] / largest);
    const double length = glm::length(scaled) * largest;
    constexpr double kTolerance = 0.00769;  // of the Khronos validator
    if (std::abs(length - 1) > kTolerance)
        load.warn("ROTATION_NON_UNIT", node.at("rotation"),
                  "has length " + std::to_string(length) + " — normalised");
    return glm::normalize(scaled);
}

glm::dvec3 readVector(Load& load, const Object& node, const char* key, double fallback)
{
    std::array<double, 3> v{fallback, fallback, fallback};
    if (!node.numbers(key, v)) return glm::dvec3(fallback);
    glm::dvec3 result{v[0], v[1], v[2]};
    if (std::abs(v[0]) > kHuge || std::abs(v[1]) > kHuge || std::abs(v[2]) > kHuge) {
        load.warn("VALUE_NOT_IN_RANGE", node.at(key), "has values beyond 1e18 — clamped");
        result = glm::clamp(result, -kHuge, kHuge);
    }
    return result;
}

std::variant<Transform, glm::dmat4x3> readTransform(Load& load, const Object& node)
{
    std::array<double, 16> m{};
    if (node.numbers("matrix", m)) {
        for (const char* key : {"translation", "rotation", "scale"})
            if (node.has(key))
                load.refuse("NODE_MATRIX_TRS", node.pointer(),
                            std::string("has a 'matrix' and a '") + key +
                                "': one excludes the other");
        bool clamped = false;
        for (double& value : m) {
            clamped = clamped || std::abs(value) > kHuge;
            value = std::clamp(value, -kHuge, kHuge);
        }
        if (clamped)
            load.warn("VALUE_NOT_IN_RANGE", node.at("matrix"), "has values beyond 1e18 — clamped");
        glm::dmat4x3 matrix(1);
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row)
                matrix[column][row] = m[static_cast<size_t>(4 * column + row)];
        const bool affine = m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
        // An all-zero matrix is reported where the scene is flattened, because nothing of it is
        // visible.
        if (!affine && (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 0))
            load.warn("NODE_MATRIX_NON_TRS", node.at("matrix"),
                      "has a last row other than 0 0 0 1 — taken as that");
        return matrix;
    }
    Transform transform;
    transform.translation = readVector(load, node, "translation", 0);
    transform.rotation = readRotation(load, node);
    transform.scale = readVector(load, node, "scale", 1);
    return transform;
}

std::vector<double> readWeights(const Object& holder, size_t targets)
{
    if (!holder.has("weights")) return {};
    const Json weights = holder.array("weights");
    std::vector<double> result;
    for (size_t i = 0; i < weights.size(); ++i) {
        if (!weights[i].isNumber() || weights.size() != targets) {
            holder.load().warn("MESH_INVALID_WEIGHTS_COUNT", holder.at("weights"),
                               "is " + describe(weights) + " for " + std::to_string(targets) +
                                   " morph targets — ignored");
            return {};
        }
        result.push_back(std::clamp(weights[i].number(), -kHuge, kHuge));
    }
    return result;
}

/// What nodes may refer to.
struct Targets {
    size_t meshes, skins, cameras, lights;
    std::vector<bool> rigid;  // meshes that a node has shown, and that have no weights

    Targets(Load& load, size_t nodes);
};

void readMeshUse(Load& load, const Object& node, int sceneNode, Targets& all, NodePlan& plan)
{
    const int mesh = node.index("mesh", all.meshes, "mesh");
    const int skin = node.index("skin", all.skins, "skin");
    if (mesh < 0) return;
    const auto place = static_cast<size_t>(mesh);
    if (all.rigid[place] && !node.has("weights")) {
        plan.meshUses.push_back({sceneNode, mesh, 0, skin});
        return;
    }
    const Object source = topLevel(load, "meshes", place);
    const size_t targets = targetCount(source);
    all.rigid[place] = !source.has("weights");
    std::vector<double> weights = readWeights(node, targets);
    if (weights.empty()) weights = readWeights(source, targets);
    if (std::all_of(weights.begin(), weights.end(), [](double w) { return w == 0; }))
        weights.clear();
    load.reserveMemory(2 * weights.size() * sizeof(double), node.pointer());
    const auto next = static_cast<uint32_t>(plan.weights.size());
    plan.meshUses.push_back({sceneNode, mesh, weights.empty() ? 0 : next, skin});
    if (!weights.empty()) plan.weights.push_back(std::move(weights));
}

/// Punctual lights of the document.
size_t lightCount(Load& load)
{
    const Object root(load, load.document.root(), "");
    const std::optional<Object> extension = root.extension("KHR_lights_punctual");
    const std::optional<Json> list = extension ? extension->find("lights") : std::nullopt;
    return list && list->isArray() ? list->size() : 0;
}

Targets::Targets(Load& load, size_t nodes)
    : meshes(countOf(load, "meshes")), skins(nodes == 0 ? 0 : countOf(load, "skins")),
      cameras(countOf(load, "cameras")), lights(lightCount(load)), rigid(meshes, false)
{}

void readOtherUses(const Object& node, std::string name, int sceneNode, const Targets& all,
                   NodePlan& plan)
{
    if (const int camera = node.softIndex("camera", all.cameras, "cameras", "no camera here");
        camera >= 0)
        plan.cameraUses.push_back({sceneNode, static_cast<size_t>(camera), std::move(name)});
    const std::optional<Object> use = node.extension("KHR_lights_punctual");
    if (!use) return;
    const int light = use->softIndex("light", all.lights, "lights", "no light here");
    if (light >= 0) plan.lightUses.push_back({sceneNode, static_cast<size_t>(light), {}});
}

/// Document indices of the scene's roots.
std::vector<int> readRoots(Load& load, const Forest& forest)
{
    std::vector<int> roots;
    const std::optional<Object> scene = shownScene(load);
    if (!scene) {
        for (size_t i = 0; i < forest.parent.size(); ++i)
            if (forest.parent[i] < 0) roots.push_back(static_cast<int>(i));
        return roots;
    }
    const Json nodes = scene->array("nodes");
    for (size_t i = 0; i < nodes.size(); ++i)
        roots.push_back(static_cast<int>(nodeIn(*scene, "nodes", nodes, i, forest.parent.size())));
    return roots;
}

}  // namespace

size_t targetCount(const Object& meshOrPrimitive)
{
    if (!meshOrPrimitive.has("primitives")) return meshOrPrimitive.array("targets").size();
    if (meshOrPrimitive.array("primitives").size() == 0) return 0;
    return meshOrPrimitive.element("primitives", 0).array("targets").size();
}

std::optional<Object> shownScene(Load& load)
{
    const Object root(load, load.document.root(), "");
    const size_t count = countOf(load, "scenes");
    const int index = root.index("scene", count, "scene");
    if (count == 0) return std::nullopt;
    return topLevel(load, "scenes", static_cast<size_t>(std::max(index, 0)));
}

NodePlan readNodes(Load& load)
{
    const Forest forest = readForest(load);
    requireNoLoops(load, forest);
    NodePlan plan;
    Targets targets(load, forest.parent.size());
    plan.sceneNode.assign(forest.parent.size(), -1);
    load.scene.nodes.reserve(std::min(forest.parent.size(), kMaxNodes));
    plan.meshUses.reserve(std::min(forest.parent.size(), kMaxNodes));
    struct Visit {
        int node, parent;  // of the document, of the scene
    };
    std::vector<Visit> stack;
    const Json nodes = load.document.root().find("nodes").value_or(Json::emptyArray());
    const std::vector<int> roots = readRoots(load, forest);
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) stack.push_back({*root, -1});
    while (!stack.empty()) {
        const Visit visit = stack.back();
        stack.pop_back();
        const auto source = static_cast<size_t>(visit.node);
        if (plan.sceneNode[source] >= 0) {
            load.warn("SCENE_NON_ROOT_NODE", child("/nodes", source),
                      "is listed by the scene twice, or is a child as well — shown once");
            continue;
        }
        const auto index = static_cast<int>(load.scene.nodes.size());
        if (load.scene.nodes.size() == kMaxNodes)
            load.refuse("TOO_MANY_NODES", "/nodes",
                        "the scene has more than " + std::to_string(kMaxNodes) + " nodes");
        plan.sceneNode[source] = index;
        const Object object(load, nodes[source], child("/nodes", source));
        std::string name = object.name();  // which only cameras take
        Node node;
        node.parent = visit.parent;
        node.source = visit.node;
        node.local = readTransform(load, object);
        load.scene.nodes.push_back(std::move(node));
        readMeshUse(load, object, index, targets, plan);
        readOtherUses(object, std::move(name), index, targets, plan);
        const std::span<const int> children = forest.children(source);
        for (auto c = children.rbegin(); c != children.rend(); ++c) stack.push_back({*c, index});
    }
    load.scene.name = printable(load.file.stem().string());
    if (const std::optional<Object> scene = shownScene(load))
        if (const std::string name = scene->name(); !name.empty()) load.scene.name = name;
    return plan;
}

}  // namespace core::gltf

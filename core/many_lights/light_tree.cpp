// See light_tree.h. A node over n lights and all below it take 2 n - 1 places of the array, so that
// subtrees are built at the same time.
#include "core/many_lights/light_tree.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace core::many_lights {

namespace {

using glm::vec3;
/// By which the lights of a node are parted.
template <size_t kDimensions> using Feature = std::array<float, kDimensions>;
constexpr uint32_t kDeepest = 96;  // below, sets are halved: outliers make chains
constexpr size_t kSubtree = 2048;  // lights that one thread takes

struct Work {
    uint32_t node, begin, end, depth;  // lights [begin, end) of the order
};

class Builder {
public:
    Builder(std::span<const VirtualLight> lights, const LightTreeSettings& settings,
            std::stop_token stop)
        : lights_(lights), settings_(settings), stop_(std::move(stop)), order_(lights.size()),
          other_(lights.size())
    {}

    std::optional<LightTree> build()
    {
        tree_.roots.fill(shared::kNone);
        uint32_t at = 0;
        std::vector<Work> roots;
        for (uint32_t kind = 0; kind < kLightKinds; ++kind) {
            const uint32_t begin = at;
            for (uint32_t i = 0; i < lights_.size(); ++i)
                if (uint32_t(lights_[i].kind) == kind) order_[at++] = i;
            if (at == begin) continue;
            tree_.roots[kind] = 2 * begin - static_cast<uint32_t>(roots.size());
            roots.push_back({tree_.roots[kind], begin, at, 0});
        }
        if (roots.empty()) return std::move(tree_);
        tree_.nodes.resize(2 * lights_.size() - roots.size());
        if (!splitAll(roots)) return std::nullopt;
        for (size_t i = tree_.nodes.size(); i-- > 0;) join(static_cast<uint32_t>(i));
        return std::move(tree_);
    }

private:
    /// Splits large sets here, then all that are left on all threads.
    bool splitAll(std::vector<Work> waiting)
    {
        std::vector<Work> subtrees;
        while (!waiting.empty() && !stop_.stop_requested()) {
            const Work work = waiting.back();
            waiting.pop_back();
            if (work.end - work.begin <= kSubtree)
                subtrees.push_back(work);
            else
                split(work, waiting);
        }
        return waiting.empty() && parallelFor(
                                      subtrees.size(), 1,
                                      [&](size_t begin, size_t end) {
                                          std::vector<Work> stack;
                                          for (size_t i = begin; i < end; ++i) {
                                              stack.push_back(subtrees[i]);
                                              while (!stack.empty()) {
                                                  const Work work = stack.back();
                                                  stack.pop_back();
                                                  split(work, stack);
                                              }
                                          }
                                      },
                                      stop_);
    }

    /// Bounds of one node; its two children go onto the stack.
    void split(const Work& work, std::vector<Work>& stack)
    {
        LightNode& node = tree_.nodes[work.node];
        bound(work, node);
        node.count = work.end - work.begin;
        if (node.isLeaf()) {
            node.representative = order_[work.begin];
            node.importance = lights_[node.representative].importance;
            return;
        }
        const uint32_t middle = part(work, node);
        node.right = work.node + 2 * (middle - work.begin);
        stack.push_back({node.right, middle, work.end, work.depth + 1});
        stack.push_back({work.node + 1, work.begin, middle, work.depth + 1});
    }

    void bound(const Work& work, LightNode& node) const
    {
        const VirtualLight& first = lights_[order_[work.begin]];
        node.low = node.high = first.position;
        vec3 sum(0);
        bool around = first.kind == LightKind::point;
        for (uint32_t i = work.begin; i < work.end; ++i) {
            const VirtualLight& light = lights_[order_[i]];
            node.low = glm::min(node.low, light.position);
            node.high = glm::max(node.high, light.position);
            sum += light.normal;
            around = around || light.bothSides != 0;
        }
        const float length = glm::length(sum);
        if (around || !(length > 1e-6f * static_cast<float>(work.end - work.begin))) {
            node.cosHalf = -1;
            return;
        }
        node.axis = sum / length;
        for (uint32_t i = work.begin; i < work.end; ++i)
            node.cosHalf = std::min(node.cosHalf, glm::dot(node.axis, lights_[order_[i]].normal));
        // Outwards by more than the rounding of the dot products.
        node.cosHalf = std::clamp(node.cosHalf - 1e-5f, -1.0f, 1.0f);
        node.sinHalf = std::sqrt(1 - node.cosHalf * node.cosHalf);
    }

    /// Reorders the lights of a node; returns where the second child's begin.
    uint32_t part(const Work& work, const LightNode& node)
    {
        const uint32_t half = work.begin + (work.end - work.begin) / 2;
        if (work.depth > kDeepest) return half;
        const bool directional = lights_[order_[work.begin]].kind == LightKind::directional;
        uint32_t left;
        if (directional) {
            left = partBy<3>(work, [](const VirtualLight& l) {
                return Feature<3>{l.normal.x, l.normal.y, l.normal.z};
            });
        } else if (glm::distance(node.low, node.high) < settings_.normalScale) {
            left = partBy<6>(work, [scale = settings_.normalScale](const VirtualLight& l) {
                const vec3 &p = l.position, n = scale * l.normal;
                return Feature<6>{p.x, p.y, p.z, n.x, n.y, n.z};
            });
        } else {
            left = partBy<3>(work, [](const VirtualLight& l) {
                return Feature<3>{l.position.x, l.position.y, l.position.z};
            });
        }
        return left == work.begin || left == work.end ? half : left;
    }

    /// Parts them at the mean along the first principal axis of what `of` tells of each.
    template <size_t kDimensions, class F> uint32_t partBy(const Work& work, F&& of)
    {
        const auto count = static_cast<float>(work.end - work.begin);
        Feature<kDimensions> mean{};
        for (uint32_t i = work.begin; i < work.end; ++i) {
            const Feature<kDimensions> f = of(lights_[order_[i]]);
            for (size_t d = 0; d < kDimensions; ++d) mean[d] += f[d] / count;
        }
        const Feature<kDimensions> axis = principalAxis<kDimensions>(work, mean, of);
        uint32_t left = work.begin, right = work.begin;
        for (uint32_t i = work.begin; i < work.end; ++i) {
            const Feature<kDimensions> f = of(lights_[order_[i]]);
            float projected = 0;
            for (size_t d = 0; d < kDimensions; ++d) projected += axis[d] * (f[d] - mean[d]);
            const uint32_t light = order_[i];
            if (projected < 0)
                order_[left++] = light;
            else
                other_[right++] = light;
        }
        std::copy(other_.begin() + work.begin, other_.begin() + right, order_.begin() + left);
        return left;
    }

    /// First eigenvector of the covariance, by power iteration from its longest column.
    template <size_t kDimensions, class F>
    Feature<kDimensions> principalAxis(const Work& work, const Feature<kDimensions>& mean,
                                       F&& of) const
    {
        std::array<Feature<kDimensions>, kDimensions> c{};
        for (uint32_t i = work.begin; i < work.end; ++i) {
            const Feature<kDimensions> f = of(lights_[order_[i]]);
            for (size_t a = 0; a < kDimensions; ++a)
                for (size_t b = 0; b <= a; ++b) c[a][b] += (f[a] - mean[a]) * (f[b] - mean[b]);
        }
        for (size_t a = 0; a < kDimensions; ++a)
            for (size_t b = 0; b < a; ++b) c[b][a] = c[a][b];
        size_t longest = 0;
        for (size_t a = 1; a < kDimensions; ++a)
            if (c[a][a] > c[longest][longest]) longest = a;
        Feature<kDimensions> axis = c[longest];
        for (int k = 0; k < 8; ++k) {
            Feature<kDimensions> next{};
            float largest = 0;
            for (size_t a = 0; a < kDimensions; ++a) {
                for (size_t b = 0; b < kDimensions; ++b) next[a] += c[a][b] * axis[b];
                largest = std::max(largest, std::abs(next[a]));
            }
            if (!(largest > 0)) return axis;
            for (size_t a = 0; a < kDimensions; ++a) axis[a] = next[a] / largest;
        }
        return axis;
    }

    /// What an inner node has of its children.
    void join(uint32_t index)
    {
        LightNode& node = tree_.nodes[index];
        if (node.isLeaf()) return;
        const LightNode& left = tree_.nodes[index + 1];
        const LightNode& right = tree_.nodes[node.right];
        node.importance = left.importance + right.importance;
        const float u =
            shared::unitFloat(shared::hashUint(index ^ shared::hashUint(settings_.seed)));
        node.representative =
            u * node.importance < left.importance ? left.representative : right.representative;
        node.scale = node.importance / lights_[node.representative].importance;
    }

    std::span<const VirtualLight> lights_;
    const LightTreeSettings& settings_;
    std::stop_token stop_;
    std::vector<uint32_t> order_, other_;
    LightTree tree_;
};

}  // namespace

std::optional<LightTree> makeLightTree(std::span<const VirtualLight> lights,
                                       const LightTreeSettings& settings,
                                       const std::stop_token& stop)
{
    return Builder(lights, settings, stop).build();
}

}  // namespace core::many_lights

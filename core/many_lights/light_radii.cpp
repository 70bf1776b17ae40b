// See light_radii.h. A tree that halves the positions along their widest axis, down to leaves that
// are searched through.
#include "core/many_lights/light_radii.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr size_t kNeighbours = 10, kLeaf = 16;

/// The nearest squared distances so far, a heap with the farthest of them on top.
struct Nearest {
    std::array<float, kNeighbours> distances;
    size_t count = 0;

    float reach() const
    {
        return count < kNeighbours ? std::numeric_limits<float>::infinity() : distances[0];
    }
    void add(float d2)
    {
        if (d2 == 0 || d2 >= reach()) return;
        if (count == kNeighbours) {
            std::ranges::pop_heap(distances);
            --count;
        }
        distances[count++] = d2;
        std::push_heap(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(count));
    }
};

class Neighbours {
public:
    explicit Neighbours(std::span<const vec3> positions)
        : positions_(positions), order_(positions.size())
    {
        std::iota(order_.begin(), order_.end(), 0u);
        split(0, order_.size());
    }

    void find(const vec3& at, Nearest& nearest) const { search(0, order_.size(), 0, at, nearest); }

private:
    struct Cut {
        int axis;
        float value;
    };

    size_t split(size_t begin, size_t end)
    {
        const size_t node = cuts_.size();
        if (end - begin <= kLeaf) return node;
        vec3 low = positions_[order_[begin]], high = low;
        for (size_t i = begin; i < end; ++i) {
            low = glm::min(low, positions_[order_[i]]);
            high = glm::max(high, positions_[order_[i]]);
        }
        const vec3 size = high - low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const size_t middle = (begin + end) / 2;
        const auto at = [this](size_t i) {
            return order_.begin() + static_cast<std::ptrdiff_t>(i);
        };
        std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
            return positions_[a][axis] < positions_[b][axis];
        });
        cuts_.push_back({axis, positions_[order_[middle]][axis]});
        rights_.push_back(0);
        split(begin, middle);
        rights_[node] = cuts_.size();
        split(middle, end);
        return node;
    }

    void search(size_t begin, size_t end, size_t node, const vec3& at, Nearest& nearest) const
    {
        if (end - begin <= kLeaf) {
            for (size_t i = begin; i < end; ++i) {
                const vec3 d = positions_[order_[i]] - at;
                nearest.add(glm::dot(d, d));
            }
            return;
        }
        const float away = at[cuts_[node].axis] - cuts_[node].value;
        const size_t middle = (begin + end) / 2, left = node + 1, right = rights_[node];
        const auto there = [&](bool low) {
            low ? search(begin, middle, left, at, nearest)
                : search(middle, end, right, at, nearest);
        };
        there(away < 0);
        if (away * away <= nearest.reach()) there(!(away < 0));
    }

    std::span<const vec3> positions_;
    std::vector<uint32_t> order_;
    std::vector<Cut> cuts_;       // inner nodes, the left child after each
    std::vector<size_t> rights_;  // the other child
};

}  // namespace

void lightRadii(std::span<const vec3> positions, float alone, std::span<float> radii)
{
    const Neighbours neighbours(positions);
    for (size_t i = 0; i < positions.size(); ++i) {
        Nearest nearest;
        neighbours.find(positions[i], nearest);
        radii[i] = nearest.count > 0 ? 2 * std::sqrt(nearest.distances[0]) : alone;
    }
}

}  // namespace core::many_lights

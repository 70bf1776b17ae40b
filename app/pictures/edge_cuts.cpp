// See edge_cuts.h.
#include "app/pictures/edge_cuts.h"

#include <array>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/parallel.h"
#include "shared/display.h"

namespace app {

namespace {

constexpr int kMostRun = static_cast<int>(shared::kMostCutRun);
constexpr uint32_t kAllAlike = 0x1ff;

/// Which neighbours show one surface, as a guide says.
class Surfaces {
public:
    explicit Surfaces(const core::Image& guide) : size_(guide.width, guide.height)
    {
        bits_.reserve(guide.pixels.size());
        for (const float v : guide.pixels) bits_.push_back(static_cast<uint16_t>(v));
    }

    bool holds(glm::ivec2 p) const
    {
        return p.x >= 0 && p.y >= 0 && p.x < size_.x && p.y < size_.y;
    }
    /// Of a pixel of the picture and a neighbour, which need not be one.
    bool alike(glm::ivec2 p, glm::ivec2 to) const
    {
        const uint32_t bits = bits_[size_t(p.y) * size_t(size_.x) + size_t(p.x)];
        return (bits >> (4 + 3 * to.y + to.x) & 1) != 0;
    }

private:
    glm::ivec2 size_;
    std::vector<uint16_t> bits_;
};

struct Cut {
    int run = 0;        // of the step; 0: there is none
    uint32_t bits = 0;  // shared::displayCut
};

/// The edges on one side of pixels.
struct Edges {
    const Surfaces& surfaces;
    glm::ivec2 side, along;
    uint32_t number;  // of the side, for shared::displayCut

    bool isEdge(glm::ivec2 p) const { return surfaces.holds(p + side) && !surfaces.alike(p, side); }

    bool goesOn(glm::ivec2 p, glm::ivec2 way) const
    {
        return surfaces.alike(p, way) && surfaces.alike(p + side, way) && isEdge(p + way);
    }

    /// For how many more pixels it goes on, `most` at the most.
    int runFrom(glm::ivec2 p, glm::ivec2 way, int most) const
    {
        int n = 0;
        while (n < most && goesOn(p + n * way, way)) ++n;
        return n;
    }

    /// Whether it ends with a step of one pixel: what is across it is beside p, too, but not beside
    /// what is behind p.
    bool stepsAt(glm::ivec2 p, glm::ivec2 way) const
    {
        return surfaces.holds(p + way) && !surfaces.alike(p, way) &&
               surfaces.alike(p + side, way) && surfaces.alike(p + way, side) &&
               surfaces.alike(p, way - side);
    }

    /// Of the nearer of the edge's two ends.
    Cut cutAt(glm::ivec2 p) const
    {
        if (!isEdge(p) || !surfaces.alike(p, -side)) return {};
        Cut cut;
        int nearest = (kMostRun + 1) / 2;
        for (const bool back : {false, true}) {
            const glm::ivec2 way = back ? -along : along;
            const int away = runFrom(p, way, nearest);
            if (away >= nearest || !stepsAt(p + away * way, way)) continue;
            const int run = away + 1 + runFrom(p, -way, kMostRun - 1 - away);
            if (2 * away >= run) continue;
            nearest = away;
            cut = {run, shared::displayCut(static_cast<uint32_t>(run), static_cast<uint32_t>(away),
                                           number, back)};
        }
        return cut;
    }
};

}  // namespace

void addCuts(core::Image& guide)
{
    const Surfaces surfaces(guide);
    const std::array<Edges, 4> sides{
        Edges{surfaces, {1, 0}, {0, 1}, 0}, Edges{surfaces, {-1, 0}, {0, 1}, 1},
        Edges{surfaces, {0, 1}, {1, 0}, 2}, Edges{surfaces, {0, -1}, {1, 0}, 3}};
    core::parallelFor(guide.height, 8, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (uint32_t x = 0; x < guide.width; ++x) {
                float& value = *guide.at(x, static_cast<uint32_t>(y));
                const auto bits = static_cast<uint32_t>(value);
                if (bits == kAllAlike) continue;
                Cut longest;
                for (const Edges& edges : sides)
                    if (const Cut cut = edges.cutAt({x, y}); cut.run > longest.run) longest = cut;
                value = static_cast<float>(bits | longest.bits);
            }
    });
}

}  // namespace app

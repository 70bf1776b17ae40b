// Whether a guide pays: what the paths of an iteration say of the variance and of the cost that
// both ways to sample would have had, with the guide and without, whichever of them they were
// sampled with. No clock is asked, so that a picture does not depend on one. For two ways p and q
// to sample and a path whose contributions c_k were sampled by q, the second moment of p is the
// mean of sum_k c_k (c_k w_k + 2 sum_{i<k} c_i w_i), where w_k is the density of q over that of p
// for the path up to k.
#pragma once

#include <span>
#include <vector>

#include "core/guiding/guide.h"
#include "core/guiding/lesson.h"

namespace core::guiding {

/// What the parts of a path cost, relative to tracing and shading the ray that comes to a vertex.
struct PathCosts {
    double connection = 1;  // of a vertex that roulette leaves alive: an emitter, a new direction
    double look = 0;        // into the guide, where a path arrives
    double choice = 0;      // by the guide, of a direction

    /// From the costs in a box of a few triangles: rays cost more where there are more, and the
    /// guide what it did.
    PathCosts among(size_t triangles) const;
};

/// How the recorded paths were sampled, and how those of the guide would be.
struct TrialRules {
    uint32_t rouletteDepth = 2;
    uint32_t rouletteKind = shared::kRouletteBoth;
    bool rests = false;     // they were sampled without the guide
    double errorFloor = 0;  // added to the squares of pixels that errors are relative to
};

/// One way to sample, as far as paths have told: means per path.
struct WayFigures {
    double variance = 0;     // relative to the squares of pixels
    double arrivals = 0;     // rays that go on, the camera's own included
    double connections = 0;  // vertices that roulette leaves alive
    double choices = 0;      // those of them in leaves that are guided

    double cost(const PathCosts& costs) const
    {
        return arrivals * (1 + costs.look) + connections * costs.connection +
               choices * costs.choice;
    }
};

class Trial {
public:
    /// Takes the paths of an iteration that were sampled while the guide had these tables; those of
    /// `parts`, with their lessons in the same order. Earlier iterations count `decay` from now on.
    /// Nothing is taken from a picture that is black.
    void add(std::span<const PathRecords> parts, std::span<const Lesson> lessons,
             const GuideTables& tables, const TrialRules& rules, double decay);

    /// Paths that count.
    double paths() const { return paths_; }
    WayFigures plain() const { return means(plain_); }
    WayFigures guided() const { return means(guided_); }

    /// Variance times cost without the guide over that with it; 1 while nothing is known.
    double gain(const PathCosts& costs) const;

private:
    WayFigures means(const WayFigures& sums) const;

    double paths_ = 0;
    WayFigures plain_, guided_;  // sums
};

}  // namespace core::guiding

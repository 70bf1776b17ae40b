// How small and how shallow pictures become while the camera moves: the finest that is expected to
// take no longer than asked for, from what the last ones took. Nothing but numbers in it.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace app {

/// A coarse picture: its size, its share of the full one's sides, its depth of paths.
struct PreviewSize {
    glm::uvec2 size{1};
    float scale = 1;
    uint32_t depth = 0;
};

/// What of a coarse picture must not give way, and what has taken its place.
struct PreviewRules {
    bool keepsDepth = false;  // sizes alone may change
    bool fineEdges = false;   // edges and textures have more pixels (MovingDetail)

    friend bool operator==(const PreviewRules&, const PreviewRules&) = default;
};

class ResolutionControl {
public:
    /// `pixels` samples of paths of at most `depth` scattering events took `seconds`. `preview`:
    /// they were one of the pictures that choose() decides about; others tell only as long as there
    /// is nothing better.
    void observe(double pixels, uint32_t depth, double seconds, bool preview);

    /// Expected seconds of one sample at each of `pixels`; 0 when nothing has been observed.
    double predict(double pixels, uint32_t depth) const;

    /// The finest that should take at most `targetSeconds`. Sides shrink in steps of the root of
    /// two down to a quarter, to an eleventh with fine edges, and then depth goes, from `depth`
    /// down to 1: what is coarser still cannot be steered by, so that from there on the rate gives
    /// way. Finer than the last choice only when that leaves room, so that the size does not
    /// flicker. Before the first observation: a quarter. Where depth is kept, sizes go down to an
    /// eighth, and to an eleventh where an eighth would take 2.5 times as long.
    PreviewSize choose(glm::uvec2 full, uint32_t depth, double targetSeconds,
                       PreviewRules rules = {});

    /// Another scene or device: what was observed holds no longer.
    void forget() { *this = {}; }

private:
    struct Step {
        float scale;
        uint32_t depth;
    };
    static std::vector<Step> steps(uint32_t depth, PreviewRules rules);

    double secondsPerWork_ = 0;
    bool fromPreview_ = false;
    size_t last_ = 0;  // the last choice, an index of steps(lastDepth_, lastRules_)
    uint32_t lastDepth_ = 0xffffffffu;
    PreviewRules lastRules_;
};

}  // namespace app

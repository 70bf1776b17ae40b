// Bounds of the rows of a slice, 64 at a time: which of them a light may reach can mostly be told
// for all 64 at once. Arrays over words, for loops that become vectors.
#pragma once

#include <span>
#include <vector>

#include "core/many_lights/row_triple.h"
#include "core/many_lights/virtual_light.h"

namespace core::many_lights {

class RowBounds {
public:
    static constexpr uint32_t kRows = 64;  // of a word

    /// What a light reaches of the rows of a word.
    static constexpr float kNone = 0, kSome = 1, kAll = 2;

    /// Of `count` rows at `position`, with unit shading normals and geometric ones (`side`).
    void reset(const RowTriple& position, const RowTriple& normal, const RowTriple& side,
               uint32_t count);

    /// For each word: kAll where the light is above the planes of all of its rows and shines to
    /// all of them, kNone where that is so of no row, kSome where neither can be told. `sides`: the
    /// geometric planes count, too, and not those of shading alone. The answer is valid until the
    /// next call.
    std::span<const float> reach(const VirtualLight& light, bool sides);

private:
    /// Normals as a cone: cosine and sine of the angle that they make with its axis at most, and by
    /// how much positions differ along them from the middle's.
    struct Cone {
        RowTriple axis;
        std::vector<float> cosine, sine, away;
    };

    void setCone(Cone& cone, const RowTriple& position, const RowTriple& normal, size_t word,
                 uint32_t begin, uint32_t end);
    void judge(const VirtualLight& light, const Cone& cone);
    void judgeSide(const VirtualLight& light);

    RowTriple middle_;
    std::vector<float> radius_;
    Cone shading_, geometric_;
    std::vector<float> reach_;
};

}  // namespace core::many_lights

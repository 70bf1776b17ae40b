// Places on what is shown of a world and does not shine: where light is looked for before there is
// a hierarchy to trace rays in.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/pcg32.h"
#include "shared/layout.h"

namespace core {

struct Prototype;
struct World;

/// Draws them, half by area, half by triangles, for what is detailed is looked at; on either side.
/// Holds on to the world.
class ShownPlaces {
public:
    struct Place {
        glm::vec3 position{0}, normal{0};
    };

    /// Draws by triangles among all, until this many have shone; then among those that do not.
    static constexpr int kTries = 64;

    explicit ShownPlaces(const World& world);

    /// Whether there is none: then nothing may be drawn.
    bool empty() const { return !(total_ > 0); }

    Place draw(Pcg32& random) const;

private:
    struct Shown {
        uint64_t triangle = 0;
        uint32_t instance = shared::kNone;
    };
    struct Corners {
        glm::vec3 a{0}, b{0}, c{0};
    };

    bool shines(uint64_t triangle) const;
    Corners cornersOf(const Shown& shown) const;
    double areaBefore(uint64_t triangle) const { return triangle > 0 ? areas_[triangle - 1] : 0; }
    uint64_t triangleAt(double area, uint64_t begin, uint64_t end) const;
    const Prototype& prototypeOf(uint32_t instance) const;
    Shown byArea(Pcg32& random) const;
    Shown byCount(Pcg32& random) const;
    Shown instanced(uint64_t index) const;

    const World& world_;
    uint64_t flat_, shown_;              // triangles that stand for themselves, and all
    std::vector<uint32_t> dark_;         // of the flat ones, where some shine: those that do not
    std::vector<double> areas_;          // twice, of what is stored, up to and with each triangle
    std::vector<double> instancesUpTo_;  // of all up to and with each instance
    double total_ = 0;
};

}  // namespace core

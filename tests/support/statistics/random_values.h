// Random numbers, places and directions for tests: of a seed always the same.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>

#include <glm/glm.hpp>

#include "core/base/pcg32.h"

namespace tests {

/// In [0, 1), of 24 bits.
inline float uniform(std::mt19937& random)
{
    return static_cast<float>(random() >> 8) * 0x1p-24f;
}

inline float uniform(core::Pcg32& random)
{
    return static_cast<float>(random.bits() >> 8) * 0x1p-24f;
}

/// From `low` to `high`, every order of magnitude as often.
inline float logUniform(core::Pcg32& random, double low, double high)
{
    return static_cast<float>(low * std::pow(high / low, random()));
}

class Random {
public:
    explicit Random(uint32_t seed) : engine_(seed) {}
    float operator()() { return uniform(engine_); }
    uint32_t below(size_t n) { return static_cast<uint32_t>(engine_() % n); }
    /// In the unit cube.
    glm::vec3 cube() { return {(*this)(), (*this)(), (*this)()}; }
    /// In a cube about the origin.
    glm::vec3 around(float radius)
    {
        return 2.0f * radius * (glm::vec3((*this)(), (*this)(), (*this)()) - 0.5f);
    }
    glm::vec3 inBox(glm::vec3 low, glm::vec3 high)
    {
        return glm::mix(low, high, glm::vec3((*this)(), (*this)(), (*this)()));
    }
    glm::vec3 direction()
    {
        const float z = 1 - 2 * (*this)(), phi = 6.2831853f * (*this)();
        const float r = std::sqrt(std::max(0.0f, 1 - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }

private:
    std::mt19937 engine_;
};

}  // namespace tests

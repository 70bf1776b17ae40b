// Directions of a leaf as a mixture of von Mises-Fisher lobes that learns (shared/guide_lobes.h):
// expectation-maximisation over the lessons of an iteration, on top of what earlier lessons have
// left with each lobe. J. Vorba et al., "On-line Learning of Parametric Mixture Models for Light
// Transport Simulation" (2014). What differs: steps over whole iterations, bright outliers cut, and
// priors that count effective samples, so that a few bright lessons teach as little as they should.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/guiding/lesson.h"

namespace core::guiding {

class DirectionLobes {
public:
    static constexpr size_t kCount = shared::kLobeCount;

    /// Whether any lesson has brought light.
    bool knowsLight() const { return total_ > 0; }

    /// Half of everything: what a child inherits. The lobes stay where they are.
    void halve();

    /// Earlier lessons count so much less from now on: they went to the lobes that there were then.
    /// How many there have been is not forgotten.
    void fade(double factor);

    void learn(std::span<const Lesson> lessons);

    /// shared::kLobeWords in the order of shared::sampleGuideLobes.
    void write(std::span<glm::vec4> words) const;

private:
    struct Light {
        glm::vec3 direction;
        float value;
    };

    using Floats = std::array<float, kCount>;

    /// Of each lobe: the light that came by it, and its sum as vectors.
    struct Sums {
        Floats light{}, x{}, y{}, z{};
    };

    struct Lobes {
        Floats x{}, y{}, z{}, kappa{}, peak{}, mass{};
    };

    float bound(std::span<const Light> lights) const;
    std::vector<Light> lightsOf(std::span<const Lesson> lessons);
    void seed(std::span<const Light> lights);
    void expect(std::span<const Light> lights, Sums& sums) const;
    void maximise(const Sums& sums);

    Sums kept_;
    double total_ = 0, squares_ = 0, count_ = 0;  // of values of lessons that brought light
    Lobes lobes_;
};

}  // namespace core::guiding

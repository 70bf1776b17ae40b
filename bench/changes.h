// Two changes of density to measure with: the truncated Cauchy of the laboratory, and a glossy lobe
// of the renderer seen from two directions.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/reuse/change.h"
#include "shared/microfacet.h"
#include "shared/warp.h"

namespace bench {

/// A Cauchy density of width .1 on [0, 1] whose centre moves from .45 to .55; f = x.
template <class R> class CauchyChange {
public:
    using Real = R;
    using Point = R;
    using Value = R;

    R q(R x) const { return old_.pdf(x); }
    R p(R x) const { return new_.pdf(x); }
    R f(R x) const { return x; }
    template <class Random> R sampleP(Random& random) const
    {
        return new_.inverse(core::reuse::uniform<R>(random));
    }

    std::vector<R> oldSamples(size_t count) const
    {
        core::Pcg32 random(7);
        std::vector<R> samples(count);
        for (R& x : samples) x = old_.inverse(core::reuse::uniform<R>(random));
        return samples;
    }

private:
    struct Lobe {
        R centre, width, start, span, scale;
        Lobe(R m, R s)
            : centre(m), width(s), start(std::atan(-m / s)), span(std::atan((1 - m) / s) - start),
              scale(s / span)
        {}
        R pdf(R x) const
        {
            const R d = x - centre;
            return scale / (width * width + d * d);
        }
        R inverse(R xi) const { return centre + width * std::tan(start + xi * span); }
    };
    Lobe old_{R(0.45), R(0.1)}, new_{R(0.55), R(0.1)};
};

/// GGX reflection of alpha .2 by visible normals, in the frame of the surface; the outgoing
/// direction turns by six degrees. f = the cosine.
class GgxChange {
public:
    using Real = float;
    using Point = glm::vec3;
    using Value = float;

    float q(const glm::vec3& wi) const { return pdf(before_, wi); }
    float p(const glm::vec3& wi) const { return pdf(after_, wi); }
    float f(const glm::vec3& wi) const { return wi.z; }
    template <class Random> glm::vec3 sampleP(Random& random) const { return draw(after_, random); }

    std::vector<glm::vec3> oldSamples(size_t count) const
    {
        core::Pcg32 random(7);
        std::vector<glm::vec3> samples(count);
        for (glm::vec3& wi : samples) wi = draw(before_, random);
        return samples;
    }

private:
    static constexpr float kAlpha = 0.2f;
    struct View {
        glm::vec3 wo;
        float depth;
        explicit View(float angle)
            : wo(std::sin(angle), 0, std::cos(angle)),
              depth(shared::capDepth(wo.z, kAlpha * kAlpha, false))
        {}
    };
    static float pdf(const View& view, const glm::vec3& wi)
    {
        return shared::reflectFacet(view.wo, wi, kAlpha, view.depth).pdf;
    }
    template <class Random> static glm::vec3 draw(const View& view, Random& random)
    {
        const float x = core::reuse::uniform<float>(random),
                    y = core::reuse::uniform<float>(random);
        const glm::vec3 h =
            shared::visibleNormal(view.wo, kAlpha, view.depth, shared::sampleDisk(glm::vec2(x, y)));
        return shared::mirrorAbout(view.wo, h);
    }
    View before_{0.7f}, after_{0.8f};
};

}  // namespace bench

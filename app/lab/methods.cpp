// The table of methods. See methods.h.
#include "app/lab/methods.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/base/check.h"

namespace app::lab {

namespace {

constexpr std::array kMethods{
    Method{"discard", "Discard", "(1/n) Σ f(y)/p(y)",
           "Throws the old samples away and draws n new ones: what a renderer does when the camera "
           "moves.",
           "", true, true},
    Method{"full", "Full sample", "(1/M) Σ f(y)/p(y),  M = N/c",
           "As many new samples as reuse would come to: the ceiling, at many times the rays.", "",
           true, true},
    Method{"reweighting", "Reweighting", "(1/N) Σ f(x)/q(x)",
           "Old samples only, each divided by the density that it was drawn with.",
           "q > 0 wherever f is not zero, or energy is lost silently", true, false},
    Method{"reweighting-normalised", "Reweighting, self-normalised", "Σ (f/p)(p/q) / Σ (p/q)",
           "Reweighting divided by the mean of its weights: exact where f is proportional to p, "
           "with a bias of order 1/N.",
           "q > 0 wherever p is", false, false},
    Method{"rejection", "Rejection", "(b/N) Σ f(x)/p(x) over the accepted,  b = sup p/q",
           "Accepts an old sample with probability p/(b q); the accepted are exact samples of p.",
           "the majorisation constant b, finite", true, false},
    Method{"ris", "RIS of the old set", "W (1/n) Σ f(y)/p(y),  W = (1/N) Σ p(x)/q(x)",
           "Picks n of the old samples, each with probability proportional to p/q: samples of p "
           "without new rays, but with the variance of reweighting and more.",
           "q > 0 wherever f is not zero", true, false},
    Method{
        "augmentation", "Augmentation", "(1/(aN)) Σ f/p over old and added,  a = sup q/p",
        "Keeps all old samples and adds (a − 1)N of the density (a p − q)/(a − 1): together they "
        "are samples of p.",
        "the majorisation constant a, finite; nearly all work is new when it is large", true, true},
    Method{"rejection-augmentation", "Rejection-Augmentation",
           "(1/M) Σ f/p over kept and added,  keep with w = min(1, p/(c q))",
           "Removes old samples where there are too many, adds M R(c) of the residual density "
           "where there are too few.",
           "the residual mass R(c), and exact samples of the residual", true, true},
    Method{"ra", "Reweighting-Augmentation", "(1/N) Σ f/max(q, p/c) + (1/n) Σ W f(y)/p(y)",
           "Old samples stay, with a smaller weight where there are too many; new ones are "
           "resampled among k candidates of p with weight 1 − min(1, c q/p), so that they go where "
           "too few are.",
           "", true, true},
    Method{"ra-thinned", "Thinned R-A", "(1/N) Σ f/max(q, p/c) + (1/M) Σ f(z)/p(z) over traced",
           "Draws M candidates of p and traces each with probability 1 − min(1, c q/p): exact "
           "residual samples, in a random number.",
           "", true, true},
    Method{"mis", "MIS, balance heuristic", "Σ f/(N q + n p) over old and new",
           "Old samples of q and new ones of p, each weighted by the density of both techniques "
           "together; nothing is steered.",
           "", true, true},
};

}  // namespace

std::span<const Method> methods()
{
    return kMethods;
}

const Method& methodOf(std::string_view id)
{
    const auto found =
        std::find_if(kMethods.begin(), kMethods.end(), [&](const Method& m) { return m.id == id; });
    CHECK(found != kMethods.end());
    return *found;
}

}  // namespace app::lab

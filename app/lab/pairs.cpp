// The changes of density of the one-dimensional laboratory. See pairs.h.
#include "app/lab/pairs.h"

#include <algorithm>

#include "core/base/check.h"

namespace app::lab {

core::reuse::Masses Pair::overSampled(double c) const
{
    const std::vector<double> ends = crossings(q, p, c);
    core::reuse::Masses masses;
    for (size_t i = 1; i < ends.size(); ++i) {
        const double middle = (ends[i - 1] + ends[i]) / 2;
        if (!(p.pdf(middle) > c * q.pdf(middle))) continue;
        masses.p += p.cdf(ends[i]) - p.cdf(ends[i - 1]);
        masses.q += q.cdf(ends[i]) - q.cdf(ends[i - 1]);
    }
    return masses;
}

double Pair::residual(double c) const
{
    const core::reuse::Masses masses = overSampled(c);
    return masses.p - c * masses.q;
}

double Pair::bestC(double oldSamples, double newSamples) const
{
    return core::reuse::solveC(oldSamples, newSamples, [this](double c) { return overSampled(c); });
}

const std::array<Pair, kPairs>& pairs()
{
    using D = Density;
    static const std::array<Pair, kPairs> table{{
        {"D1", "no change", "the densities are equal: every old sample is as good as a new one",
         "C(.5, .1) → C(.5, .1)", D::cauchy(.5, .1), D::cauchy(.5, .1)},
        {"D2", "small shift", "the lobe moved by its own width", "C(.45, .1) → C(.55, .1)",
         D::cauchy(.45, .1), D::cauchy(.55, .1)},
        {"D3", "large shift", "the lobe moved by ten times its width", "C(.25, .05) → C(.75, .05)",
         D::cauchy(.25, .05), D::cauchy(.75, .05)},
        {"D4", "narrowing", "the lobe became four times narrower", "C(.5, .2) → C(.5, .05)",
         D::cauchy(.5, .2), D::cauchy(.5, .05)},
        {"D5", "widening", "the lobe became four times wider", "C(.5, .05) → C(.5, .2)",
         D::cauchy(.5, .05), D::cauchy(.5, .2)},
        {"D6", "flat to ramp", "no bound on q/p: the new density vanishes at 0", "U[0, 1] → 2x",
         D::uniform(0, 1), D::linearUp()},
        {"D7", "ramp reversed",
         "no bound on q/p nor on p/q: each vanishes where the other is largest", "2 − 2x → 2x",
         D::linearDown(), D::linearUp()},
        {"D8", "shorter tail", "the density falls three times faster", "Exp(2) → Exp(6)",
         D::exponential(2), D::exponential(6)},
        {"D9", "partial overlap", "each density reaches where the other vanishes",
         "U[0, .6] → U[.4, 1]", D::uniform(0, .6), D::uniform(.4, 1)},
    }};
    return table;
}

const Pair* findPair(std::string_view id)
{
    const auto found = std::find_if(pairs().begin(), pairs().end(),
                                    [&](const Pair& pair) { return pair.id == id; });
    return found == pairs().end() ? nullptr : &*found;
}

const Pair& pairOf(std::string_view id)
{
    const Pair* pair = findPair(id);
    CHECK(pair);
    return *pair;
}

}  // namespace app::lab

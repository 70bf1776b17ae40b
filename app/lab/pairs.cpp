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
        {"D1", "no change", "C(.5, .1) → C(.5, .1)", D::cauchy(.5, .1), D::cauchy(.5, .1)},
        {"D2", "small shift", "C(.45, .1) → C(.55, .1)", D::cauchy(.45, .1), D::cauchy(.55, .1)},
        {"D3", "large shift", "C(.25, .05) → C(.75, .05)", D::cauchy(.25, .05),
         D::cauchy(.75, .05)},
        {"D4", "narrowing", "C(.5, .2) → C(.5, .05)", D::cauchy(.5, .2), D::cauchy(.5, .05)},
        {"D5", "widening", "C(.5, .05) → C(.5, .2)", D::cauchy(.5, .05), D::cauchy(.5, .2)},
        {"D6", "no bound on q/p", "U[0, 1] → 2x", D::uniform(0, 1), D::linearUp()},
        {"D7", "no bound on q/p nor on p/q", "2 − 2x → 2x", D::linearDown(), D::linearUp()},
        {"D8", "shorter tail", "Exp(2) → Exp(6)", D::exponential(2), D::exponential(6)},
        {"D9", "supports overlap in part", "U[0, .6] → U[.4, 1]", D::uniform(0, .6),
         D::uniform(.4, 1)},
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

// See lab_results.h.
#include "tests/support/methods/lab_results.h"

#include <iterator>
#include <random>

#include "app/lab/functions.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"

namespace tests {

namespace {

/// Two rows of three pixels, exact and estimated.
app::lab::FlatlandPicture somePicture()
{
    app::lab::FlatlandPicture p;
    p.low = -0.3;
    p.width = 0.6;
    p.pixels = 3;
    p.rows = 2;
    p.truth = {0.5, 1, 1.5};
    p.strips = {{"before", "as it was", true, true, {1.5, 0, 0.5}, 0, 0, false},
                {"discard", "anew", false, true, {0.4, 1.2, 1, 0.6, 0.8, 2}, 0.3, 0.01, false},
                {"exact, 32 old, corrected",
                 "reused",
                 false,
                 true,
                 {0.45, 1.1, 1.4, 0.55, 0.9, 1.6},
                 0.15,
                 0.01,
                 false},
                {"old values", "wrong", false, false, {1, 1, 1, 1, 1, 1}, 0.1, 0.4, true}};
    p.samples = {{0.1, 0.5, false, 0.25}, {0.12, 0.1, true, 1}};
    return p;
}

}  // namespace

app::lab::Cell cellOf(const std::string& pair, const std::string& function,
                      const std::string& method, double expected)
{
    app::lab::Cell c;
    c.pair = pair;
    c.function = function;
    c.method = method;
    c.oldSamples = 8;
    c.newSamples = app::lab::methodOf(method).fresh ? 8 : 0;
    c.rays = c.newSamples;
    c.candidates = method == "ra" ? 4 : 0;
    c.trials = 1000;
    c.truth = 1;
    c.mean = 1.001;
    c.standardError = 0.001;
    c.expectedVariance = c.variance = expected;
    c.varianceError = 0.01;
    c.ess = 7;
    return c;
}

app::lab::LabResults someResults()
{
    using namespace app::lab;
    LabResults r;
    r.trials = 1000;
    r.seed = 5;
    r.seconds = 1.5;
    r.version = "0.0.1";
    r.commit = "c0ffee";
    std::mt19937 random(7);
    std::uniform_real_distribution<double> size(0.1, 2);
    for (const Pair& pair : pairs())
        for (const TestFunction& f : functions()) {
            for (const char* method : {"discard", "reweighting", "ra", "mis"})
                r.cells.push_back(cellOf(pair.id, f.id, method, size(random)));
            for (const Beta beta : {Beta::ideal, Beta::own})
                for (const char* method : {"ra", "mis"}) {
                    Cell c = cellOf(pair.id, f.id, method, size(random));
                    c.beta = beta;
                    if (beta == Beta::own) c.expectedVariance = kUnknown;
                    r.cells.push_back(c);
                }
        }
    for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0})
        r.overC.push_back({"D2", "F1", factor, 4, size(random), 0.02, size(random), 0.3});
    for (const uint32_t k : {1u, 4u, 16u})
        r.overK.push_back({"D2", "F2", 1, k, size(random), 0.02, size(random), 0.3});
    for (int i = 0; i < 5; ++i)
        r.majorisation.push_back({0.45 + 0.1 * i, 1 + i * 1.0, 1 + i * 2.0, 0.5, 2, 0.1 * i, 0.5});
    for (const bool unbiased : {true, false}) {
        LobeSequence s{0.01, unbiased ? "R-A" : "equal weights", 8, unbiased, {}, 0.1, 0.107, 0.01};
        for (int i = 0; i < 40; ++i) s.frames.push_back({0.001 * i, 0.1 * i, 1 / (1.0 + i)});
        r.lobes.push_back(s);
    }
    for (const double step : {0.01, 0.04}) r.stores.push_back({step, 16, 64, 1, 0.08, 2});
    r.stores.push_back({0.01, 16, 16, 0, 0.2, 1});
    r.flatland.push_back({"exact", "with all that it takes", true, 1.58516, 1.585, -1e-4, -0.4,
                          0.1005, 0.001, 0, 0.1, 1, 1000});
    r.picture = somePicture();
    r.traps.push_back({"a trap", "this way", "that way", -0.0052, -17, 1e-5, 0.2, -0.0052, 2000});
    return r;
}

app::lab::LabResults hostileResults()
{
    using namespace app::lab;
    LabResults r = someResults();
    const double odd[] = {kUnknown, kInfinite, -kInfinite, 0, -1, 1e300, 1e-300};
    size_t i = 0;
    const auto next = [&] { return odd[i++ % std::size(odd)]; };
    for (Cell& c : r.cells)
        for (double* x : {&c.c, &c.mean, &c.standardError, &c.variance, &c.varianceError,
                          &c.expectedVariance, &c.expectedMean, &c.rays, &c.densities, &c.ess})
            *x = next();
    for (auto* list : {&r.overC, &r.overK})
        for (SweepPoint& p : *list)
            for (double* x : {&p.variance, &p.varianceError, &p.expectedVariance, &p.z})
                *x = next();
    for (MajorisationPoint& p : r.majorisation)
        for (double* x : {&p.position, &p.rejection, &p.augmentation, &p.c, &p.growth,
                          &p.totalVariation, &p.reweightingEss})
            *x = next();
    for (LobeSequence& s : r.lobes) {
        for (double* x : {&s.lateVarianceRatio, &s.expectedRatio, &s.largestBias}) *x = next();
        for (LobeFrame& f : s.frames)
            for (double* x : {&f.bias, &f.z, &f.varianceRatio}) *x = next();
    }
    for (StoreResult& s : r.stores)
        for (double* x : {&s.lateVarianceRatio, &s.largestZ}) *x = next();
    for (FlatlandResult& f : r.flatland)
        for (double* x : {&f.truth, &f.mean, &f.bias, &f.z, &f.variance, &f.varianceError,
                          &f.expectedBias, &f.expectedVariance, &f.meanWeight})
            *x = next();
    for (double* x : {&r.picture.low, &r.picture.truth[0]}) *x = next();
    for (FlatlandStrip& s : r.picture.strips) {
        for (double* x : {&s.noise, &s.bias}) *x = next();
        for (double& x : s.values) x = next();
    }
    for (FlatlandSample& s : r.picture.samples)
        for (double* x : {&s.ground, &s.direction, &s.weight}) *x = next();
    for (Trap& t : r.traps)
        for (double* x : {&t.wrongBias, &t.wrongZ, &t.rightBias, &t.rightZ, &t.expectedBias})
            *x = next();
    const std::string markup = "a,b \"<svg onload='x'>&amp;\n</td>";
    r.version = r.commit = markup;
    r.cells[0].pair = r.cells[0].function = markup;
    r.cells[1].method = r.lobes[0].method = r.flatland[0].variant = r.traps[0].wrong = markup;
    r.picture.strips[0].name = r.picture.strips[1].meaning = markup;
    r.seconds = kUnknown;
    return r;
}

}  // namespace tests

// Runs of completion on synthetic matrices: one, the mean of five, and all its variants.
#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "tests/support/methods/visibility_matrices.h"

namespace tests {

using core::many_lights::CompletedSlice;
using core::many_lights::CompletionParams;

/// Completes a matrix as a single octant.
inline CompletedSlice completed(const BitMatrix& truth, const CompletionParams& params,
                                uint64_t seed = 1)
{
    MatrixOracle oracle(truth);
    CompletedSlice slice;
    const std::vector<core::many_lights::ColumnRange> octants{{0, truth.columns()}};
    core::many_lights::complete(oracle, truth.rows(), octants, params, seed, slice);
    EXPECT_EQ(slice.stats.rays, oracle.rays());
    return slice;
}

inline CompletionParams fullSampling()
{
    CompletionParams params;
    params.method = core::many_lights::CompletionMethod::full;
    return params;
}

/// Matching alone: columns without a match are traced in full, and no borders of shadows are.
inline CompletionParams wholeColumns()
{
    CompletionParams params;
    params.onMismatch = core::many_lights::OnMismatch::full;
    return params;
}

/// The author's preset with a fixed rate and without verification.
inline CompletionParams fixedRate(float rate)
{
    CompletionParams params = CompletionParams::authorPreset();
    params.rowRate = rate;
    params.verificationRate = 0;
    return params;
}

struct Mean {
    double rays = 0, author = 0, error = 0, basis = 0, rate = 0;  // the first three in per cent
};

/// Of five matrices that `make` makes and five seeds.
inline Mean meanOf(const CompletionParams& params, const auto& make)
{
    Mean mean;
    for (uint64_t seed = 0; seed < 5; ++seed) {
        core::Pcg32 random(100 + seed);
        const BitMatrix truth = make(random);
        const CompletedSlice slice = completed(truth, params, seed);
        mean.rays += 20 * slice.stats.visibility();
        mean.author += 20 * slice.stats.authorVisibility();
        mean.error += 20 * bitError(truth, slice.visible);
        mean.basis += double(slice.stats.basis) / 5;
        mean.rate += slice.stats.meanRate() / 5;
    }
    return mean;
}

/// A way to complete that differs from the others by more than a number.
struct Variant {
    const char* name;
    CompletionParams params;
};

inline std::vector<Variant> variants()
{
    std::vector<Variant> all{{"ours", {}}, {"author", CompletionParams::authorPreset()}};
    const auto add = [&](const char* name, const auto& change) {
        all.push_back({name, {}});
        change(all.back().params);
    };
    add("one by one", [](CompletionParams& p) { p.block = 1; });
    add("verified later", [](CompletionParams& p) { p.joint = false; });
    add("by chance", [](CompletionParams& p) { p.disambiguate = false; });
    add("two-phase", [](CompletionParams& p) { p.twoPhase = true; });
    add("two-phase, verified later", [](CompletionParams& p) {
        p.twoPhase = true;
        p.joint = false;
    });
    add("residual", [](CompletionParams& p) { p.residualRate = 0.05f; });
    add("whole columns", [](CompletionParams& p) { p = wholeColumns(); });
    add("residual, whole columns", [](CompletionParams& p) {
        p = wholeColumns();
        p.residualRate = 0.05f;
    });
    add("recursion",
        [](CompletionParams& p) { p.onMismatch = core::many_lights::OnMismatch::recursion; });
    add("no bail-out", [](CompletionParams& p) { p.bailOut = 1; });
    add("few rows", [](CompletionParams& p) { p.rowMinimum = 1; });
    add("gauss-jordan",
        [](CompletionParams& p) { p.method = core::many_lights::CompletionMethod::gaussJordan; });
    add("amc", [](CompletionParams& p) { p.method = core::many_lights::CompletionMethod::amc; });
    add("seeded", [](CompletionParams& p) { p.seedConstant = true; });
    return all;
}

/// Small matrices of every kind.
inline std::vector<BitMatrix> matrices()
{
    core::Pcg32 random(11);
    std::vector<BitMatrix> all;
    all.push_back(dictionaryMatrix(500, 90, 9, random));
    all.push_back(edgesMatrix(333, 120, random));
    all.push_back(spheresMatrix(20, 120, 3, 0.1, 0.3, random));
    all.push_back(foliageMatrix(200, 60, 10, random));
    all.push_back(randomMatrix(65, 40, 0.5, random));
    return all;
}

}  // namespace tests

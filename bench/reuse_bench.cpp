// Micro-benchmarks of sample reuse (core/reuse, shared/reuse.h): what an old sample costs beside a
// ray. Target: 20 million weights of old samples per second and core with both densities evaluated.
// Run: ninja -C build micro_benchmarks && build/micro_benchmarks
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "bench/changes.h"
#include "core/reuse/estimators.h"
#include "core/reuse/resample.h"

namespace {

using bench::CauchyChange;
using bench::GgxChange;
using core::Pcg32;
namespace reuse = core::reuse;

constexpr size_t kOld = 1024;  // fits the first cache

/// The old samples of R-A in one step: two densities, alpha / q, f, and the sums.
template <class C> void oldSamples(benchmark::State& state)
{
    const C change;
    const std::vector<typename C::Point> old = change.oldSamples(kOld);
    const reuse::MinimumFraction<typename C::Real> fraction{typename C::Real(0.6)};
    for (auto _ : state) {
        reuse::EstimateOf<C> estimate;
        reuse::addOld(estimate, change, std::span<const typename C::Point>(old),
                      static_cast<typename C::Real>(kOld), fraction);
        benchmark::DoNotOptimize(estimate);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kOld));
}
BENCHMARK(oldSamples<CauchyChange<double>>);
BENCHMARK(oldSamples<CauchyChange<float>>);
BENCHMARK(oldSamples<GgxChange>);

/// The weights alone, from arrays of densities: what vector units can do.
template <class Real> void weightsOfArrays(benchmark::State& state)
{
    Pcg32 random(1);
    std::vector<Real> q(kOld), p(kOld), weights(kOld);
    for (size_t i = 0; i < kOld; ++i) {
        q[i] = static_cast<Real>(10 * random());
        p[i] = static_cast<Real>(10 * random());
    }
    for (auto _ : state) {
        for (size_t i = 0; i < kOld; ++i)
            weights[i] = shared::reuseAlphaOverQ(static_cast<Real>(0.6), q[i], p[i]);
        benchmark::DoNotOptimize(weights.data());
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kOld));
}
BENCHMARK(weightsOfArrays<double>);
BENCHMARK(weightsOfArrays<float>);

/// One new sample of the residual: k candidates drawn, their densities, and the resampling. Items
/// are new samples.
template <class C> void residualSample(benchmark::State& state)
{
    const C change;
    Pcg32 candidates(1), selection(2);
    const reuse::MinimumFraction<typename C::Real> fraction{typename C::Real(0.6)};
    const auto k = static_cast<uint32_t>(state.range(0));
    reuse::EstimateOf<C> estimate;
    for (auto _ : state) {
        auto draw = reuse::drawResidual(estimate, change, 4, k, fraction, candidates, selection);
        benchmark::DoNotOptimize(draw);
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(residualSample<CauchyChange<double>>)->Arg(1)->Arg(8)->Arg(32);
BENCHMARK(residualSample<CauchyChange<float>>)->Arg(8);
BENCHMARK(residualSample<GgxChange>)->Arg(8);

/// The best c of a batch of candidates whose ratios are known.
template <class Real> void solveForC(benchmark::State& state)
{
    const auto k = static_cast<uint32_t>(state.range(0));
    Pcg32 random(1);
    std::vector<std::array<Real, shared::kReuseMaxCandidates>> batches(256);
    for (auto& batch : batches)
        for (Real& ratio : batch) ratio = static_cast<Real>(std::pow(10, 4 * random() - 2));
    for (auto _ : state) {
        for (const auto& batch : batches) {
            Real c = shared::reuseSolveC(Real(8), Real(2), batch.data(), k);
            benchmark::DoNotOptimize(c);
        }
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(batches.size()));
}
BENCHMARK(solveForC<double>)->Arg(8)->Arg(16);
BENCHMARK(solveForC<float>)->Arg(8)->Arg(16);

struct Stored {
    double x, u;
};

/// K + n samples of uneven scores reduced to K by threshold resampling. Items are samples.
void thresholdResampling(benchmark::State& state)
{
    const auto keep = static_cast<uint32_t>(state.range(0));
    const size_t count = keep + 4;
    Pcg32 random(1);
    std::vector<Stored> full(count), samples(count);
    std::vector<double> scores(count);
    for (size_t i = 0; i < count; ++i) {
        scores[i] = std::pow(10, 2 * random());
        full[i] = {random(), scores[i]};
    }
    for (auto _ : state) {
        samples = full;
        size_t kept = reuse::thresholdResample(std::span<Stored>(samples),
                                               std::span<const double>(scores), keep, random());
        benchmark::DoNotOptimize(kept);
        benchmark::ClobberMemory();
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(count));
}
BENCHMARK(thresholdResampling)->Arg(8)->Arg(32)->Arg(128);

/// A whole estimate of R-A as a pixel makes it: N = 32 old samples, n = 4 new ones, k = 8. Items
/// are estimates.
template <class C> void wholeEstimate(benchmark::State& state)
{
    const C change;
    const std::vector<typename C::Point> old = change.oldSamples(32);
    const reuse::MinimumFraction<typename C::Real> fraction{typename C::Real(0.6)};
    Pcg32 candidates(1), selection(2);
    for (auto _ : state) {
        auto estimate = reuse::reweightingAugmentation(
            change, std::span<const typename C::Point>(old), typename C::Real(32), 4, 8, fraction,
            candidates, selection);
        benchmark::DoNotOptimize(estimate);
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(wholeEstimate<CauchyChange<double>>);
BENCHMARK(wholeEstimate<GgxChange>);

}  // namespace

BENCHMARK_MAIN();

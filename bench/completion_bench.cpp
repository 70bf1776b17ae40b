// Micro-benchmarks of completion (core/many_lights): what it costs beside its rays, which an oracle
// that copies bits answers for next to nothing. Items are columns; the time of the same calls of
// the oracle alone is `oracle_ns` per column. Target: below one microsecond per column. Run: ninja
// -C build micro_benchmarks && build/micro_benchmarks --benchmark_filter=complet
#include <benchmark/benchmark.h>

#include <algorithm>
#include <bit>
#include <vector>

#include "core/base/pcg32.h"
#include "core/completion/basis.h"
#include "core/completion/completion.h"
#include "core/completion/row_weights.h"

namespace {

using namespace core::many_lights;
using core::Pcg32;

/// Answers from a matrix, word by word.
class CopyOracle : public VisibilityOracle {
public:
    explicit CopyOracle(const BitMatrix& truth) : truth_(truth) {}
    void trace(std::span<const TraceRequest> requests) override
    {
        for (const TraceRequest& request : requests) {
            const auto truth = truth_.column(request.column);
            for (size_t w = 0; w < truth.size(); ++w) {
                request.visible[w] |= truth[w] & request.rows[w];
                rays_ += static_cast<uint64_t>(std::popcount(request.rows[w]));
            }
        }
    }
    const uint64_t* matters(uint32_t) const override { return nullptr; }

private:
    const BitMatrix& truth_;
    uint64_t rays_ = 0;
};

/// A room: `mixed` of the columns show one of `shadows` edges each, the others are all lit or dark.
BitMatrix roomMatrix(uint32_t rows, uint32_t columns, double mixed, uint32_t shadows)
{
    Pcg32 random(1);
    std::vector<uint32_t> edges;
    for (uint32_t s = 0; s < shadows; ++s) edges.push_back(drawBelow(rows, random));
    BitMatrix truth(rows, columns);
    for (uint32_t j = 0; j < columns; ++j) {
        const uint32_t edge = random() < mixed ? edges[drawBelow(shadows, random)]
                              : random() < 0.5 ? 0
                                               : rows;
        for (uint32_t i = edge; i < rows; ++i) truth.set(i, j, true);
    }
    return truth;
}

/// A slice of 1000 columns in eight octants. Rows, per cent of mixed columns, shadows.
void completeSlice(benchmark::State& state, const CompletionParams& params)
{
    const auto rows = static_cast<uint32_t>(state.range(0));
    const BitMatrix truth = roomMatrix(rows, 1000, 0.01 * double(state.range(1)),
                                       static_cast<uint32_t>(state.range(2)));
    std::vector<ColumnRange> octants;
    for (uint32_t o = 0; o < 8; ++o) octants.push_back({125 * o, 125 * (o + 1)});
    CopyOracle oracle(truth);
    CompletedSlice slice;
    CompletionStats sum;
    uint64_t seed = 0;
    for (auto _ : state) {
        complete(oracle, rows, octants, params, ++seed, slice);
        sum += slice.stats;
        benchmark::DoNotOptimize(slice.visible.words().data());
    }
    state.SetItemsProcessed(static_cast<int64_t>(sum.columns));
    state.counters["vis%"] = 100 * sum.visibility();
    state.counters["basis"] = double(sum.basis) / double(state.iterations());
    state.counters["oracle_ns"] = 1e9 * sum.traceSeconds / double(sum.columns);
}

void completeOurs(benchmark::State& state)
{
    completeSlice(state, {});
}
BENCHMARK(completeOurs)->Args({1000, 5, 10})->Args({2000, 5, 10})->Args({1000, 40, 100});

void completeAuthor(benchmark::State& state)
{
    completeSlice(state, CompletionParams::authorPreset());
}
BENCHMARK(completeAuthor)->Args({1000, 5, 10});

void completeRepair(benchmark::State& state)
{
    CompletionParams params;
    params.onMismatch = OnMismatch::repair;
    completeSlice(state, params);
}
BENCHMARK(completeRepair)->Args({2000, 5, 10});

void completeMethod(benchmark::State& state, CompletionMethod method)
{
    CompletionParams params;
    params.method = method;
    params.verificationRate = 0;
    params.rowRate = 0.1f;  // as in the thesis's comparison of methods
    completeSlice(state, params);
}
BENCHMARK_CAPTURE(completeMethod, matching, CompletionMethod::matching)->Args({1000, 5, 10});
BENCHMARK_CAPTURE(completeMethod, gaussJordan, CompletionMethod::gaussJordan)->Args({1000, 5, 10});
BENCHMARK_CAPTURE(completeMethod, amc, CompletionMethod::amc)->Args({1000, 5, 10});

void completeFull(benchmark::State& state)
{
    CompletionParams params;
    params.method = CompletionMethod::full;
    completeSlice(state, params);
}
BENCHMARK(completeFull)->Args({1000, 5, 10});

/// One column against a basis. Columns of the basis.
void completionMatch(benchmark::State& state)
{
    const auto count = static_cast<uint32_t>(state.range(0));
    const BitMatrix truth = roomMatrix(1000, count, 1, 1000);
    Basis basis(1000);
    Words all(wordsFor(1000)), samples(all.size()), checks(all.size());
    for (size_t w = 0; w < all.size(); ++w) all[w] = wordOfRows(1000, w);
    for (uint32_t k = 0; k < count; ++k) basis.push(truth.column(k), all);
    Pcg32 random(2);
    drawUniform(25, all, random, samples);
    drawUniform(25, all, random, checks);
    basis.select(samples, checks);
    ColumnKey key;
    std::vector<Candidate> found;
    uint32_t j = 0;
    for (auto _ : state) {
        basis.makeKey(truth.column(j), all, key);
        basis.match(key, 8, found);
        benchmark::DoNotOptimize(found.data());
        j = (j + 1) % count;
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(completionMatch)->Arg(8)->Arg(64)->Arg(256);

/// A draw of 50 of 1000 rows by weight, as a block of columns needs it.
void completionDraw(benchmark::State& state)
{
    RowWeights weights(1000);
    Words all(wordsFor(1000)), drawn(all.size());
    for (size_t w = 0; w < all.size(); ++w) all[w] = wordOfRows(1000, w);
    Pcg32 random(2);
    for (auto _ : state) {
        std::ranges::fill(drawn, 0);
        weights.draw(50, all, random, drawn);
        benchmark::DoNotOptimize(drawn.data());
    }
}
BENCHMARK(completionDraw);

}  // namespace

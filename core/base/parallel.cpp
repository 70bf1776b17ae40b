// Loops on TBB; how work is cut into blocks depends on the amount of work alone. ThreadSanitizer
// does not see how TBB's library hands a task to another thread, and reports every one. In
// sanitizer builds this file alone is not instrumented; it reports where bodies begin and end
// instead, so that the bodies stay checked.
#include "core/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/task_arena.h>

#include "core/base/handoff.h"

namespace core {

bool parallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body,
                 std::stop_token stop)
{
    const size_t step = std::max<size_t>(grain, 1);
    const size_t blocks = count / step + (count % step != 0 ? 1 : 0);
    std::atomic<bool> complete{true};
    Handoff begun, ended;
    begun.happensBefore();
    tbb::parallel_for(
        tbb::blocked_range<size_t>(0, blocks, 1),
        [&](const tbb::blocked_range<size_t>& range) {
            begun.happensAfter();
            for (size_t block = range.begin(); block != range.end(); ++block) {
                if (stop.stop_requested()) {
                    complete = false;
                    break;
                }
                const size_t begin = block * step;
                body(begin, std::min(count, begin + step));
            }
            ended.happensBefore();
        },
        tbb::simple_partitioner());  // blocks are coarse, and stopping is checked between them
    ended.happensAfter();
    return complete;
}

bool parallelTiles(uint32_t width, uint32_t height, uint32_t side,
                   const std::function<void(const Tile&)>& body, std::stop_token stop)
{
    const uint32_t step = std::max(side, 1u);
    const size_t columns = (size_t(width) + step - 1) / step;
    const size_t rows = (size_t(height) + step - 1) / step;
    const auto runTile = [&](size_t begin, size_t) {
        Tile tile;
        tile.x0 = uint32_t(begin % columns) * step;
        tile.y0 = uint32_t(begin / columns) * step;
        tile.x1 = std::min(width, tile.x0 + step);
        tile.y1 = std::min(height, tile.y0 + step);
        body(tile);
    };
    return parallelFor(columns * rows, 1, runTile, std::move(stop));
}

void parallelInvoke(const std::function<void()>& a, const std::function<void()>& b)
{
    Handoff begun, ended;
    const auto handed = [&](const std::function<void()>& body) {
        begun.happensAfter();
        body();
        ended.happensBefore();
    };
    begun.happensBefore();
    tbb::parallel_invoke([&] { handed(a); }, [&] { handed(b); });
    ended.happensAfter();
}

double parallelSum(size_t count, const std::function<double(size_t)>& term)
{
    constexpr size_t kBlock = 4096;
    std::vector<double> partial((count + kBlock - 1) / kBlock, 0.0);
    parallelFor(count, kBlock, [&](size_t begin, size_t end) {
        double sum = 0;
        for (size_t i = begin; i < end; ++i) sum += term(i);
        partial[begin / kBlock] = sum;
    });
    double total = 0;
    for (const double sum : partial) total += sum;
    return total;
}

void runLast(const std::function<void()>& body)
{
    tbb::task_arena arena(tbb::task_arena::automatic, 1, tbb::task_arena::priority::low);
    arena.execute(body);
}

struct ThreadLimit::Control {
    explicit Control(size_t threads) : limit(tbb::global_control::max_allowed_parallelism, threads)
    {}
    tbb::global_control limit;
};

ThreadLimit::ThreadLimit(size_t threads)
    : control_(threads > 0 ? std::make_unique<Control>(threads) : nullptr)
{}

ThreadLimit::~ThreadLimit() = default;

size_t threadCount()
{
    const size_t allowed =
        tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    return std::min(allowed, size_t(tbb::this_task_arena::max_concurrency()));
}

}  // namespace core

// Loops over all cores. Work is cut into blocks by its size alone, never by the number of threads,
// so whatever a block computes is the same on every machine; order of execution is not defined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>

namespace core {

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct Tile {
    uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Calls body(begin, end) for the blocks [0, grain), [grain, 2 grain), ... of `count` items, on all
/// threads. Blocks that have not begun when `stop` is requested are left out; returns whether every
/// block ran. The first exception of a body ends the loop and is thrown here. `grain` 0 counts
/// as 1.
bool parallelFor(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body,
                 std::stop_token stop = {});

/// Calls body(tile) for tiles of `side` pixels (smaller at the right and bottom edge) that cover
/// the image; as parallelFor.
bool parallelTiles(uint32_t width, uint32_t height, uint32_t side,
                   const std::function<void(const Tile&)>& body, std::stop_token stop = {});

/// Both bodies, at the same time where a thread is free. Returns when both have ended; an exception
/// of either is thrown here.
void parallelInvoke(const std::function<void()>& a, const std::function<void()>& b);

/// Sum of term(i) over i < count, in double: blocks of fixed size are summed in parallel and added
/// in order, so the result does not depend on the number of threads.
double parallelSum(size_t count, const std::function<double(size_t)>& term);

/// Runs `body` here; its loops get other threads only while no other loop wants them.
void runLast(const std::function<void()>& body);

/// While it lives, at most `threads` threads take part in the loops above (0: no limit).
class ThreadLimit {
public:
    explicit ThreadLimit(size_t threads);
    ~ThreadLimit();
    ThreadLimit(const ThreadLimit&) = delete;
    ThreadLimit& operator=(const ThreadLimit&) = delete;

private:
    struct Control;
    std::unique_ptr<Control> control_;
};

/// Threads that a loop may use now, the caller's included.
size_t threadCount();

}  // namespace core

#include "app/bench/bench_clock.h"

#include <algorithm>
#include <ctime>
#include <thread>

namespace app {

static double secondsOf(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double threadSeconds()
{
    return secondsOf(CLOCK_THREAD_CPUTIME_ID);
}

unsigned cores()
{
    return std::max(1u, std::thread::hardware_concurrency());
}

double onHost(const std::function<void()>& work)
{
    const double start = secondsOf(CLOCK_PROCESS_CPUTIME_ID);
    work();
    return (secondsOf(CLOCK_PROCESS_CPUTIME_ID) - start) / cores();
}

double median(std::vector<double> values)
{
    std::ranges::sort(values);
    return values[values.size() / 2];
}

}  // namespace app

#include "app/bench/bench_clock.h"

#include <algorithm>
#include <ctime>
#include <thread>

namespace app {

static double cpuSeconds()
{
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

unsigned cores()
{
    return std::max(1u, std::thread::hardware_concurrency());
}

double onHost(const std::function<void()>& work)
{
    const double start = cpuSeconds();
    work();
    return (cpuSeconds() - start) / cores();
}

double median(std::vector<double> values)
{
    std::ranges::sort(values);
    return values[values.size() / 2];
}

}  // namespace app

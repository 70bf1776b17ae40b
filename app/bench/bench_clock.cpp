#include "app/bench/bench_clock.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <thread>

#include "app/gpu/base/device.h"

namespace app {

static double secondsOf(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

bool worksOnHost(const Target& target)
{
    if (target.device == DeviceKind::cpu) return true;
    return gpu::Device({.index = target.deviceIndex, .validation = false}).isSoftware();
}

double processSeconds()
{
    return secondsOf(CLOCK_PROCESS_CPUTIME_ID);
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
    const double start = processSeconds();
    work();
    return (processSeconds() - start) / cores();
}

double onCard(const std::function<double()>& work)
{
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds waking{100};
    for (const auto start = Clock::now(); Clock::now() - start < waking;) work();
    return work();
}

double median(std::vector<double> values)
{
    std::ranges::sort(values);
    return values[values.size() / 2];
}

}  // namespace app

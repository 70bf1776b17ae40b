// What threads cost in memory.
#include "core/base/per_thread.h"

#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process/sanitized.h"

#ifdef __GLIBC__
#include <link.h>
#endif

namespace core {
namespace {

struct Bench {
    std::vector<int> all = std::vector<int>(10, 7);
    int count = 0;
};

TEST(PerThread, eachHasItsOwnAndKeepsIt)
{
    Bench& mine = perThread<Bench>();
    mine.count = 5;
    EXPECT_EQ(&perThread<Bench>(), &mine);
    Bench* other = nullptr;
    int count = -1;
    std::thread([&] {
        other = &perThread<Bench>();
        count = other->count;
    }).join();
    EXPECT_NE(other, &mine);
    EXPECT_EQ(count, 0);
    EXPECT_EQ(mine.count, 5);
}

#if defined(__GLIBC__) && !defined(REKINDLE_SANITIZED)

/// Dozens of threads, most of them a driver's, hold a copy of it each (it was 1.1 MiB).
TEST(PerThread, threadsBeginWithLittle)
{
    size_t bytes = 0;
    dl_iterate_phdr(
        [](dl_phdr_info* info, size_t, void* out) {
            for (int i = 0; i < info->dlpi_phnum; ++i) {
                if (info->dlpi_phdr[i].p_type == PT_TLS)
                    *static_cast<size_t*>(out) = info->dlpi_phdr[i].p_memsz;
            }
            return 1;  // the first is this program
        },
        &bytes);
    EXPECT_GT(bytes, 0u);
    EXPECT_LT(bytes, size_t(64) << 10);
}

#endif

}  // namespace
}  // namespace core

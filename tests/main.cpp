// Runs all tests; GoogleTest's arguments apply. Ends with "N passed, N failed, N skipped", which
// ./test adds up over its processes.
#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/files/temporary_folder.h"
#include "tests/support/process/kept_objects.h"

/// What the program keeps for its next run goes to a folder of this run's tests. Mesa's compiled
/// kernels stay where they are, or each of the processes would compile all of them.
static void keepOutOfUsersCache(const std::string& folder)
{
    const char* cache = std::getenv("XDG_CACHE_HOME");
    const char* home = std::getenv("HOME");
    const std::string users = cache != nullptr  ? cache
                              : home != nullptr ? std::string(home) + "/.cache"
                                                : folder;
    setenv("MESA_SHADER_CACHE_DIR", users.c_str(), 0);
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);
}

int main(int argc, char** argv)
{
    const tests::TemporaryFolder cache;
    keepOutOfUsersCache(cache.path().string());
    testing::InitGoogleTest(&argc, argv);
    const int result = RUN_ALL_TESTS();
    tests::releaseKeptObjects();
    const testing::UnitTest& tests = *testing::UnitTest::GetInstance();
    std::printf("%d passed, %d failed, %d skipped\n", tests.successful_test_count(),
                tests.failed_test_count(), tests.skipped_test_count());
    std::fflush(nullptr);  // a sanitizer that finds leaks in the end leaves nothing else to do it
    return result;
}

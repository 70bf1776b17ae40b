// Runs all tests; GoogleTest's arguments apply. Ends with "N passed, N failed, N skipped", which
// ./test adds up over its processes.
#include <cstdio>

#include <gtest/gtest.h>

int main(int argc, char** argv)
{
    testing::InitGoogleTest(&argc, argv);
    const int result = RUN_ALL_TESTS();
    const testing::UnitTest& tests = *testing::UnitTest::GetInstance();
    std::printf("%d passed, %d failed, %d skipped\n", tests.successful_test_count(),
                tests.failed_test_count(), tests.skipped_test_count());
    return result;
}

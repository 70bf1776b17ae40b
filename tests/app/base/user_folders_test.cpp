// Where things of the user are kept follows the XDG base directory specification (N25): relative
// names are to be ignored, and without a home there is no place.
#include <gtest/gtest.h>

#include <string>

#include "app/base/user_folders.h"
#include "tests/support/process/environment_variable.h"

namespace {

using tests::EnvironmentVariable;

TEST(UserFolders, FollowTheEnvironment)
{
    {
        const EnvironmentVariable cache("XDG_CACHE_HOME", "/c"), settings("XDG_CONFIG_HOME", "/s");
        const EnvironmentVariable home("HOME", "/h");
        EXPECT_EQ(app::userCacheFolder(), "/c/rekindle");
        EXPECT_EQ(app::userSettingsFolder(), "/s/rekindle");
    }
    for (const char* notAbsolute : {static_cast<const char*>(nullptr), "", "c", "./c"}) {
        const EnvironmentVariable cache("XDG_CACHE_HOME", notAbsolute);
        const EnvironmentVariable settings("XDG_CONFIG_HOME", notAbsolute), home("HOME", "/h");
        EXPECT_EQ(app::userCacheFolder(), "/h/.cache/rekindle");
        EXPECT_EQ(app::userSettingsFolder(), "/h/.config/rekindle");
    }
    for (const char* nowhere : {static_cast<const char*>(nullptr), "", "h"}) {
        const EnvironmentVariable cache("XDG_CACHE_HOME", nullptr), home("HOME", nowhere);
        EXPECT_EQ(app::userCacheFolder(), "");
    }
}

}  // namespace

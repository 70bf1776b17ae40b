// Where things of the user are kept follows the XDG base directory specification (N25): relative
// names are to be ignored, and without a home there is no place.
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>

#include "app/base/user_folders.h"

namespace {

/// An environment variable set (or, null, unset) for the life of the object.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name)
    {
        if (const char* before = std::getenv(name)) before_ = before;
        set(value);
    }
    ~Variable() { set(before_ ? before_->c_str() : nullptr); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    void set(const char* value) { value != nullptr ? setenv(name_, value, 1) : unsetenv(name_); }

    const char* name_;
    std::optional<std::string> before_;
};

TEST(UserFolders, FollowTheEnvironment)
{
    {
        const Variable cache("XDG_CACHE_HOME", "/c"), settings("XDG_CONFIG_HOME", "/s");
        const Variable home("HOME", "/h");
        EXPECT_EQ(app::userCacheFolder(), "/c/rekindle");
        EXPECT_EQ(app::userSettingsFolder(), "/s/rekindle");
    }
    for (const char* notAbsolute : {static_cast<const char*>(nullptr), "", "c", "./c"}) {
        const Variable cache("XDG_CACHE_HOME", notAbsolute);
        const Variable settings("XDG_CONFIG_HOME", notAbsolute), home("HOME", "/h");
        EXPECT_EQ(app::userCacheFolder(), "/h/.cache/rekindle");
        EXPECT_EQ(app::userSettingsFolder(), "/h/.config/rekindle");
    }
    for (const char* nowhere : {static_cast<const char*>(nullptr), "", "h"}) {
        const Variable cache("XDG_CACHE_HOME", nullptr), home("HOME", nowhere);
        EXPECT_EQ(app::userCacheFolder(), "");
    }
}

}  // namespace

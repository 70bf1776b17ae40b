// Keeps the settings of a session in their file while it runs: what has changed is written within
// seconds, on a thread of its own, so that a crash or another viewer loses none of it.
#pragma once

#include <filesystem>
#include <memory>

#include "app/session/settings.h"
#include "core/base/worker.h"

namespace app {

class SettingsKeeper {
public:
    /// `known`: what the file held when it was read.
    SettingsKeeper(std::filesystem::path file, Settings known);

    /// Whether it is time to look for changes; `now` in seconds, at most every few of them.
    bool isDue(double now);

    /// Writes what has changed, in the background. A failure is not told here: it is tried again
    /// with the next change, and in finish().
    void offer(const Settings& now);

    /// Writes what has changed, at once. Throws core::Error.
    void finish(const Settings& now);

private:
    std::filesystem::path file_;
    std::shared_ptr<Settings> written_;  // the job's while one runs
    Settings offered_;
    double next_ = 0;
    core::Worker worker_;  // last: ends before what its job uses
};

}  // namespace app

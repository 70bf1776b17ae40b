// See settings_keeper.h.
#include "app/session/settings_keeper.h"

#include <utility>

namespace app {

namespace {

constexpr double kEvery = 3;  // seconds

}  // namespace

SettingsKeeper::SettingsKeeper(std::filesystem::path file, Settings known)
    : file_(std::move(file)), written_(std::make_shared<Settings>(known)),
      offered_(std::move(known)), worker_("settings", 5)
{}

bool SettingsKeeper::isDue(double now)
{
    if (now < next_ || worker_.status().active()) return false;
    next_ = now + kEvery;
    return true;
}

void SettingsKeeper::offer(const Settings& now)
{
    if (now == offered_) return;
    offered_ = now;
    worker_.start("settings", [file = file_, written = written_, now](core::JobContext&) {
        writeChanges(file, *written, now);
        *written = now;
    });
}

void SettingsKeeper::finish(const Settings& now)
{
    worker_.wait();
    writeChanges(file_, *written_, now);
}

}  // namespace app

// What a Session works on and can cancel, each by itself. See session.h.
#include <algorithm>
#include <functional>
#include <utility>

#include "app/session/session.h"

namespace app {

/// Tells the runs of a work apart; 0: it does not run.
uint64_t Session::runOf(Work work) const
{
    const auto jobOf = [](const core::JobStatus& job) {
        return job.active() && job.name != kPoseJob ? job.generation : 0;
    };
    switch (work) {
    case Work::load:
        return jobOf(loader_.status());
    case Work::background:
        return jobOf(core_.status());
    case Work::equalTime:
        return equalTime_.running();
    case Work::path:
        return track.playing();
    default:
        return player.playing;
    }
}

void Session::noteWorks()
{
    for (size_t i = 0; i < kWorks; ++i) {
        const uint64_t run = runOf(static_cast<Work>(i));
        if (run != 0 && run != seenRun_[i]) begun_[i] = ++beginnings_;
        seenRun_[i] = run;
    }
}

std::vector<Work> Session::works() const
{
    std::vector<std::pair<uint64_t, Work>> running;
    for (size_t i = 0; i < kWorks; ++i) {
        const auto work = static_cast<Work>(i);
        const uint64_t run = runOf(work);
        // What noteWorks() has not seen yet has begun after all that it has.
        if (run != 0) running.emplace_back(run == seenRun_[i] ? begun_[i] : beginnings_ + 1, work);
    }
    std::ranges::sort(running, std::greater());
    std::vector<Work> works;
    for (const auto& [begun, work] : running) works.push_back(work);
    return works;
}

void Session::cancel()
{
    for (const Work work : works()) cancel(work);
}

void Session::cancel(Work work)
{
    if (runOf(work) == 0) return;
    switch (work) {
    case Work::load:
        return loader_.cancel();  // tellEnds() says so
    case Work::background:
        return core_.cancel();
    case Work::equalTime:
        equalTime_.cancel();
        return notices.tell(Severity::news, "equal time: cancelled");
    case Work::path:
        return track.stop();
    default:
        player.playing = false;
    }
}

}  // namespace app

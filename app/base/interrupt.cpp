// A thread that waits for signals: a stop_source must not be touched from a signal handler. See
// interrupt.h.
#include "app/base/interrupt.h"

#include <cstdio>
#include <cstdlib>

#include <pthread.h>

#include "core/base/check.h"

namespace app {

Interrupt::Interrupt()
{
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    struct sigaction hangup {};  // nohup has it ignored
    if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN)
        sigaddset(&signals_, SIGHUP);
    CHECK(pthread_sigmask(SIG_BLOCK, &signals_, &previous_) == 0);
    thread_ = std::thread([this] { wait(); });
}

Interrupt::~Interrupt()
{
    ending_ = true;
    pthread_kill(thread_.native_handle(), SIGTERM);  // wakes sigwait of that thread alone
    thread_.join();
    pthread_sigmask(SIG_SETMASK, &previous_, nullptr);
}

void Interrupt::wait()
{
    while (true) {
        int signal = 0;
        if (sigwait(&signals_, &signal) != 0) continue;
        if (ending_) return;
        if (source_.stop_requested() || !keep_) {
            std::fputs(keep_ ? "interrupted again: this picture is not saved\n"
                             : "interrupted before anything was rendered: nothing saved\n",
                       stderr);
            std::_Exit(static_cast<int>(core::ExitCode::interrupted));
        }
        source_.request_stop();
    }
}

}  // namespace app

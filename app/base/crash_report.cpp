// Only what may be called from a signal handler. See crash_report.h.
#include "app/base/crash_report.h"

#include <array>
#include <csignal>
#include <cstddef>
#include <cstring>

#include <execinfo.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "app/base/program_version.h"

namespace app {

namespace {

constexpr int kMostCalls = 48;
constexpr size_t kStackBytes = 64 << 10;  // for the handler, where the main thread's is used up
constexpr unsigned kMostSeconds = 10;

struct Crash {
    int signal;
    const char* name;
};
constexpr std::array kCrashes{Crash{SIGSEGV, "SIGSEGV (a wrong address)"},
                              Crash{SIGBUS, "SIGBUS (memory or a file that is gone)"},
                              Crash{SIGILL, "SIGILL (an instruction that this processor lacks)"},
                              Crash{SIGFPE, "SIGFPE (a whole number divided by zero)"},
                              Crash{SIGABRT, "SIGABRT (the program gave up)"}};

void say(const char* text)
{
    if (write(STDERR_FILENO, text, std::strlen(text)) < 0) return;  // nobody is left to tell
}

void report(int signal)
{
    const char* name = "a signal";
    for (const Crash& crash : kCrashes)
        if (crash.signal == signal) name = crash.name;
    // A lock that whoever crashed holds must not turn a crash into a hang.
    std::signal(SIGALRM, SIG_DFL);
    alarm(kMostSeconds);
    std::array<char, 16> thread{};
    prctl(PR_GET_NAME, thread.data());
    for (const char* text :
         {"rekindle: error: crashed by ", name, " in thread \"",
          static_cast<const char*>(thread.data()), "\", version ", kVersion, " (", kCommit,
          "); this is a fault of the program or a driver, to be "
          "reported with these lines:\n"})
        say(text);
    std::array<void*, kMostCalls> calls;
    backtrace_symbols_fd(calls.data(), backtrace(calls.data(), kMostCalls), STDERR_FILENO);
    raise(signal);  // its handler is the system's again, and begins when this one is left
}

}  // namespace

void reportCrashes()
{
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    // The first call loads a library, which a handler must not.
    std::array<void*, 1> none;
    backtrace(none.data(), 1);
    static std::array<std::byte, kStackBytes> stack;
    stack_t own{};
    own.ss_sp = stack.data();
    own.ss_size = stack.size();
    sigaltstack(&own, nullptr);
    struct sigaction action {};
    action.sa_handler = report;
    action.sa_flags = static_cast<int>(SA_RESETHAND | SA_ONSTACK);
    for (const Crash& crash : kCrashes) sigaction(crash.signal, &action, nullptr);
#endif
}

}  // namespace app

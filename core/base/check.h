// Errors. CHECK is for our own mistakes and aborts; core::Error is for the user's and the system's
// and is caught in main and by the viewer's commands only (which then keep the state they had).
#pragma once

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace core {

/// The program's exit codes; docs/command-line.md explains them.
enum class ExitCode : int {
    done = 0,
    failure = 1,
    commandLine = 2,
    badInput = 3,
    noDevice = 4,
    deviceLost = 5,
    targetNotReached = 6,
    interrupted = 130,
};

/// A failure that a person can act on: `message` names the file or place, what was expected and
/// what to do.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& message, ExitCode code = ExitCode::badInput)
        : std::runtime_error(message), code_(code)
    {}
    ExitCode code() const { return code_; }

private:
    ExitCode code_;
};

[[noreturn]] inline void checkFailed(const char* file, int line, const char* expression)
{
    std::fprintf(stderr, "%s:%d: internal error: %s does not hold\n", file, line, expression);
    std::abort();
}

}  // namespace core

/// Always on: the program is wrong if this fails.
#define CHECK(expression)                                                                          \
    ((expression) ? (void)0 : ::core::checkFailed(__FILE__, __LINE__, #expression))

#ifdef NDEBUG
#define DCHECK(expression) ((void)0)
#else
#define DCHECK(expression) CHECK(expression)
#endif

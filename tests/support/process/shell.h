// A command line of the shell, what it printed and how it ended.
#pragma once

#include <cstdio>
#include <string>

#include <sys/wait.h>

namespace tests {

struct ShellResult {
    int code = -1;  // -1: it could not be started, or was killed
    std::string output;
};

/// Runs `command` with stdout and stderr together.
inline ShellResult shell(const std::string& command)
{
    ShellResult result;
    std::FILE* pipe = popen(("(" + command + ") 2>&1").c_str(), "r");
    if (!pipe) return result;
    char buffer[4096];
    for (size_t n; (n = std::fread(buffer, 1, sizeof buffer, pipe)) > 0;)
        result.output.append(buffer, n);
    const int status = pclose(pipe);
    if (WIFEXITED(status)) result.code = WEXITSTATUS(status);
    return result;
}

/// One argument of such a line, whatever is in it.
inline std::string quoted(const std::string& argument)
{
    std::string text = "'";
    for (const char c : argument) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
}

}  // namespace tests

// What the machine has, asked before much of it is taken: a system that promises more than there is
// ends programs without a word.
#pragma once

#include <string>

namespace core {

/// Bytes of the machine's memory.
double machineMemory();

/// While it lives the machine counts as having no more bytes than that: for tests of what is asked.
class MemoryLimit {
public:
    explicit MemoryLimit(double bytes);
    ~MemoryLimit();
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;
};

/// Throws an Error (commandLine) when `bytes` are more than the machine has: "`what` needs about
/// ... — `remedy`".
void requireMemory(double bytes, const std::string& what, const std::string& remedy);

}  // namespace core

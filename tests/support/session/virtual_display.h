// An X server of our own without a screen (Xvfb), so that tests can open windows, and see what is
// on them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include <sys/types.h>

namespace tests {

/// Sets DISPLAY while it lives. There is no window manager, and no window has the focus.
class VirtualDisplay {
public:
    VirtualDisplay();
    ~VirtualDisplay();
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;

    static bool installed();

    /// Red, green and blue of a point of the screen, from the server's own memory.
    std::array<uint8_t, 3> pixel(uint32_t x, uint32_t y) const;

    /// Ends the server at once, as a crash would.
    void kill();

private:
    pid_t process_ = -1;
    std::filesystem::path folder_;
    std::string before_;
    bool hadDisplay_ = false;
};

}  // namespace tests

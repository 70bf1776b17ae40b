// Xvfb picks a free display itself (-displayfd) and keeps its screen in a file (-fbdir) of the XWD
// format.
#include "tests/support/session/virtual_display.h"

#include <array>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <poll.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace tests {

namespace {

const char* kServer = "/usr/bin/Xvfb";

uint32_t readBigEndian(const char* p)
{
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(p[i]);
    return value;
}

/// The number that the server writes once it can be reached; it has 20 seconds.
std::string readLine(int file)
{
    std::string text;
    char c = 0;
    pollfd waiting{file, POLLIN, 0};
    while (poll(&waiting, 1, 20000) > 0 && ::read(file, &c, 1) == 1 && c != '\n') text += c;
    return text;
}

}  // namespace

bool VirtualDisplay::installed()
{
    return access(kServer, X_OK) == 0;
}

VirtualDisplay::VirtualDisplay()
{
    std::string pattern =
        (std::filesystem::temp_directory_path() / "rekindle-display-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = pattern;
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
    process_ = fork();
    if (process_ == 0) {
        close(ends[0]);
        const int nowhere = open("/dev/null", O_RDWR);
        dup2(nowhere, 1);
        dup2(nowhere, 2);
        const std::string number = std::to_string(ends[1]);
        execl(kServer, kServer, "-displayfd", number.c_str(), "-screen", "0", "1600x1000x24",
              "-nolisten", "tcp", "-noreset", "-fbdir", folder_.c_str(),
              static_cast<char*>(nullptr));
        _exit(127);
    }
    close(ends[1]);
    const std::string number = readLine(ends[0]);
    close(ends[0]);
    if (number.empty()) {
        kill();
        throw std::runtime_error("Xvfb did not start");
    }
    const char* before = getenv("DISPLAY");
    hadDisplay_ = before != nullptr;
    if (hadDisplay_) before_ = before;
    setenv("DISPLAY", (":" + number).c_str(), 1);
}

VirtualDisplay::~VirtualDisplay()
{
    kill();
    if (hadDisplay_) {
        setenv("DISPLAY", before_.c_str(), 1);
    } else {
        unsetenv("DISPLAY");
    }
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
}

void VirtualDisplay::kill()
{
    if (process_ <= 0) return;
    ::kill(process_, SIGTERM);  // it removes its own locks and asks nothing of us
    waitpid(process_, nullptr, 0);
    process_ = -1;
}

std::array<uint8_t, 3> VirtualDisplay::pixel(uint32_t x, uint32_t y) const
{
    std::ifstream file(folder_ / "Xvfb_screen0", std::ios::binary);
    std::vector<char> bytes((std::istreambuf_iterator<char>(file)),
                            std::istreambuf_iterator<char>());
    // XWDFileHeader, 25 words: size of the header, ..., 12 bytes per line, ..., 19 colours in the
    // table of 12 bytes each.
    if (bytes.size() < 100) throw std::runtime_error("the server's screen cannot be read");
    const size_t line = readBigEndian(&bytes[48]);
    const size_t start = readBigEndian(&bytes[0]) + size_t(readBigEndian(&bytes[76])) * 12 +
                         y * line + size_t(x) * 4;
    const auto at = [&](size_t i) { return static_cast<uint8_t>(bytes.at(start + i)); };
    return {at(2), at(1), at(0)};
}

}  // namespace tests

// The window's loop: events in, session and panel once, one frame out. Draws only when something
// can have changed.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "app/base/interrupt.h"
#include "app/session/session.h"
#include "app/view/gui.h"
#include "app/view/picture_view.h"
#include "app/view/script.h"
#include "app/view/ui/ui.h"
#include "app/view/window.h"

namespace app {

class FrameLoop {
public:
    /// Opens the window. Throws core::Error when it cannot be.
    explicit FrameLoop(const ViewOptions& options);

    /// Until the window is closed or the script has ended. Returns the exit code.
    int run();

private:
    using Clock = std::chrono::steady_clock;

    void tick();
    bool waitForWork();
    void nameWindow();
    bool somethingChanged();
    void draw(double seconds);
    void layOutWindow();
    bool isDue(const DisplayInputs& inputs);
    void present(const DisplayInputs& inputs);
    void measure(double seconds);
    void takeDrops();
    void obey();
    void leave();
    void endSaves();
    void writeScreenshot();
    void saveUnasked();
    [[noreturn]] void endWithoutDisplay();
    double secondsNow() const;

    ViewOptions options_;
    std::optional<Script> script_;  // read before a window opens
    Interrupt interrupt_;           // before anything that starts threads
    Window window_;
    std::unique_ptr<Gui> gui_;
    std::unique_ptr<Session> session_;
    std::unique_ptr<Ui> ui_;
    PictureView pictureView_;
    std::vector<gpu::DeviceInfo> devices_ = gpu::listDevices();
    AppRequests requests_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point lastTick_ = start_, lastDraw_ = start_;
    std::vector<float> frameTimes_;
    std::shared_ptr<const Picture> drawn_;
    std::filesystem::path named_;  // the scene in the window's title
    uint64_t drawnNotices_ = 0, frames_ = 0;
    // Frames still to be laid out though nothing happens: what ImGui fades or lays out late
    int more_ = 3;
    bool exposed_ = true;  // what the window shows is lost
    double noticeAt_ = -1e9, drawSeconds_ = 0;
    WindowLayout layout_;
    glm::uvec2 areaCorner_{0}, area_{0};  // of the picture, pixels
    uint64_t shakyUntil_ = 0;  // the frame until which another loss of the device ends it
    bool quit_ = false;
    int exitCode_ = 0;

    struct Input {
        double at = 0;
        uint64_t frame = 0, generation = 0;
    };
    std::optional<Input> input_;  // the hand's last motion that no picture has answered yet
    double inputSeconds_ = 0;
};

}  // namespace app

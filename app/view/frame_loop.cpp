// The loop. See frame_loop.h.
#include "app/view/frame_loop.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <thread>
#include <utility>

#include <imgui.h>
#include <nlohmann/json.hpp>

#include "app/base/user_folders.h"
#include "app/files/scene_path.h"
#include "app/files/stats.h"
#include "app/session/losses.h"
#include "app/view/input.h"
#include "core/base/check.h"
#include "core/base/text.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr double kBusyDraw = 0.1;      // seconds between frames when only a progress bar moves
constexpr double kIdleTick = 0.25;     // seconds that an idle window sleeps
constexpr double kNoticeSeconds = 10;  // for which a message may fade
constexpr size_t kKeptTimes = 240;
constexpr uint64_t kSteadyFrames = 100;  // that a new device has to show before it may be lost, too

/// Where the window and the renderer keep what is dear to make.
fs::path cacheFolder(const ViewOptions& o)
{
    return o.noCache ? fs::path() : userCacheFolder();
}

SessionOptions sessionOptions(const ViewOptions& o)
{
    SessionOptions s;
    s.scene = o.scene;
    s.camera = o.camera;
    s.path = o.path;
    s.render.device = o.device;
    s.render.deviceIndex = o.deviceIndex;
    s.render.method = o.params;
    s.methodGiven = o.paramsGiven;
    s.validation = o.validation;
    s.uiScale = o.uiScale;
    s.builtIn = true;
    s.cacheFolder = cacheFolder(o);
    s.factory = viewRenderers(cacheFolder(o));
    s.onPicture = &Window::wake;
    if (!o.noSettings) s.settings = settingsFile();
    return s;
}

glm::uvec2 windowSize(const ViewOptions& o)
{
    if (o.size) return *o.size;
    return o.noSettings ? Settings().windowSize : keptWindowSize(settingsFile());
}

}  // namespace

FrameLoop::FrameLoop(const ViewOptions& options)
    : options_(options),
      script_(options.script.empty() ? std::nullopt : std::optional<Script>(options.script)),
      window_("Rekindle", windowSize(options)),
      gui_(std::make_unique<Gui>(window_, GuiOptions{options.deviceIndex, options.validation,
                                                     options.uiScale, cacheFolder(options)})),
      session_(std::make_unique<Session>(sessionOptions(options))), ui_(std::make_unique<Ui>())
{
    interrupt_.keepResult(true);  // the settings
    if (!options.replay.empty()) session_->replay(options.replay);
}

double FrameLoop::secondsNow() const
{
    return std::chrono::duration<double>(Clock::now() - start_).count();
}

int FrameLoop::run()
{
    try {
        while (!quit_) tick();
    } catch (...) {
        if (window_.lost()) endWithoutDisplay();
        saveUnasked();
        session_.reset();  // waits for the files, whatever becomes of the window
        throw;
    }
    if (window_.lost()) endWithoutDisplay();
    if (exitCode_ == static_cast<int>(core::ExitCode::interrupted)) saveUnasked();
    if (script_) {
        std::cout << jsonLines(script_->report());
        if (script_->failed() && exitCode_ == 0)
            exitCode_ = static_cast<int>(core::ExitCode::failure);
    }
    if (const glm::uvec2 size = window_.size(); size.x > 0 && size.y > 0 && !options_.size)
        session_->settings.windowSize = glm::max(size, glm::uvec2(320, 200));
    ui_->keepPlaces(*session_);
    session_.reset();
    return exitCode_;
}

/// Where nobody can be asked, all that a question would name goes to new files.
void FrameLoop::saveUnasked()
{
    try {
        saveLosses(*session_, lossesOf(*session_));
    } catch (const std::exception& error) {
        session_->notices.tell(Severity::error, error.what());
    }
}

/// Whatever is left of the window and its device hangs on a connection that is gone: taking it down
/// in order may crash inside the display's library. What must not be lost is kept first.
void FrameLoop::endWithoutDisplay()
{
    saveUnasked();
    session_.reset();
    std::cerr << "rekindle: error: the connection to the display is lost\n";
    std::cout.flush();
    std::_Exit(static_cast<int>(core::ExitCode::failure));
}

void FrameLoop::tick()
{
    const bool happened = waitForWork();
    if (interrupt_.token().stop_requested()) {
        quit_ = true;
        exitCode_ = static_cast<int>(core::ExitCode::interrupted);
        return;
    }
    if (window_.lost()) {
        quit_ = true;
        return;
    }
    takeDrops();
    if (happened) more_ = 3;
    if (window_.takeExposed()) exposed_ = true;
    const double seconds = std::chrono::duration<double>(Clock::now() - lastTick_).count();
    lastTick_ = Clock::now();
    if (script_ && script_->step(*session_, requests_, window_, secondsNow())) more_ = 2;
    if (somethingChanged() || more_ > 0) {
        more_ = std::max(more_ - 1, 0);
        draw(seconds);
    } else {
        session_->update(seconds, area_);
    }
    nameWindow();
    obey();
}

/// The window is named after its scene.
void FrameLoop::nameWindow()
{
    const Document* document = session_->document();
    const fs::path file = document != nullptr ? document->file : fs::path();
    if (file == named_) return;
    named_ = file;
    window_.setTitle(core::printable(file.filename().string()) + " - Rekindle");
}

/// Sleeps until the next frame is due, or a picture that may be shown at once is there; an idle
/// window until an event. True when there was one.
bool FrameLoop::waitForWork()
{
    const std::chrono::duration<double> limit(
        1.0 / double(std::max(session_->settings.view.frameLimit, 1.0f)));
    const bool idle = !script_ && !session_->busy() && more_ == 0;
    bool happened = false;
    // Events of a hand come faster than frames are wanted: what is left is waited for again.
    for (bool first = true; first || Clock::now() - lastTick_ < limit; first = false) {
        const Clock::time_point before = Clock::now();
        const double due = std::chrono::duration<double>(lastTick_ + limit - before).count();
        // Even a late frame waits for a moment: only a wait tells whether there was an event.
        const double wait = idle && first ? kIdleTick : std::max(due, 0.001);
        window_.poll(wait);
        if (session_->hasNews() && Clock::now() - lastDraw_ >= limit) break;
        happened |= std::chrono::duration<double>(Clock::now() - before).count() < 0.9 * wait;
    }
    return happened;
}

bool FrameLoop::somethingChanged()
{
    const uint64_t notices = session_->notices.count();
    if (notices != drawnNotices_) noticeAt_ = secondsNow();
    drawnNotices_ = notices;
    const double sinceDraw = std::chrono::duration<double>(Clock::now() - lastDraw_).count();
    const bool fading = secondsNow() - noticeAt_ < kNoticeSeconds;
    if (session_->isMoving() || session_->track.playing()) return true;
    // A device that is slow to draw shall render: drawing gets a quarter of the time.
    if (session_->hasNews() && sinceDraw > 3 * drawSeconds_) return true;
    if (session_->busy()) return sinceDraw > std::max(kBusyDraw, 3 * drawSeconds_);
    return fading && sinceDraw > kBusyDraw;
}

/// The mouse and the panel count in units of the display, the picture in pixels.
void FrameLoop::layOutWindow()
{
    const ImGuiIO& io = ImGui::GetIO();
    layout_ = layOut({io.DisplaySize.x, io.DisplaySize.y}, ImGui::GetFontSize(),
                     session_->settings.panels);
    const glm::vec2 scale(io.DisplayFramebufferScale.x, io.DisplayFramebufferScale.y);
    areaCorner_ = glm::uvec2(glm::round(layout_.picture.corner * scale));
    area_ = glm::uvec2(glm::round(layout_.picture.end() * scale)) - areaCorner_;
}

void FrameLoop::draw(double seconds)
{
    const Clock::time_point begin = Clock::now();
    if (!gui_->begin()) {
        // Minimised: the picture goes on at the size that it has.
        session_->update(seconds, area_);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return;
    }
    layOutWindow();
    const uint64_t before = session_->generation();
    const bool hand = handleInput(*session_, requests_, layout_.picture, seconds);
    if (requests_.foldPanel) {
        session_->settings.panels.fold =
            layout_.panel.empty() ? PanelFold::open : PanelFold::folded;
        requests_.foldPanel = false;
    }
    layOutWindow();  // what was pressed may have changed it
    session_->update(seconds, area_);
    if (hand && session_->generation() != before && !input_)
        input_ = Input{secondsNow(), frames_ + 1, session_->generation()};
    DisplayInputs inputs = pictureView_.inputs(*session_);
    inputs.corner = areaCorner_;
    inputs.size = area_;
    UiFrame frame;
    frame.layout = layout_;
    frame.devices = devices_;
    frame.frameTimes = frameTimes_;
    frame.inputSeconds = inputSeconds_;
    const GuiStats stats = gui_->stats();
    frame.presentBytes = stats.deviceBytes;
    frame.presentDevice = gui_->deviceName();
    if (options_.validation) frame.validationMessages = gpu::validationMessages();
    frame.scale = pictureView_.scale();
    frame.problem = pictureView_.problem();
    ui_->draw(*session_, requests_, frame);
    // Not while the slider is held: it would grow and move away under the cursor.
    if (!ui_->isHeld()) gui_->setUiScale(session_->settings.panels.uiScale);
    if (!isDue(inputs)) return;
    exposed_ = false;
    present(inputs);
    drawn_ = session_->picture();
    lastDraw_ = Clock::now();
    ++frames_;
    drawSeconds_ = std::chrono::duration<double>(lastDraw_ - begin).count();
    measure(drawSeconds_);
}

/// Whether a frame that is laid out goes to the window. Pictures of a camera that moves come less
/// often than motions, and a software device that draws the same again takes the time for it from
/// them.
bool FrameLoop::isDue(const DisplayInputs& inputs)
{
    const GuiChanges changes = gui_->changes(inputs);
    if (exposed_ || changes.picture) return true;
    if (!changes.panels) return false;
    const ImGuiIO& io = ImGui::GetIO();
    if (!session_->isMoving() || io.WantCaptureMouse || io.WantCaptureKeyboard) return true;
    // The hand is at the picture: numbers beside it may wait where drawing is slow.
    const double since = std::chrono::duration<double>(Clock::now() - lastDraw_).count();
    if (since > kBusyDraw + 3 * drawSeconds_) return true;
    more_ = std::max(more_, 1);
    return false;
}

void FrameLoop::present(const DisplayInputs& inputs)
{
    try {
        gui_->end(inputs);
    } catch (const core::Error& error) {
        if (error.code() != core::ExitCode::deviceLost || frames_ < shakyUntil_) throw;
        // The window's own device is gone: a new one, unless that does not last either. The
        // renderer's is another and goes on.
        shakyUntil_ = frames_ + kSteadyFrames;
        session_->notices.tell(Severity::error,
                               std::string(error.what()) + " — the window was set up anew");
        gui_.reset();
        gui_ = std::make_unique<Gui>(window_, GuiOptions{options_.deviceIndex, options_.validation,
                                                         session_->settings.panels.uiScale,
                                                         cacheFolder(options_)});
    }
}

void FrameLoop::measure(double seconds)
{
    if (frameTimes_.size() >= kKeptTimes) frameTimes_.erase(frameTimes_.begin());
    frameTimes_.push_back(static_cast<float>(seconds));
    const bool core = session_->coreThread().active() || session_->loading().active();
    if (script_) script_->frame(seconds, core);
    if (!input_ || !drawn_ || drawn_->generation < input_->generation) return;
    inputSeconds_ = secondsNow() - input_->at;
    if (script_) script_->answered(inputSeconds_, frames_ - input_->frame);
    input_.reset();
}

void FrameLoop::takeDrops()
{
    for (const fs::path& file : window_.takeDrops()) {
        const char* const action = mayBeScene(file)              ? "load"
                                   : hasExtension(file, ".exr")  ? "load-reference"
                                   : hasExtension(file, ".png")  ? "replay"
                                   : hasExtension(file, ".json") ? "load-path"
                                                                 : nullptr;
        if (action != nullptr)
            runByHand(action, *session_, requests_, {{"file", file.string()}});
        else
            session_->notices.tell(Severity::error,
                                   file.string() +
                                       ": drop a scene (.gltf, .glb), a reference (.exr), a "
                                       "picture to replay (.png) or a camera path (.json)");
        more_ = 3;
    }
}

/// What was asked of the window itself.
void FrameLoop::obey()
{
    if (requests_.toClipboard) window_.setClipboard(*requests_.toClipboard);
    if (requests_.pasteCamera) session_->pasteCamera(window_.clipboard());
    if (requests_.resize) window_.resize(glm::max(*requests_.resize, glm::uvec2(1)));
    if (requests_.screenshot) writeScreenshot();
    requests_.toClipboard.reset();
    requests_.pasteCamera = false;
    requests_.resize.reset();
    requests_.screenshot.reset();
    leave();
}

/// Every way of leaving but signals and the end of a script comes here.
void FrameLoop::leave()
{
    if (window_.closeRequested() && !window_.lost()) {
        window_.requestClose(false);
        requests_.leave = true;
    }
    if (std::exchange(requests_.leave, false)) {
        // Where the window could not be made large enough for the question, asking again answers
        // it.
        const bool unseen = requests_.askQuit && !hasRoomForText(layout_.window, layout_.letter);
        (lossesOf(*session_).empty() || unseen ? requests_.quit : requests_.askQuit) = true;
        more_ = 3;
    }
    if (!session_->saving()) endSaves();
    quit_ = quit_ || requests_.quit || window_.lost() || (script_ && script_->finished());
}

/// What waited for files to be written is done, unless one could not be: its message stands in the
/// window.
void FrameLoop::endSaves()
{
    const bool failed = session_->saveFailed();
    if (std::exchange(requests_.quitWhenSaved, false)) requests_.quit = !failed;
    const std::optional<Intent> intent = std::exchange(requests_.whenSaved, std::nullopt);
    if (intent && !failed) {
        doIntent(*intent, *session_, requests_);
        more_ = 3;
    }
}

void FrameLoop::writeScreenshot()
{
    const fs::path file = *requests_.screenshot;
    try {
        glm::uvec2 size;
        const std::vector<uint8_t> pixels =
            requests_.screenshotWithPanel ? gui_->readFrame(size) : gui_->readPicture(size);
        if (pixels.empty()) throw core::Error(file.string() + ": there is nothing on show yet");
        core::writePngBytes(file, size.x, size.y, 4, pixels, session_->pictureMetadata());
        session_->notices.tell(Severity::news, wholePath(file) + ": saved", file);
    } catch (const core::Error& error) {
        session_->notices.tell(Severity::error, error.what());
    }
}

}  // namespace app

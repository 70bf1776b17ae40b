// See flight_window.h.
#include "app/bench/flythrough/flight_window.h"

#include <cmath>
#include <thread>

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/image/display.h"

namespace app::flight {

namespace {

constexpr double kTick = 1.0 / 60;        // seconds between frames of the window
constexpr double kLandingTick = 0.002;    // and while the last picture is waited for, at any load
constexpr double kKeysPerSecond = 10;     // of a track; between them it is smooth
constexpr double kSlowest = 1.0 / 64;     // of the speed that was wished
constexpr double kLongestWait = 10 * 60;  // seconds for one picture

SessionOptions sessionOptions(const SceneOptions& scene, const Target& target)
{
    SessionOptions options;
    options.scene = scene;
    options.render.device = target.device;
    options.render.deviceIndex = target.deviceIndex;
    options.render.method = core::ReuseParams{};
    options.methodGiven = true;
    options.quiet = true;
    return options;
}

}  // namespace

WindowPilot::WindowPilot(const SceneOptions& scene, const Target& target, glm::uvec2 size,
                         std::stop_token stop)
    : size_(size), stop_(std::move(stop)), session_(sessionOptions(scene, target))
{
    wait([this] { return session_.document() != nullptr && !session_.loading().active(); });
}

bool WindowPilot::wait(const std::function<bool()>& done, bool lands)
{
    const core::Clock::time_point start = core::Clock::now();
    while (!done()) {
        if (stop_.stop_requested()) return false;
        const double pause = lands ? kLandingTick : kTick / clock_.share();
        std::this_thread::sleep_for(std::chrono::duration<double>(pause));
        const double seconds = clock_.tick();
        now_ += seconds;
        session_.settings.view.movingRate = static_cast<float>(clock_.share() / frameSeconds_);
        session_.update(seconds, size_);
        const core::JobStatus loading = session_.loading();
        if (loading.state == core::JobState::failed) throw core::Error(loading.error);
        const RenderThreadStatus rendering = session_.rendering();
        if (!rendering.error.empty()) throw core::Error(rendering.error);
        if (core::secondsSince(start) > kLongestWait)
            throw core::Error("the window's loop has shown nothing for ten minutes");
    }
    return true;
}

/// Kernels are compiled, and the first picture is there, before the clock runs.
bool WindowPilot::begin(const CameraTrack& track, const core::ReuseParams& params)
{
    if (session_.document() == nullptr) return false;  // stopped while it was loaded
    session_.chooseParams(params);
    session_.track = track;
    session_.track.loop = false;
    session_.track.seek(track.firstFrame());
    session_.navigation.set(track.at(track.firstFrame()),
                            static_cast<double>(session_.document()->world->radius));
    session_.restart();
    uint64_t ordered = 0;
    return wait([&] {
        if (ordered == 0) {  // the order is made by the first update
            ordered = session_.generation() + 1;
            return false;
        }
        return session_.picture() && session_.picture()->generation >= ordered;
    });
}

/// The camera stands where the flight ends; what is on its way still shows the views before. It
/// counts as moving until the picture is there, however long a machine under load takes. The
/// picture is taken before it gets a second sample, which would lie anywhere in its pixel.
bool WindowPilot::land(WindowLanding& landing)
{
    const core::Camera end = session_.navigation.camera();
    const auto there = [&] {
        session_.moved();
        return session_.picture()->camera == end;
    };
    if (!wait(there, true)) return false;
    const Picture& picture = *session_.picture();
    CHECK(picture.preview);
    landing.picture = core::stretched(picture.mean, size_);
    landing.size = sampledSize(picture);
    landing.guide = picture.sampledGuide ? picture.sampledGuide : picture.guide;
    landing.colours = displayColours(picture.mean, picture.guide.get(), size_);
    return true;
}

std::optional<WindowLanding> WindowPilot::fly(const CameraTrack& track,
                                              const core::ReuseParams& params, double frameSeconds)
{
    CHECK(track.keys().size() >= 2);
    frameSeconds_ = frameSeconds;
    if (!begin(track, params)) return {};
    WindowLanding landing;
    std::shared_ptr<const Picture> shown = session_.picture();
    double scales = 0;
    const core::Clock::time_point start = core::Clock::now();
    const double begun = now_;
    session_.track.play();
    const bool flown = wait([&] {
        if (session_.picture() != shown) {
            shown = session_.picture();
            scales += double(sampledSize(*shown).x) / size_.x;
            ++landing.pictures;
        }
        return !session_.track.playing();
    });
    // Pictures that are waited for from now on are not counted.
    landing.seconds = now_ - begun;
    landing.share = landing.seconds / core::secondsSince(start);
    landing.scale = scales / std::max(landing.pictures, 1u);
    if (!flown || !land(landing)) return {};
    return landing;
}

core::Image displayColours(const core::Image& picture, const core::Image* guide, glm::uvec2 size)
{
    shared::DisplaySettings s{};
    s.width = size.x;
    s.height = size.y;
    s.show = guide ? shared::kShowPreview : shared::kShowRadiance;
    s.exposure = ViewParams{}.exposure;
    s.tone = static_cast<uint32_t>(ViewParams{}.tone);
    const std::vector<uint8_t> bytes = core::displayImage(&picture, guide, s);
    core::Image colours(size.x, size.y, 3);
    for (size_t i = 0; i < size_t(size.x) * size.y; ++i)
        for (size_t c = 0; c < 3; ++c)
            colours.pixels[3 * i + c] = static_cast<float>(bytes[4 * i + c]) / 255;
    return colours;
}

CameraTrack lastSeconds(const Flight& flight, double speed, double seconds)
{
    CameraTrack track;
    track.framesPerSecond = kKeysPerSecond;
    const auto last = static_cast<uint32_t>(std::lround(seconds * kKeysPerSecond));
    for (uint32_t i = 0; i <= last; ++i)
        track.addAt(i, flight.before(speed / kKeysPerSecond, last - i));
    return track;
}

double speedThatFits(const Flight& flight, double wished, double seconds)
{
    const auto views = static_cast<uint32_t>(std::lround(seconds * kKeysPerSecond)) + 1;
    for (double speed = wished; speed >= kSlowest * wished; speed /= 2)
        if (flight.whyNot(speed / kKeysPerSecond, views).empty()) return speed;
    return 0;
}

}  // namespace app::flight

// See window_loop.h.
#include "app/bench/window/window_loop.h"

#include <chrono>
#include <cmath>
#include <thread>

#include "core/base/check.h"
#include "core/base/time.h"

namespace app {

namespace {

constexpr double kTick = 1.0 / 60;          // seconds between frames of the window
constexpr double kCloseTick = 0.002;        // and where no picture may be missed, at any load
constexpr double kLongestWait = 10 * 60;    // seconds for one picture
constexpr double kKeysPerSecond = 10;       // of a track; between them it is smooth
constexpr double kLeastOfSpeed = 1.0 / 64;  // of the one that was wished

SessionOptions sessionOptions(const SceneOptions& scene, const Target& target,
                              const core::AnyParams& params)
{
    SessionOptions options;
    options.scene = scene;
    options.render.device = target.device;
    options.render.deviceIndex = target.deviceIndex;
    options.render.method = params;
    options.methodGiven = true;
    options.quiet = true;
    return options;
}

}  // namespace

WindowLoop::WindowLoop(const SceneOptions& scene, const Target& target,
                       const core::AnyParams& params, glm::uvec2 size, std::stop_token stop)
    : size_(size), stop_(std::move(stop)), session_(sessionOptions(scene, target, params))
{
    wait([this] { return session_.document() != nullptr && !session_.loading().active(); });
}

bool WindowLoop::wait(const std::function<bool()>& done, bool closely)
{
    const core::Clock::time_point start = core::Clock::now();
    while (!done()) {
        if (stop_.stop_requested()) return false;
        const double pause = closely ? kCloseTick : kTick / clock_.share();
        std::this_thread::sleep_for(std::chrono::duration<double>(pause));
        const double seconds = clock_.tick();
        now_ += seconds;
        session_.settings.view.movingRate = static_cast<float>(clock_.share() / pictureSeconds_);
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

bool WindowLoop::begin(const CameraTrack& track, const core::AnyParams& params,
                       const std::function<bool(const Picture&)>& ready)
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
        const std::shared_ptr<const Picture> picture = session_.picture();
        return picture && picture->generation >= ordered && ready(*picture);
    });
}

namespace flight {

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
    for (double speed = wished; speed >= kLeastOfSpeed * wished; speed /= 2)
        if (flight.whyNot(speed / kKeysPerSecond, views).empty()) return speed;
    return 0;
}

}  // namespace flight

}  // namespace app

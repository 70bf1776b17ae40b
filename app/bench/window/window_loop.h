// The window's own loop for measurements: the real session and its render thread, by the clock.
// Only the drawing is left out. Where other work takes its share of the machine, the clock goes
// slower, and pictures may take longer.
#pragma once

#include <functional>
#include <stop_token>

#include "app/bench/flight.h"
#include "app/bench/window/slowed_clock.h"
#include "app/methods/methods.h"
#include "app/session/session.h"

namespace app {

class WindowLoop {
public:
    /// Loads the scene, for pictures of `size`. Throws core::Error.
    WindowLoop(const SceneOptions& scene, const Target& target, const core::AnyParams& params,
               glm::uvec2 size, std::stop_token stop);

    /// So many seconds of the clock are wanted between pictures of a moving camera.
    void wantPictures(double seconds) { pictureSeconds_ = seconds; }

    /// Goes on as a window does until `done`; false when a stop came first. `closely`: looks as
    /// often as it takes to see every picture. Throws core::Error.
    bool wait(const std::function<bool()>& done, bool closely = false);

    /// Begins anew at the track's first key, without the track's being played, and waits for a
    /// picture of it that is `ready`: kernels are compiled by then. False when a stop came first.
    /// Throws core::Error.
    bool begin(const CameraTrack& track, const core::AnyParams& params,
               const std::function<bool(const Picture&)>& ready);

    Session& session() { return session_; }
    double now() const { return now_; }  // of the clock, seconds

private:
    glm::uvec2 size_;
    std::stop_token stop_;
    Session session_;
    SlowedClock clock_;
    double now_ = 0;
    double pictureSeconds_ = 1;
};

namespace flight {

/// The last `seconds` of a flight, at `speed` (steps of the flight per second).
CameraTrack lastSeconds(const Flight& flight, double speed, double seconds);

/// The greatest speed up to `wished` at which a flight has room for so many seconds; 0: none.
double speedThatFits(const Flight& flight, double wished, double seconds);

}  // namespace flight

}  // namespace app

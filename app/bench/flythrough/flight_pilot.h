// One renderer of sample reuse that flies: frame after frame, each beginning with what the one
// before has left.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "app/bench/flight.h"
#include "app/methods/methods.h"
#include "core/methods/renderer.h"

namespace app::flight {

/// A flight and what it is flown with.
struct Plan {
    double step = 1;
    uint32_t frames = 1;   // the last one shows the flight's end
    uint32_t samples = 1;  // passes of each frame
    core::ReuseParams params;
};

struct Landing {
    core::Image picture;  // of the last frame, as all that follows
    double rays = 0, seconds = 0;
};

/// An animation that runs while one flies.
struct Play {
    double end = 0;  // instant at which flights end, in seconds
    double framesPerSecond = 24;
};

class Pilot {
public:
    explicit Pilot(const Target& target);

    /// The scene as it is where flights end; `play`: its animation runs until then, else it
    /// stands still.
    void setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress,
                  const std::optional<Play>& play = {});
    void setSize(glm::uvec2 size) { size_ = size; }
    core::Renderer& renderer() { return *renderer_; }

    /// "cpu seconds / cores" or "device time".
    const char* clock() const;

    /// Nothing when `stop` came first. Throws core::Error.
    std::optional<Landing> fly(const Flight& flight, const Plan& plan, std::stop_token stop);

private:
    std::shared_ptr<const core::World> worldBefore(uint32_t frames) const;

    std::unique_ptr<core::Renderer> renderer_;
    bool hostClock_ = true;
    std::shared_ptr<const core::World> world_;
    std::optional<Play> play_;
    glm::uvec2 size_{0};
};

}  // namespace app::flight

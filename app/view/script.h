// `view --script FILE`: a list of actions, waits, inputs and screenshots, so that a run of the
// viewer can be repeated. The format is described in script_steps.h; results go to stdout as JSON.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "app/session/actions.h"

namespace app {

class Window;

class Script {
public:
    /// Reads and checks the whole file. Throws core::Error with the place in it.
    explicit Script(const std::filesystem::path& file);

    /// Once per tick, before the session's update: runs steps until one has to wait. `seconds`
    /// since the program began. True when a frame should be drawn: something was done, or waits for
    /// frames.
    bool step(Session& session, AppRequests& app, Window& window, double seconds);
    bool finished() const;
    bool failed() const;  // a wait ran out, or a step could not be done

    /// Told by the loop about every frame.
    void frame(double frameSeconds, bool coreBusy);

    /// Told when a picture has answered an input: seconds and frames between them.
    void answered(double seconds, uint64_t frames);

    /// Steps with their times, frame times (median, p99, largest) while idle and while the core
    /// thread works, input to picture, failures.
    nlohmann::ordered_json report() const;

private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace app

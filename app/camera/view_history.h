// The views that one has rested at, so that one can go back to them. Plain data, no window.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "app/camera/navigation.h"

namespace app {

class ViewHistory {
public:
    /// Another scene: nothing of before can be gone back to.
    void clear() { *this = {}; }

    /// Once per update: a view that has stayed for a moment is remembered. `now` in seconds.
    void observe(const Viewpoint& present, double now);

    /// Remembers the present view at once: before it is left in one step.
    void settle(const Viewpoint& present);

    /// The view before the present one, or after it; nothing at the ends. The present view is
    /// remembered first, so that every step can be taken back.
    std::optional<Viewpoint> back(const Viewpoint& present);
    std::optional<Viewpoint> forward(const Viewpoint& present);

private:
    std::optional<Viewpoint> go(size_t to);

    std::deque<Viewpoint> views_;  // oldest first, at most 64
    size_t at_ = 0;                // the one that was settled at last
    std::optional<Viewpoint> candidate_;
    double since_ = 0;  // of the candidate
};

}  // namespace app

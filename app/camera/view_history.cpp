// See view_history.h. Going on from a view that was gone back to forgets those after it.
#include "app/camera/view_history.h"

namespace app {

namespace {

constexpr size_t kMostViews = 64;
constexpr double kRest = 0.5;  // seconds

/// What one turns about, and what the view is called, make no other view.
bool looksTheSame(const Viewpoint& a, const Viewpoint& b)
{
    core::Camera named = a.camera;
    named.name = b.camera.name;
    return named == b.camera;
}

}  // namespace

void ViewHistory::observe(const Viewpoint& present, double now)
{
    if (!candidate_ || !looksTheSame(*candidate_, present)) {
        candidate_ = present;
        since_ = now;
    } else if (now - since_ >= kRest) {
        settle(present);
    }
}

void ViewHistory::settle(const Viewpoint& present)
{
    if (!views_.empty() && looksTheSame(views_[at_], present)) {
        views_[at_] = present;
        return;
    }
    if (!views_.empty()) views_.resize(at_ + 1);
    views_.push_back(present);
    if (views_.size() > kMostViews) views_.pop_front();
    at_ = views_.size() - 1;
}

std::optional<Viewpoint> ViewHistory::go(size_t to)
{
    at_ = to;
    candidate_ = views_[at_];
    return views_[at_];
}

std::optional<Viewpoint> ViewHistory::back(const Viewpoint& present)
{
    settle(present);
    return at_ > 0 ? go(at_ - 1) : std::nullopt;
}

std::optional<Viewpoint> ViewHistory::forward(const Viewpoint& present)
{
    settle(present);
    return at_ + 1 < views_.size() ? go(at_ + 1) : std::nullopt;
}

}  // namespace app

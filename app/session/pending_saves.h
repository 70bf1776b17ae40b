// Pictures that were asked to be saved and wait for what a file should hold: a whole sample, its
// variance, first hits. Each is of the view that was on show when it was asked for.
#pragma once

#include <memory>
#include <vector>

#include "app/pictures/picture.h"
#include "app/session/session_jobs.h"

namespace app {

struct PendingSave {
    SaveItem item;       // its picture: the newest whole one of the view; null before the first
    RenderRequest view;  // scene, camera, size, parameters
    double until = 0;    // when a whole picture without variance will do
};

class PendingSaves {
public:
    bool empty() const { return waiting_.empty(); }
    void add(PendingSave save) { waiting_.push_back(std::move(save)); }

    /// A picture that has come, or null: counts where it is whole and of the view.
    void offer(const std::shared_ptr<const Picture>& picture);

    /// Those that have everything, or have waited long enough; they wait no longer.
    std::vector<SaveItem> takeReady(double now);

    /// Before another view, of the same scene, is rendered: those that have a picture, as it is.
    /// The others wait for a picture of `next`, at that instant of the scene.
    std::vector<SaveItem> leaveView(const RenderRequest& next, double at);

    /// Before the scene goes, or the program: all of them, also without a picture.
    std::vector<SaveItem> takeAll();

private:
    std::vector<PendingSave> waiting_;
};

/// Whether a picture is one of what the request asks for.
bool shows(const Picture& picture, const RenderRequest& view);

/// Whether what one request renders can be continued to what the other asks for.
bool sameView(const RenderRequest& a, const RenderRequest& b);

}  // namespace app

// See pending_saves.h.
#include "app/session/pending_saves.h"

#include <utility>

namespace app {

namespace {

/// Whether a picture is to be saved in place of another of the same view: not where it was begun
/// anew, as after the loss of a device.
bool isMore(const Picture& picture, const std::shared_ptr<const Picture>& than)
{
    return !than || picture.samples >= than->samples;
}

/// Takes out those of which `isDue` holds.
template <class IsDue>
std::vector<SaveItem> takeOut(std::vector<PendingSave>& waiting, IsDue&& isDue)
{
    std::vector<SaveItem> due;
    std::vector<PendingSave> rest;
    for (PendingSave& save : waiting) {
        if (isDue(save))
            due.push_back(std::move(save.item));
        else
            rest.push_back(std::move(save));
    }
    waiting = std::move(rest);
    return due;
}

}  // namespace

bool shows(const Picture& picture, const RenderRequest& view)
{
    return picture.world.lock() == view.world && picture.camera == view.camera &&
           picture.fullSize == view.size && picture.restarts == view.restarts &&
           sameRendering(picture.params, view.params);
}

bool sameView(const RenderRequest& a, const RenderRequest& b)
{
    return a.world == b.world && a.camera == b.camera && a.size == b.size &&
           a.restarts == b.restarts && sameRendering(a.params, b.params);
}

void PendingSaves::offer(const std::shared_ptr<const Picture>& picture)
{
    if (!picture || !isWhole(*picture)) return;
    for (PendingSave& save : waiting_)
        if (shows(*picture, save.view) && isMore(*picture, save.item.picture))
            save.item.picture = picture;
}

std::vector<SaveItem> PendingSaves::takeReady(double now)
{
    return takeOut(waiting_, [now](const PendingSave& save) {
        const std::shared_ptr<const Picture>& picture = save.item.picture;
        if (!picture) return false;
        return (picture->variance && picture->aovs) || now >= save.until;
    });
}

std::vector<SaveItem> PendingSaves::leaveView(const RenderRequest& next, double at)
{
    std::vector<SaveItem> due =
        takeOut(waiting_, [](const PendingSave& save) { return save.item.picture != nullptr; });
    for (PendingSave& save : waiting_) {
        save.view = next;
        save.item.scene.world = next.world;
        save.item.scene.time = at;
    }
    return due;
}

std::vector<SaveItem> PendingSaves::takeAll()
{
    return takeOut(waiting_, [](const PendingSave&) { return true; });
}

}  // namespace app

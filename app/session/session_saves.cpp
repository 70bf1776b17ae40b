// What a Session writes to files, on the thread that saves. See session.h.
#include <algorithm>
#include <utility>

#include "app/pictures/save_picture.h"
#include "app/session/pending_saves.h"
#include "app/session/session.h"
#include "app/session/session_jobs.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr double kSaveSeconds = 3;  // a save waits so long for a picture that carries its variance

}  // namespace

/// To the thread that saves, which finishes them even when the program ends.
void Session::handOver(std::vector<SaveItem> items)
{
    for (SaveItem& item : items) {
        if (picture_ && onePicture(*item.picture, *picture_))
            savedSeconds_ = std::max(savedSeconds_, item.picture->seconds);
        saved_.push_back(item.work.expired() ? item.picture : item.work);
        saves_->add(std::move(item));
        saver_.start("save", saves_->job());
    }
}

/// Before what they show is gone.
void Session::endSaves(const char* why)
{
    std::vector<SaveItem> items = pendingSaves_->takeAll();
    for (const SaveItem& item : items) {
        if (item.picture) continue;
        saveFailed_ = true;
        notices.tell(Severity::error, item.file.string() + ": not saved: " + why +
                                          " before its first sample was complete");
    }
    std::erase_if(items, [](const SaveItem& item) { return !item.picture; });
    handOver(std::move(items));
}

void Session::save(const fs::path& file)
{
    if (!document_ || !picture_) {
        notices.tell(Severity::error, file.string() + ": there is no picture to save yet");
        saveFailed_ = true;
        return;
    }
    saveFailed_ = false;
    pendingSaves_->add(
        {{file, nullptr, *document_, settings.view, {}}, ordered_, now_ + kSaveSeconds});
    pendingSaves_->offer(whole_);
}

void Session::saveSlot(size_t side, const fs::path& file)
{
    const Slot& slot = slots[side];
    if (!document_ || !slot.picture) return;
    ShownScene scene = *document_;
    scene.time = slot.time;
    handOver({{file, slot.picture, scene, settings.view, slot.picture}});
}

void Session::saveReference(const fs::path& file)
{
    if (!document_ || !reference_) return;
    auto picture = std::make_shared<Picture>();
    picture->world = referenceWorld_;
    picture->mean = reference_->mean;
    picture->variance = std::make_shared<core::Image>(reference_->variance);
    picture->camera = referenceCamera_;
    picture->fullSize = {reference_->mean.width, reference_->mean.height};
    picture->params = reference_->params;
    picture->samples = reference_->samples;
    picture->seconds = reference_->seconds;
    picture->finished = reference_->samples >= reference_->params.sppLimit;
    ShownScene scene = *document_;
    scene.time = referenceTime_;
    handOver({{file, std::move(picture), scene, settings.view, reference_}});
}

void Session::savePath(const fs::path& file)
{
    if (!document_) return;
    try {
        track.save(file, document_->world->placement);
        notices.tell(Severity::news, wholePath(file) + ": path saved", file);
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
        saveFailed_ = true;
    }
}

bool Session::isSaved(const std::shared_ptr<const void>& work) const
{
    return std::ranges::any_of(saved_, [&](const std::weak_ptr<const void>& kept) {
        return !kept.expired() && kept.lock() == work;
    });
}

bool Session::saving() const
{
    return !pendingSaves_->empty() || saver_.status().active() || saves_->hasTold();
}

bool Session::saveFailed() const
{
    return saveFailed_;
}

core::Metadata Session::pictureMetadata() const
{
    const std::optional<ShownScene> scene = shownScene();
    return scene ? viewMetadata(*picture_, *scene) : core::Metadata{};
}

double Session::unsavedSeconds() const
{
    // What has been left for another view or scene is gone whatever is saved now.
    const bool onShow = document_ && picture_ && !picture_->preview &&
                        ordered_.world == document_->world && shows(*picture_, ordered_);
    return onShow ? picture_->seconds - savedSeconds_ : 0;
}

}  // namespace app

// The session's reference, its two sides of the slider, and frames of a path. See session.h.
#include "app/session/session.h"
#include "app/session/session_jobs.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

bool Session::referenceFits(const RenderRequest& request) const
{
    return reference_ && referenceWorld_ == request.world && referenceCamera_ == request.camera &&
           reference_->mean.width == request.size.x && reference_->mean.height == request.size.y;
}

bool Session::referenceFits() const
{
    return referenceFits(ordered_);
}

void Session::startReference(uint64_t samples)
{
    if (!document_ || ordered_.size.x == 0) return;
    dropReference();
    referenceWorld_ = document_->world;
    referenceCamera_ = navigation.view();
    referenceGeneration_ = core_.start(
        "reference",
        referenceJob({document_->world, referenceCamera_, ordered_.size, render.method, samples},
                     referenceBox_));
}

void Session::takeReference()
{
    if (referenceGeneration_ == 0) return;
    if (std::shared_ptr<const Reference> newest = referenceBox_->get(referenceGeneration_))
        reference_ = std::move(newest);
}

void Session::loadReference(const fs::path& file)
{
    try {
        const core::ImageFile image = core::readExr(file);
        Reference reference;
        reference.mean = image.layer("");
        if (reference.mean.channels != 3)
            throw core::Error(file.string() + ": has no R, G, B to compare with");
        if (image.hasLayer("variance")) reference.variance = image.layer("variance");
        reference.origin = file.filename().string();
        if (ordered_.size.x > 0 &&
            (reference.mean.width != ordered_.size.x || reference.mean.height != ordered_.size.y))
            throw core::Error(file.string() + ": is " + std::to_string(reference.mean.width) + 'x' +
                              std::to_string(reference.mean.height) + ", the picture is " +
                              std::to_string(ordered_.size.x) + 'x' +
                              std::to_string(ordered_.size.y) +
                              " — give the window that size, or take another file");
        dropReference();
        reference_ = std::make_shared<const Reference>(std::move(reference));
        referenceWorld_ = ordered_.world;
        referenceCamera_ = navigation.view();
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
    }
}

void Session::dropReference()
{
    if (referenceGeneration_ != 0 && core_.status().generation == referenceGeneration_ &&
        core_.status().active())
        core_.cancel();
    referenceGeneration_ = 0;
    reference_.reset();
    referenceWorld_.reset();
}

void Session::storeSlot(int side)
{
    if (!picture_) return;
    slots[static_cast<size_t>(side)] = {picture_, pictureLabel(*picture_)};
}

void Session::compareEqualTime(const RenderParams& a, const RenderParams& b, double seconds)
{
    equalTime_.start(a, b, seconds, generation_);
    restart();
}

void Session::exportTrack(const fs::path& pattern, uint32_t samples)
{
    if (!document_ || track.empty()) {
        notices.tell(Severity::error, "there is no path to export: add keys first");
        return;
    }
    try {
        core_.start("export " + pattern.filename().string(),
                    exportJob(*document_, track, pattern, ordered_.size, render.method, samples,
                              settings.view));
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
    }
}

}  // namespace app

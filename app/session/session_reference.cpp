// The session's reference, its two sides of the slider, and frames of a path. See session.h.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/files/camera_file.h"
#include "app/files/picture_layers.h"
#include "app/session/pending_saves.h"
#include "app/session/session.h"
#include "app/session/session_jobs.h"
#include "core/base/check.h"
#include "core/image/exr_header.h"
#include "core/methods/method.h"

namespace app {

namespace fs = std::filesystem;

namespace {

/// A number that a picture says of itself; 0 where it says none, or nonsense.
double numberOf(const core::Metadata& metadata, const char* name)
{
    const auto found = metadata.find(name);
    const double value = found == metadata.end() ? 0 : std::strtod(found->second.c_str(), nullptr);
    return value >= 0 && value < 1e15 ? value : 0;
}

Reference referenceFrom(const core::ImageFile& image, const fs::path& file)
{
    Reference reference;
    reference.mean = rgbOf(image, file);
    if (std::optional<core::Image> variance = rgbVarianceOf(image))
        reference.variance = std::move(*variance);
    reference.noise = referenceNoise(reference);
    reference.origin = file.filename().string();
    reference.samples = static_cast<uint64_t>(numberOf(image.metadata, "spp"));
    reference.seconds = numberOf(image.metadata, "seconds");
    return reference;
}

/// Whether two cameras show the same but for what rounding on the way through a file does.
bool looksAlike(const core::Camera& a, const core::Camera& b, double radius)
{
    constexpr double kAlike = 1e-5;
    const auto near = [&](double x, double y, double scale) {
        return std::abs(x - y) <= kAlike * scale;
    };
    return glm::distance(a.position, b.position) <= kAlike * radius &&
           glm::distance(a.forward, b.forward) <= kAlike && glm::distance(a.up, b.up) <= kAlike &&
           a.orthographic == b.orthographic &&
           (a.orthographic ? near(a.ymag, b.ymag, radius) : near(a.yfov, b.yfov, 1)) &&
           near(a.apertureRadius, b.apertureRadius, radius) &&
           (a.apertureRadius == 0 || near(a.focusDistance, b.focusDistance, radius));
}

/// "another scene", "another camera": by what a picture of this program says of itself, where that
/// is not what is on show; empty where nothing speaks against it.
std::string otherView(const core::Metadata& metadata, const Document& document,
                      const core::Camera& view)
{
    const auto hash = metadata.find("scene_hash"), camera = metadata.find("camera");
    if (hash == metadata.end() || camera == metadata.end()) return {};
    const core::World& world = *document.world;
    if (hash->second != world.scene->hash) return "another scene";
    if (numberOf(metadata, "at") != document.time) return "another moment of the scene";
    try {
        const core::Camera made = cameraFromJson(parseJson(camera->second, "camera"),
                                                 core::Camera{}, world.placement, "camera");
        const double aspect =
            numberOf(metadata, "width") / std::max(numberOf(metadata, "height"), 1.0);
        if (looksAlike(framed(made, aspect), view, static_cast<double>(world.radius))) return {};
    } catch (const core::Error&) {
        // A camera that cannot be read is not this one.
    }
    return "another camera";
}

}  // namespace

bool Session::referenceFits(const RenderRequest& request) const
{
    return reference_ && referenceWorld_ == request.world && referenceCamera_ == request.camera &&
           reference_->mean.width == request.size.x && reference_->mean.height == request.size.y;
}

bool Session::referenceFits(const Picture& picture) const
{
    return reference_ && referenceWorld_ == picture.world.lock() &&
           referenceCamera_ == picture.camera &&
           glm::uvec2(reference_->mean.width, reference_->mean.height) == picture.fullSize;
}

bool Session::referenceFits() const
{
    return referenceFits(ordered_);
}

/// Says so when the core thread works on something else than what may be begun anew (`but`).
bool Session::coreIsBusy(const char* but)
{
    const core::JobStatus job = core_.status();
    if (!job.active() || job.name == but) return false;
    notices.tell(Severity::error,
                 job.name + " is under way: it ends first, or is cancelled  [Esc]");
    return true;
}

void Session::startReference(uint64_t samples, std::string_view method)
{
    core::AnyParams params = render.method;
    if (!method.empty() && method != params.id()) {
        if (const char* why = core::methodNamed(method).whyNot)
            throw core::Error("method: " + std::string(method) + " makes no references: " + why,
                              core::ExitCode::commandLine);
        params = settings.paramsOf(method);
        uint32_t* const depth = core::findParam<uint32_t>(params, "max-depth");
        const uint32_t* const shown = core::findParam<uint32_t>(render.method, "max-depth");
        if (depth != nullptr && shown != nullptr) *depth = *shown;
    }
    if (!document_ || ordered_.size.x == 0 || coreIsBusy(kReferenceJob)) return;
    dropReference();
    referenceWorld_ = document_->world;
    referenceTime_ = document_->time;
    referenceCamera_ = navigation.view();
    referenceGeneration_ = core_.start(
        kReferenceJob,
        referenceJob({document_->world, referenceCamera_, ordered_.size, params, samples},
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
        // Before the pixels are read, which takes seconds for a large file.
        const core::ExrHeader header = core::readExrHeader(file);
        if (ordered_.size.x > 0 &&
            (header.width != ordered_.size.x || header.height != ordered_.size.y))
            throw core::Error(file.string() + ": is " + std::to_string(header.width) + 'x' +
                              std::to_string(header.height) + ", the picture is " +
                              std::to_string(ordered_.size.x) + 'x' +
                              std::to_string(ordered_.size.y) +
                              " — give the window that size, or take another file");
        const core::ImageFile image = core::readExr(file);
        Reference reference = referenceFrom(image, file);
        dropReference();
        reference_ = std::make_shared<const Reference>(std::move(reference));
        saved_.emplace_back(reference_);
        referenceWorld_ = ordered_.world;
        referenceCamera_ = navigation.view();
        if (!document_) return;
        referenceTime_ = document_->time;
        const std::string other = otherView(image.metadata, *document_, referenceCamera_);
        if (!other.empty())
            notices.tell(Severity::warning, file.string() + ": was made of " + other +
                                                " than what is on show: errors against it say "
                                                "nothing unless both look the same");
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
    pendingReference_.reset();
    reference_.reset();
    referenceWorld_.reset();
}

void Session::keepAsReference()
{
    if (!document_ || !picture_ || picture_->world.lock() != document_->world) {
        notices.tell(Severity::error, "there is no picture to keep as the reference yet");
        return;
    }
    constexpr double kSeconds = 3;  // for the variance, which some methods do not have
    const bool whole = whole_ && onePicture(*whole_, *picture_);
    pendingReference_ = {whole ? whole_ : picture_, document_->world, document_->time,
                         now_ + kSeconds};
    takeReferencePicture();
}

/// With its variance as soon as a picture of the same has it; without where another picture comes
/// first, or none does in time. Of a coarse one the first whole sample is waited for.
void Session::takeReferencePicture()
{
    KeptPicture& kept = *pendingReference_;
    if (whole_ && onePicture(*whole_, *kept.picture) &&
        (whole_->variance || !isWhole(*kept.picture)))
        kept.picture = whole_;
    const bool goesOn = onePicture(*picture_, *kept.picture);
    if (!isWhole(*kept.picture)) {
        if (goesOn) return;
        pendingReference_.reset();
        notices.tell(Severity::error, "the picture is no reference: it was begun anew before its "
                                      "first sample was complete — keep it again at rest");
        return;
    }
    if (kept.picture->variance || !goesOn || now_ >= kept.until) becomeReference(KeptPicture(kept));
}

void Session::becomeReference(const KeptPicture& kept)
{
    const Picture& p = *kept.picture;
    dropReference();
    auto reference = std::make_shared<Reference>();
    reference->mean = p.mean;
    if (p.variance && p.samples >= 2) reference->variance = *p.variance;
    reference->noise = referenceNoise(*reference);
    reference->samples = p.samples;
    reference->seconds = p.seconds;
    reference->origin = "the picture as it was, " + paramsLabel(p.params);
    reference->params = p.params;
    reference_ = std::move(reference);
    if (isSaved(kept.picture)) saved_.emplace_back(reference_);
    referenceWorld_ = kept.world;
    referenceTime_ = kept.time;
    referenceCamera_ = p.camera;
    notices.tell(Severity::news, "the picture is the reference now, after " +
                                     std::to_string(p.samples) + " samples per pixel");
}

bool Session::wantsVariance() const
{
    // A comparison without a reference is made of variances.
    return settings.view.show == Show::deviation || inspecting || !pendingSaves_->empty() ||
           pendingReference_.has_value() || equalTime_.running() || comparing || slotWants_[0] ||
           slotWants_[1] || settings.sections.compare;
}

void Session::takeEqualTime()
{
    const auto side = static_cast<size_t>(equalTime_.side());
    std::optional<Slot> slot = equalTime_.offer(picture_);
    if (!slot) return;
    slots[side] = std::move(*slot);
    slots[side].time = document_->time;
    if (equalTime_.running()) {
        restart();  // the next side's time begins now, also when it equals the first
        return;
    }
    comparing = true;
    notices.tell(Severity::news,
                 "both sides have had their time: the slider compares them, the panel tells their "
                 "errors");
}

RenderParams Session::sideParams(size_t side) const
{
    if (chosenParams[side]) return *chosenParams[side];
    return slots[side].picture ? slots[side].picture->params : render;
}

/// Tells scenes and their instants apart, also when one is loaded again.
std::string Session::sceneName() const
{
    return document_->world->scene->hash + " at " + std::to_string(document_->time);
}

void Session::judge()
{
    Judged wanted;
    if (slots[0].picture && slots[1].picture) {
        wanted.a = slots[0].picture;
        wanted.b = slots[1].picture;
        if (referenceFits(*wanted.a)) wanted.reference = reference_;
    }
    if (settings.view.show == Show::flip && picture_ && !picture_->preview &&
        referenceFits(*picture_)) {
        wanted.seen = picture_;
        wanted.seenReference = reference_;
    }
    judge_.update(wanted);
}

bool Session::storeSlot(size_t side)
{
    if (!shownScene()) {
        notices.tell(Severity::error, "there is no picture to keep yet");
        return false;
    }
    // Amid a sample some pixels have had one more than is told of the picture.
    const bool before = !isWhole(*picture_) && whole_ && onePicture(*whole_, *picture_);
    const std::shared_ptr<const Picture>& kept = before ? whole_ : picture_;
    slots[side] = {kept, pictureLabel(*kept), kept->time};
    slotWants_[side] = !kept->variance || !isWhole(*kept);
    return true;
}

void Session::swapSlots()
{
    if (equalTime_.running()) {
        notices.tell(Severity::news,
                     "equal time: A and B can be swapped when both have had theirs");
        return;
    }
    std::swap(slots[0], slots[1]);
    std::swap(chosenParams[0], chosenParams[1]);
    std::swap(slotWants_[0], slotWants_[1]);
}

/// What was kept before its variance was asked for is replaced by the next picture of the same that
/// has it: without, two pictures could not be compared unless there is a reference. One that is not
/// whole is replaced by the first that is in any case.
void Session::completeSlots()
{
    for (size_t side = 0; side < slots.size(); ++side) {
        if (!slotWants_[side] || !picture_) continue;
        Slot& slot = slots[side];
        const bool same = slot.picture && onePicture(*slot.picture, *picture_);
        if (same && !(isWhole(*picture_) && (picture_->variance || !isWhole(*slot.picture))))
            continue;
        if (same) slot = {picture_, pictureLabel(*picture_), slot.time};
        slotWants_[side] = same && !picture_->variance;
    }
}

void Session::compareEqualTime(const RenderParams& a, const RenderParams& b, double seconds)
{
    chosenParams = {a, b};
    track.stop();  // both sides show one view
    player.playing = false;
    equalTime_.start(a, b, seconds, generation_);
    restart();
}

void Session::exportTrack(const fs::path& pattern, uint32_t samples)
{
    if (!document_ || track.empty()) {
        notices.tell(Severity::error, "there is no path to export: add keys first");
        return;
    }
    if (coreIsBusy("")) return;
    try {
        if (pattern.has_parent_path()) {  // the last folder of it is made
            std::error_code unknown;
            fs::create_directory(pattern.parent_path(), unknown);
        }
        core_.start("export " + pattern.filename().string(),
                    exportJob(*document_, track, pattern, ordered_.size, render.method, samples,
                              settings.view));
        exportPattern_ = pattern;
    } catch (const core::Error& error) {
        notices.tell(Severity::error, error.what());
    }
}

}  // namespace app

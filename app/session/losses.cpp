// See losses.h.
#include "app/session/losses.h"

#include <cstdio>
#include <filesystem>

#include "app/base/new_name.h"
#include "app/session/session.h"

namespace app {

namespace {

std::string rounded(double value, const char* unit)
{
    char text[48];
    std::snprintf(text, sizeof text,
                  value < 9.95 && value != static_cast<int>(value) ? "%.1f %s" : "%.0f %s", value,
                  unit);
    return text;
}

}  // namespace

std::string spanText(double seconds)
{
    if (seconds < 120)
        return rounded(seconds < 9.95 ? seconds : static_cast<int>(seconds), "seconds");
    if (seconds < 7200) return rounded(seconds / 60, "minutes");
    return rounded(seconds / 3600, "hours");
}

namespace {

/// Whether the live picture stays when `parts` go: as a side of the slider.
bool staysAsSide(const Session& session, const Parts& parts)
{
    const auto& [a, b] = session.slots;
    return (!parts.a && holds(a.picture, session.picture())) ||
           (!parts.b && holds(b.picture, session.picture()));
}

void addPicture(const Session& session, const Parts& parts, std::vector<Loss>& losses)
{
    const double seconds = session.unsavedSeconds();
    if (seconds <= session.muchSeconds || staysAsSide(session, parts)) return;
    losses.push_back({Part::picture, "the picture: " + std::to_string(session.picture()->samples) +
                                         " samples per pixel, " + spanText(seconds) +
                                         " of rendering"});
}

void addSide(const Session& session, size_t side, std::vector<Loss>& losses)
{
    const std::shared_ptr<const Picture>& stored = session.slots[side].picture;
    if (!stored || session.isSaved(stored)) return;
    // What is on show is told as the picture.
    if (holds(stored, session.picture()) && stored->seconds == session.picture()->seconds) return;
    if (stored->seconds <= session.muchSeconds) return;
    losses.push_back(
        {side == 0 ? Part::a : Part::b, std::string("picture ") + (side == 0 ? "A" : "B") + ": " +
                                            spanText(stored->seconds) + " of rendering"});
}

/// The reference, and what runs in the background: one that is being rendered is told once.
void addReference(const Session& session, const Parts& parts, std::vector<Loss>& losses)
{
    const core::JobStatus job = session.coreThread();
    const bool rendersIt = job.active() && job.name == kReferenceJob;
    const bool goes = job.active() && (parts.background || (parts.reference && rendersIt));
    if (goes && job.seconds > session.muchSeconds)
        losses.push_back(
            {rendersIt ? Part::reference : Part::background,
             "what runs in the background (" + job.name + "): " + spanText(job.seconds)});
    const std::shared_ptr<const Reference> reference = session.reference();
    if (!parts.reference || !reference || rendersIt || session.isSaved(reference)) return;
    if (reference->seconds > session.muchSeconds)
        losses.push_back(
            {Part::reference, "the reference: " + spanText(reference->seconds) + " of rendering"});
}

}  // namespace

std::vector<Loss> lossesOf(const Session& session, const Parts& parts)
{
    std::vector<Loss> losses;
    if (parts.picture) addPicture(session, parts, losses);
    if (parts.a) addSide(session, 0, losses);
    if (parts.b) addSide(session, 1, losses);
    addReference(session, parts, losses);
    if (parts.path && session.track.unsaved())
        losses.push_back(
            {Part::path, "the camera path: " + std::to_string(session.track.keys().size()) +
                             " keys that are in no file"});
    return losses;
}

bool canBeSaved(const Session& session, const Loss& loss)
{
    return loss.part != Part::background &&
           (loss.part != Part::reference || session.reference() != nullptr);
}

void saveLosses(Session& session, const std::vector<Loss>& losses, const std::string& picture)
{
    session.beginSaves();
    for (const Loss& loss : losses) {
        switch (loss.part) {
        case Part::picture:
            session.save(picture.empty() ? newName(".exr") : std::filesystem::path(picture));
            break;
        case Part::a:
            session.saveSlot(0, newName("-a.exr"));
            break;
        case Part::b:
            session.saveSlot(1, newName("-b.exr"));
            break;
        case Part::reference:
            session.saveReference(newName("-reference.exr"));
            break;
        case Part::path:
            session.savePath(newName("-path.json"));
            break;
        case Part::background:
            break;  // what an export has written stays
        }
    }
}

}  // namespace app

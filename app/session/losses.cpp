// See losses.h.
#include "app/session/losses.h"

#include <cstdio>

namespace app {

namespace {

constexpr double kMuch = 60;  // seconds

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

std::vector<std::string> lossesOf(const Session& session)
{
    std::vector<std::string> losses;
    const std::shared_ptr<const Picture> picture = session.picture();
    if (const double seconds = session.unsavedSeconds(); seconds > kMuch)
        losses.push_back("the picture: " + std::to_string(picture->samples) +
                         " samples per pixel, " + spanText(seconds) + " of rendering");
    for (size_t i = 0; i < session.slots.size(); ++i) {
        const std::shared_ptr<const Picture>& stored = session.slots[i].picture;
        if (stored && stored != picture && stored->seconds > kMuch)
            losses.push_back(std::string("picture ") + (i == 0 ? "A" : "B") + ": " +
                             spanText(stored->seconds) + " of rendering");
    }
    const std::shared_ptr<const Reference> reference = session.reference();
    const core::JobStatus job = session.coreThread();
    if (job.active() && job.seconds > kMuch)
        losses.push_back("what runs in the background (" + job.name +
                         "): " + spanText(job.seconds));
    // One that is being rendered is the work that has been told.
    const bool isTold = job.active() && job.name == "reference";
    if (reference && !isTold && reference->seconds > kMuch)
        losses.push_back("the reference: " + spanText(reference->seconds) + " of rendering");
    return losses;
}

}  // namespace app

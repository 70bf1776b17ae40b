// Over the picture: what takes long, with its way out, and what has just been told.
#include <algorithm>
#include <cmath>

#include "app/view/imgui/windows.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

constexpr ImGuiWindowFlags kNote = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                   ImGuiWindowFlags_NoSavedSettings |
                                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                                   ImGuiWindowFlags_AlwaysAutoResize;
constexpr size_t kMostToasts = 4;

// What is over sooner is not worth reading
constexpr double kShortest = 0.5;

/// Something that takes its time.
struct Strip {
    std::string name, stage;
    double fraction = 0, seconds = 0;  // of the stage, or core::kUnknownShare
    std::optional<Work> work = {};     // that its button cancels
};

Strip jobStrip(const core::JobStatus& job, Work work)
{
    return {job.name, job.state == core::JobState::waiting ? "waiting" : job.stage, job.fraction,
            job.seconds, work};
}

Strip equalTimeStrip(const EqualTime& run)
{
    return {"equal time", run.side() == 0 ? "rendering A" : "rendering B", run.fraction(),
            run.fraction() * run.seconds(), Work::equalTime};
}

/// The newest first: the one that Esc cancels.
std::vector<Strip> presentStrips(const UiContext& c)
{
    std::vector<Strip> strips;
    for (const Work work : c.session.works()) {
        if (work == Work::load)
            strips.push_back(jobStrip(c.session.loading(), work));
        else if (work == Work::background)
            strips.push_back(jobStrip(c.session.coreThread(), work));
        else if (work == Work::equalTime)
            strips.push_back(equalTimeStrip(c.session.equalTime()));
    }
    std::erase_if(strips, [](const Strip& strip) {
        return strip.work != Work::equalTime && strip.seconds < kShortest;
    });
    const RenderThreadStatus status = c.session.rendering();
    const bool quiet = status.stage.empty() || status.stage == "idle" || status.stage == "render";
    if (!quiet && !status.rendering && status.error.empty() && status.stageSeconds >= kShortest) {
        strips.push_back({"renderer", status.stage, status.fraction, status.stageSeconds});
    }
    return strips;
}

/// A bar of which a part moves, where nobody knows how much is done.
void unknownBar(float width, const std::string& text)
{
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float height = ImGui::GetFrameHeight(), part = 0.25f * width;
    ImGui::ProgressBar(0, ImVec2(width, 0), "");
    const double turn = std::fmod(ImGui::GetTime() / 2, 1.0);  // a turn takes two seconds
    const float at = static_cast<float>(0.5 - 0.5 * std::cos(turn * 6.2831853)) * (width - part);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled({corner.x + at, corner.y}, {corner.x + at + part, corner.y + height},
                       ImGui::GetColorU32(ImGuiCol_PlotHistogram), ImGui::GetStyle().FrameRounding);
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    list.AddText({corner.x + 0.5f * (width - size.x), corner.y + 0.5f * (height - size.y)},
                 ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
}

/// Room for the names before the bars.
float nameWidth(const UiContext& c, const std::vector<Strip>& strips, float width)
{
    float longest = 5 * c.em;
    for (const Strip& strip : strips)
        longest = std::max(longest, ImGui::CalcTextSize(strip.name.c_str()).x);
    return std::min(longest, 0.4f * width) + c.em;
}

void drawStrip(const UiContext& c, const Strip& strip, float width, float names)
{
    ImGui::AlignTextToFramePadding();
    const std::string name = shortenedLabel(strip.name, names - c.em);
    ImGui::TextUnformatted(name.c_str());
    if (name != strip.name) tip(strip.name);
    const bool known = strip.fraction != core::kUnknownShare;
    // "reference" twice in a line says no more than once.
    std::string text = strip.stage.empty() || strip.stage == strip.name ? "" : strip.stage + "  ";
    if (known) text += format("%.0f %%  ", 100 * std::clamp(strip.fraction, 0.0, 1.0));
    text += secondsText(std::floor(strip.seconds * 10) / 10);
    ImGui::SameLine(names);
    const float button = strip.work ? buttonWidth("Cancel") + ImGui::GetStyle().ItemSpacing.x : 0;
    const float room = std::max(width - names - button, 4 * c.em);
    const std::string shown = shortenedLabel(text, room - 0.5f * c.em);
    if (known) {
        ImGui::ProgressBar(static_cast<float>(std::clamp(strip.fraction, 0.0, 1.0)),
                           ImVec2(room, 0), shown.c_str());
    } else {
        unknownBar(room, shown);
    }
    if (shown != text) tip(text);
    if (!strip.work) return;
    ImGui::SameLine();
    actionButton(c, "Cancel", "cancel", {}, {{"what", core::enumName(*strip.work)}});
}

double lifetime(Severity severity)
{
    return severity == Severity::news ? 5 : severity == Severity::warning ? 9 : HUGE_VAL;
}

void takeNotices(const UiContext& c)
{
    const uint64_t count = c.session.notices.count();
    UiState& state = c.state;
    if (count == state.seenNotices) return;
    for (const Notice& notice : c.session.notices.list()) {
        if (notice.number <= state.seenNotices) continue;
        Toast toast{notice, ImGui::GetTime()};
        std::erase_if(state.toasts, [&](const Toast& old) {
            // Files that are written one after the other are one message, of the newest.
            const bool alsoWritten = !notice.file.empty() && !old.notice.file.empty() &&
                                     notice.severity == Severity::news &&
                                     old.notice.severity == Severity::news;
            if (alsoWritten && old.notice.text != notice.text) toast.before += old.before + 1;
            return alsoWritten || old.notice.text == notice.text;
        });
        state.toasts.push_back(std::move(toast));
    }
    state.seenNotices = count;
    while (state.toasts.size() > 50) state.toasts.erase(state.toasts.begin());
}

/// A click copies the path of the file that was written; the notice stays for a moment to say so.
void copyPath(Toast& toast)
{
    dimText(toast.copied ? "its path is in the clipboard" : "a click copies its path");
    if (!ImGui::IsWindowHovered() || !ImGui::IsMouseClicked(ImGuiMouseButton_Left)) return;
    ImGui::SetClipboardText(toast.notice.file.c_str());
    toast.copied = true;
    toast.since = ImGui::GetTime();
}

std::string toastText(const Toast& toast)
{
    const std::string text = toast.notice.text + timesText(toast.notice);
    return toast.before > 0 ? text + " (and " + std::to_string(toast.before) + " before it)" : text;
}

/// The lower end of the title bars that lie where toasts would, right of `left`: what closes a
/// window stays within reach.
float belowTitles(const UiContext& c, float left)
{
    float low = 0;
    for (const char* window :
         {"###help", "###log", "###plot", "###profiler", "Open a scene###open"})
        if (ImVec2 corner, size; lastPlace(window, corner, size)) {
            const float end = corner.y + ImGui::GetFrameHeight() + 0.3f * c.em;
            if (corner.x + size.x > left && end < 0.4f * c.window.y) low = std::max(low, end);
        }
    return low;
}

/// In a window of so much height; what has no room in it can be scrolled.
void drawToastText(const std::string& text, float height)
{
    const float room = std::max(height - 2 * ImGui::GetStyle().WindowPadding.y, 1.0f);
    const float width = ImGui::GetContentRegionAvail().x;
    const bool fits = ImGui::CalcTextSize(text.c_str(), nullptr, false, width).y <= room;
    if (!fits) ImGui::BeginChild("##text", ImVec2(0, room));
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopTextWrapPos();
    if (!fits) ImGui::EndChild();
}

/// Draws one of at most so much height; false when it is to go.
bool drawToast(const UiContext& c, Toast& toast, float width, float most, float& bottom)
{
    const double age = ImGui::GetTime() - toast.since, life = lifetime(toast.notice.severity);
    const auto alpha = static_cast<float>(std::clamp((life - age) / 0.6, 0.0, 1.0));
    bool stays = age < life;
    const ImVec4 colour = toast.notice.severity == Severity::error ? kErrorColour
                          : toast.notice.severity == Severity::warning
                              ? kWarningColour
                              : ImGui::GetStyleColorVec4(ImGuiCol_Text);
    ImGui::SetNextWindowPos(ImVec2(c.picture.end().x - 0.7f * c.em, bottom), ImGuiCond_Always,
                            ImVec2(1, 0));
    ImGui::SetNextWindowSizeConstraints(ImVec2(width, 0), ImVec2(width, most));
    ImGui::SetNextWindowBgAlpha(0.96f);
    ImGui::PushStyleVar(ImGuiStyleVar_Alpha, std::max(alpha, 0.02f));
    const std::string id = "##toast" + std::to_string(toast.notice.number);
    if (ImGui::Begin(id.c_str(), nullptr, kNote)) {
        bringToFront();
        ImGui::PushStyleColor(ImGuiCol_Text, colour);
        const bool buttons = toast.notice.severity != Severity::news;
        drawToastText(toastText(toast), most - (buttons ? ImGui::GetFrameHeightWithSpacing() : 0));
        ImGui::PopStyleColor();
        if (buttons) {
            if (ImGui::SmallButton("Copy")) ImGui::SetClipboardText(toast.notice.text.c_str());
            ImGui::SameLine();
            if (ImGui::SmallButton("Close")) stays = false;
        } else if (!toast.notice.file.empty()) {
            copyPath(toast);
        } else if (ImGui::IsWindowHovered() && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
            stays = false;
        }
    }
    bottom = ImGui::GetWindowPos().y + ImGui::GetWindowSize().y + 0.4f * c.em;
    ImGui::End();
    ImGui::PopStyleVar();
    return stays;
}

}  // namespace

void drawProgress(const UiContext& c)
{
    const std::vector<Strip> strips = presentStrips(c);
    c.state.progress = ImVec2(0, 0);
    if (strips.empty()) return;
    const float room = c.picture.size.x - 1.4f * c.em;
    const float width =
        std::min(34 * c.em, std::max(room - 2 * ImGui::GetStyle().WindowPadding.x, 12 * c.em));
    ImGui::SetNextWindowPos(
        ImVec2(c.picture.corner.x + 0.7f * c.em, c.state.caption.y + 0.7f * c.em));
    ImGui::SetNextWindowBgAlpha(0.96f);
    if (ImGui::Begin("##progress", nullptr, kNote)) {
        const float names = nameWidth(c, strips, width);
        ImVec4 done = ImGui::GetStyleColorVec4(ImGuiCol_PlotHistogram);
        done.w = 0.35f;  // text lies on it
        ImGui::PushStyleColor(ImGuiCol_PlotHistogram, done);
        for (size_t i = 0; i < strips.size(); ++i) {
            ImGui::PushID(static_cast<int>(i));
            drawStrip(c, strips[i], width, names);
            ImGui::PopID();
        }
        ImGui::PopStyleColor();
        const ImVec2 place = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
        c.state.progress = ImVec2(place.x + size.x, place.y + size.y);
    }
    ImGui::End();
}

void drawToasts(const UiContext& c)
{
    takeNotices(c);
    std::vector<Toast>& toasts = c.state.toasts;
    const float room = c.picture.size.x - 1.4f * c.em;
    const float width = std::min({28 * c.em, std::max(room, 14 * c.em), c.window.x - 1.4f * c.em});
    const float left = c.picture.end().x - width - 1.4f * c.em;
    float bottom = std::max(0.7f * c.em, belowTitles(c, left));
    for (const ImVec2& other : {c.state.caption, c.state.progress})  // on the left, as a rule
        if (other.x > left) bottom = std::max(bottom, other.y + 0.7f * c.em);
    // The newest has its room in any case, but all together no more than a third of the height.
    const float least = 3 * c.em + 2 * ImGui::GetStyle().WindowPadding.y;
    bottom = std::max(std::min(bottom, c.window.y - least), 0.0f);
    const float end = std::min(bottom + std::max(c.window.y / 3, least), c.window.y);
    size_t shown = 0;
    for (size_t i = toasts.size();
         i-- > 0 && shown < kMostToasts && (shown == 0 || bottom + least <= end); ++shown) {
        if (!drawToast(c, toasts[i], width, std::max(end - bottom, least), bottom))
            toasts.erase(toasts.begin() + static_cast<ptrdiff_t>(i));
    }
}

}  // namespace app

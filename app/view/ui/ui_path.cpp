// Section of the panel: the camera path, its keys on a time line and in a list, and its frames as
// files.
#include <algorithm>
#include <cmath>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

/// The time line's scale: the first key at the left edge, the last at the right, both inset.
struct TimeLine {
    float left = 0, right = 1;
    double first = 0, last = 1;
    float place(double frame) const
    {
        const double t = last > first ? (frame - first) / (last - first) : 0;
        return left + static_cast<float>(t) * (right - left);
    }
    double frame(float x) const
    {
        const float t = right > left ? (x - left) / (right - left) : 0;
        return first + static_cast<double>(t) * (last - first);
    }
};

void drawDiamond(ImVec2 centre, float radius, ImU32 colour)
{
    ImGui::GetWindowDrawList()->AddQuadFilled(
        {centre.x - radius, centre.y}, {centre.x, centre.y - radius}, {centre.x + radius, centre.y},
        {centre.x, centre.y + radius}, colour);
}

/// The key under the mouse, or -1.
int keyAt(const CameraTrack& track, const TimeLine& line, float x, float reach)
{
    int nearest = -1;
    for (size_t i = 0; i < track.keys().size(); ++i) {
        const float distance = std::abs(line.place(track.keys()[i].frame) - x);
        if (distance > reach) continue;
        nearest = static_cast<int>(i);
        reach = distance;
    }
    return nearest;
}

/// Drags of keys and of the playhead. `line` is that of this frame: a key at an end is dragged
/// beyond it at its scale.
void handleTimeLine(const UiContext& c, const TimeLine& line, float reach)
{
    CameraTrack& track = c.session.track;
    const float x = ImGui::GetIO().MousePos.x;
    if (ImGui::IsItemActivated()) {
        const int key = keyAt(track, line, x, reach);
        c.state.draggingKey = key >= 0;
        if (key >= 0) c.state.selectedKey = key;
    }
    if (!ImGui::IsItemActive()) return;
    const bool dragged = ImGui::IsMouseDragging(ImGuiMouseButton_Left, 2);
    if (!c.state.draggingKey) {
        track.stop();
        track.seek(std::clamp(line.frame(x), line.first, line.last));
        c.session.navigation.set(track.at(track.frame()),
                                 static_cast<double>(c.session.document()->world->radius));
        c.session.moved();
    } else if (dragged && c.state.selectedKey >= 0) {
        const float step = ImGui::GetIO().MouseDelta.x;
        if (step == 0) return;
        const double target = std::max(0.0, std::round(line.frame(x)));
        const auto index = static_cast<size_t>(c.state.selectedKey);
        if (target != track.keys()[index].frame)
            c.state.selectedKey = static_cast<int>(track.move(index, target));
    }
}

void drawTimeLine(const UiContext& c)
{
    const CameraTrack& track = c.session.track;
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size(std::max(ImGui::GetContentRegionAvail().x, 4 * c.em), 2.2f * c.em);
    ImGui::InvisibleButton("##time line", size);
    const float radius = c.em * 0.42f, middle = corner.y + size.y * 0.5f;
    const TimeLine line{corner.x + 2 * radius, corner.x + size.x - 2 * radius, track.firstFrame(),
                        track.lastFrame()};
    handleTimeLine(c, line, 1.6f * radius);
    if (!c.state.draggingKey) tip("keys can be dragged; elsewhere the camera goes along the path");
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y},
                       ImGui::GetColorU32(ImGuiCol_FrameBg), ImGui::GetStyle().FrameRounding);
    list.AddLine({line.left, middle}, {line.right, middle},
                 ImGui::GetColorU32(ImGuiCol_Text, 0.25f));
    const float head = line.place(std::clamp(track.frame(), line.first, line.last));
    list.AddLine({head, corner.y + 2}, {head, corner.y + size.y - 2},
                 ImGui::GetColorU32(ImGuiCol_CheckMark), 2);
    for (size_t i = 0; i < track.keys().size(); ++i) {
        const bool selected = static_cast<int>(i) == c.state.selectedKey;
        drawDiamond({line.place(track.keys()[i].frame), middle}, selected ? radius * 1.25f : radius,
                    ImGui::GetColorU32(selected ? ImGuiCol_CheckMark : ImGuiCol_Text));
    }
}

/// One key as a row: its frame, go, replace, remove. True when the list has changed.
bool drawKeyRow(const UiContext& c, size_t i)
{
    CameraTrack& track = c.session.track;
    const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
    const float buttons = buttonWidth("Go") + buttonWidth("Here") + buttonWidth("x") + 3 * gap;
    double frame = track.keys()[i].frame;
    ImGui::AlignTextToFramePadding();
    dimText("frame");
    ImGui::SameLine(0, gap);
    ImGui::SetNextItemWidth(std::max(ImGui::GetContentRegionAvail().x - buttons, 3 * c.em));
    if (ImGui::InputDouble("##frame", &frame, 0, 0, "%.6g")) c.state.editedFrame = frame;
    // Only when it is typed whole: 1 on the way to 12 would reorder the keys.
    if (ImGui::IsItemDeactivatedAfterEdit() && c.state.editedFrame >= 0 &&
        c.state.editedFrame != track.keys()[i].frame) {
        c.state.selectedKey = static_cast<int>(track.move(i, c.state.editedFrame));
        return true;
    }
    ImGui::SameLine(0, gap);
    if (plainButton("Go", "go to this key")) {
        c.state.selectedKey = static_cast<int>(i);
        track.stop();
        track.seek(track.keys()[i].frame);
        c.session.navigation.set(track.keys()[i].camera,
                                 static_cast<double>(c.session.document()->world->radius));
        c.session.moved();
    }
    ImGui::SameLine(0, gap);
    if (plainButton("Here", "put this key where you stand"))
        track.replace(i, c.session.navigation.camera());
    ImGui::SameLine(0, gap);
    if (!actionButton(c, "x", "remove-key", {}, {{"index", i}})) return false;
    c.state.selectedKey = -1;
    return true;
}

void drawKeys(const UiContext& c)
{
    const size_t count = c.session.track.keys().size();
    const float rows = std::min(static_cast<float>(count), 6.0f);
    ImGui::BeginChild("##keys", ImVec2(0, rows * ImGui::GetFrameHeightWithSpacing() + 4));
    for (size_t i = 0; i < count; ++i) {
        ImGui::PushID(static_cast<int>(i));
        const bool changed = drawKeyRow(c, i);
        ImGui::PopID();
        if (changed)
            break;  // the rest of the list is another one now; it is drawn in the next frame
    }
    ImGui::EndChild();
}

void drawPlayback(const UiContext& c)
{
    CameraTrack& track = c.session.track;
    const std::string few = track.keys().size() < 2 ? "a path needs two keys" : "";
    actionButton(c, track.playing() ? "Stop" : "Play", "play-path", few, {}, 5 * c.em);
    ImGui::SameLine();
    ImGui::Checkbox("loop##path", &track.loop);
    ImGui::PushID("fps");
    rowLabel("frames/s", "frames of the path per second of playing");
    double rate = track.framesPerSecond;
    if (ImGui::InputDouble("##value", &rate, 0, 0, "%.4g") && std::isfinite(rate))
        track.framesPerSecond = std::clamp(rate, 0.001, 1e5);  // as files may have it
    ImGui::PopID();
}

void drawExport(const UiContext& c)
{
    CameraTrack& track = c.session.track;
    ImGui::PushID("export");
    rowLabel("frames as", "numbered files: %04d becomes the frame");
    textInput("##pattern", "frame-%04d.exr", c.state.exportPattern);
    rowLabel("samples", "samples per pixel of every exported frame");
    countInput("##samples", c.state.exportSamples);
    c.state.exportSamples = std::clamp<uint64_t>(c.state.exportSamples, 1, 1u << 30);
    std::string why;
    if (track.keys().size() < 2) why = "a path needs two keys";
    if (c.session.coreThread().active())
        why = "something else runs in the background: cancel it first";
    if (buttonOf(c, "Export frames", "export-path", why)) {
        if (c.state.exportPattern == kFramePattern)  // nobody has typed it
            c.act("export-path", {{"spp", c.state.exportSamples}});
        else
            writeTyped(c, "export-path",
                       {{"file", c.state.exportPattern}, {"spp", c.state.exportSamples}});
    }
    ImGui::PopID();
}

void drawFiles(const UiContext& c)
{
    if (pathInput(c.state.path, "path file", "path file, .json", {".json"}))
        c.act("load-path", {{"file", c.state.path.text}});
    const std::string unnamed = c.state.path.text.empty() ? "type a file's name first" : "";
    actionButton(c, "Load", "load-path", unnamed, {{"file", c.state.path.text}});
    sameLineIfRoom(buttonWidth("Save"));
    const std::string empty = c.session.track.empty() ? "the path has no keys" : unnamed;
    if (buttonOf(c, "Save", "save-path", empty))
        writeTyped(c, "save-path", {{"file", c.state.path.text}});
}

}  // namespace

void drawPathSection(const UiContext& c)
{
    if (c.session.document() == nullptr) {
        dimText("no scene");
        return;
    }
    const size_t keys = c.session.track.keys().size();
    if (c.state.selectedKey >= static_cast<int>(keys)) c.state.selectedKey = -1;
    actionButton(c, "Add key here", "add-key");
    sameLineIfRoom(buttonWidth("Clear"));
    actionButton(c, "Clear", "clear-path", keys == 0 ? "the path has no keys" : "");
    if (keys == 0) {
        dimText("Keys say where the camera is at which frame; between them it glides.");
    } else {
        drawTimeLine(c);
        drawKeys(c);
        drawPlayback(c);
    }
    drawFiles(c);
    if (keys > 0) drawExport(c);
}

}  // namespace app

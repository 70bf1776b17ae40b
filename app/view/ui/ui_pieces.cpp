// Small pieces that the parts of the panel share. See ui_parts.h.
#include <algorithm>
#include <cstring>
#include <utility>

#include "app/files/params_json.h"
#include "app/files/path_completion.h"
#include "app/view/imgui/input.h"
#include "app/view/imgui/windows.h"
#include "app/view/ui/ui_parts.h"
#include "core/base/check.h"

#include <imgui_stdlib.h>  // after imgui.h, on which it stands

namespace app {
namespace {

const Action* findAction(const char* name)
{
    for (const Action& action : actions()) {
        if (std::strcmp(action.name, name) == 0) return &action;
    }
    return nullptr;
}

/// Disables until the end of its life when there is a reason to.
class Disabled {
public:
    explicit Disabled(bool disabled) { ImGui::BeginDisabled(disabled); }
    ~Disabled() { ImGui::EndDisabled(); }
    Disabled(const Disabled&) = delete;
    Disabled& operator=(const Disabled&) = delete;
};

int pathEdited(ImGuiInputTextCallbackData* data)
{
    auto& box = *static_cast<PathBox*>(data->UserData);
    if (data->EventFlag == ImGuiInputTextFlags_CallbackAlways) {
        if (std::exchange(box.caretAtEnd, false)) {
            data->ClearSelection();
            data->CursorPos = data->BufTextLen;
        }
        return 0;
    }
    if (data->EventFlag == ImGuiInputTextFlags_CallbackHistory) {
        box.arrows += data->EventKey == ImGuiKey_DownArrow ? 1 : -1;
        return 0;
    }
    const std::string typed(data->Buf, static_cast<size_t>(data->BufTextLen));
    if (box.completions.empty() || box.completedFor != typed) return 0;
    // As far as all of them agree, which may be no farther than what is typed.
    std::string common = box.completions.front();
    for (const std::string& other : box.completions) {
        const auto ends = std::mismatch(common.begin(), common.end(), other.begin(), other.end());
        common.erase(ends.first, common.end());
    }
    if (common.size() < typed.size()) common = typed;
    data->DeleteChars(0, data->BufTextLen);
    data->InsertChars(0, common.c_str());
    return 0;
}

/// The list under the line. It outlives the line's hold of the keyboard, which a click into the
/// list ends.
void drawCompletions(PathBox& box, bool typing)
{
    const bool known = box.completions.size() == 1 && box.completions.front() == box.text;
    if (box.completions.empty() || known) {
        box.open = typing;  // else Esc would close what nobody sees
        return;
    }
    const float rows = std::min(static_cast<float>(box.completions.size()), 6.0f);
    ImGui::BeginChild("##completions", ImVec2(0, rows * ImGui::GetTextLineHeightWithSpacing() + 8),
                      true);
    for (const std::string& completion : box.completions) {
        if (!ImGui::Selectable(completion.c_str())) continue;
        box.text = completion;
        box.focus = true;
    }
    const bool here = ImGui::IsWindowHovered();
    ImGui::EndChild();
    if (!typing && !here && !box.focus && ImGui::IsMouseClicked(ImGuiMouseButton_Left))
        box.open = false;
}

}  // namespace

void UiContext::act(const char* action, const nlohmann::ordered_json& arguments) const
{
    try {
        runByHand(action, session, app, arguments);
    } catch (const core::Error& error) {
        session.notices.tell(Severity::error, error.what());
    }
}

bool plainButton(const char* label, const std::string& help, const std::string& whyNot, float width)
{
    bool clicked;
    {
        const Disabled disabled(!whyNot.empty());
        clicked = ImGui::Button(label, ImVec2(width, 0));
    }
    tip(whyNot.empty() ? help : help + "\n\nNot now: " + whyNot);
    return clicked;
}

bool buttonOf(const UiContext& c, const char* label, const char* action, const std::string& whyNot,
              float width)
{
    const Action* found = findAction(action);
    if (found == nullptr) {
        auto& unknown = c.state.unknownActions;
        if (std::find(unknown.begin(), unknown.end(), action) == unknown.end())
            unknown.emplace_back(action);
        return false;
    }
    std::string help = found->help;
    if (found->key[0] != '\0') help += std::string("  [") + found->key + "]";
    return plainButton(label, help, whyNot, width);
}

bool actionButton(const UiContext& c, const char* label, const char* action,
                  const std::string& whyNot, const nlohmann::ordered_json& arguments, float width)
{
    const bool clicked = buttonOf(c, label, action, whyNot, width);
    if (clicked) c.act(action, arguments);
    return clicked;
}

void writeTyped(const UiContext& c, const char* action, nlohmann::ordered_json arguments)
{
    const std::string asked = std::string(action) + ' ' + arguments["file"].get<std::string>();
    arguments["replace"] = c.state.toReplace == asked;
    c.app.wouldReplace = false;
    c.act(action, arguments);
    c.state.toReplace = std::exchange(c.app.wouldReplace, false) ? asked : "";
}

float buttonWidth(const char* label)
{
    return ImGui::CalcTextSize(label, nullptr, true).x + 2 * ImGui::GetStyle().FramePadding.x;
}

void sameLineIfRoom(float width)
{
    const float right = ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x;
    if (ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x + width <= right)
        ImGui::SameLine();
}

bool section(const char* title, bool& open)
{
    ImGui::SetNextItemOpen(open);
    return open = ImGui::CollapsingHeader(title);
}

void labelOnPicture(const UiContext& c, ImVec2 place, const std::string& text)
{
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const float side = 0.4f * c.em, above = 0.15f * c.em;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.AddRectFilled({place.x - side, place.y - above},
                       {place.x + size.x + side, place.y + size.y + above}, IM_COL32(0, 0, 0, 170),
                       0.25f * c.em);
    list.AddText(place, IM_COL32(240, 240, 240, 255), text.c_str());
}

void wrappedText(const std::string& text)
{
    const std::string lines = wrappedAtSpaces(text, ImGui::GetContentRegionAvail().x);
    ImGui::PushTextWrapPos(0);  // what has no spaces: names of files
    ImGui::TextUnformatted(lines.data(), lines.data() + lines.size());
    ImGui::PopTextWrapPos();
}

void dimText(const std::string& text)
{
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    wrappedText(text);
    ImGui::PopStyleColor();
}

bool pathInput(PathBox& box, const char* id, const char* hint,
               const std::vector<std::string>& extensions)
{
    ImGui::PushID(id);
    box.drawnAt = ImGui::GetFrameCount();
    if (box.focus) ImGui::SetKeyboardFocusHere();
    box.focus = false;
    ImGui::SetNextItemWidth(-1);
    const bool entered = ImGui::InputTextWithHint(
        "##path", hint, &box.text,
        ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_CallbackCompletion |
            ImGuiInputTextFlags_CallbackAlways |
            (box.ownList ? ImGuiInputTextFlags_CallbackHistory : 0),
        pathEdited, &box);
    const bool typing = ImGui::IsItemActive();
    if (ImGui::IsItemActivated() || (typing && box.completedFor != box.text)) {
        box.completions = completePath(box.text, extensions);
        box.completedFor = box.text;
        box.open = true;
    }
    if (entered || (typing && escapePressed(false))) box.open = false;
    if (box.open && !box.ownList) drawCompletions(box, typing);
    ImGui::PopID();
    if (!entered || box.text.empty()) return false;
    box.text = expandHome(box.text);
    return true;
}

bool textInput(const char* id, const char* hint, std::string& text)
{
    return ImGui::InputTextWithHint(id, hint, &text, ImGuiInputTextFlags_EnterReturnsTrue);
}

void zeroHint(const char* text)
{
    if (ImGui::IsItemActive()) return;
    const ImVec2 low = ImGui::GetItemRectMin(), padding = ImGui::GetStyle().FramePadding;
    const float digit = ImGui::CalcTextSize("0").x;
    ImGui::GetWindowDrawList()->AddText(ImVec2(low.x + padding.x + 1.5f * digit, low.y + padding.y),
                                        ImGui::GetColorU32(ImGuiCol_TextDisabled), text);
}

bool countInput(const char* id, uint64_t& value, const char* zero)
{
    const uint64_t step = 1, fast = 64;
    const bool changed = ImGui::InputScalar(id, ImGuiDataType_U64, &value, &step, &fast, "%llu");
    if (value == 0 && zero != nullptr) zeroHint(zero);
    return changed;
}

std::string keyOf(const char* action)
{
    const Action* found = findAction(action);
    return found != nullptr ? found->key : "";
}

bool isRefused(const UiContext& c, const char* action)
{
    const Action* found = findAction(action);
    return found != nullptr && found->refused != nullptr && found->refused(c.session);
}

std::string timesText(const Notice& notice)
{
    return notice.times > 1 ? " (" + std::to_string(notice.times) + " times)" : "";
}

std::vector<std::string> biases(const RenderParams& params)
{
    return biasedParams(params.method);
}

std::shared_ptr<const Picture> shownPicture(const UiContext& c)
{
    return c.session.picture();
}

ImGuiWindowFlags tabFlags()
{
    return ImGui::IsAnyItemActive() ? ImGuiWindowFlags_None : ImGuiWindowFlags_NoNavInputs;
}

bool beginFloating(const UiContext& c, const char* title, bool* open, ImVec2 size, ImVec2 corner)
{
    const float gap = c.em * 0.6f;
    const ImVec2 room(std::max(c.picture.size.x - 2 * gap, 60.0f),
                      std::max(c.picture.size.y - 2 * gap, 40.0f));
    const std::string name = std::strstr(title, "###");
    const glm::vec2 at(corner.x, corner.y), window(c.window.x, c.window.y);
    if (ImVec2 from, extent; lastPlace(title, from, extent))
        c.state.places.seen(name, {{from.x, from.y}, {extent.x, extent.y}}, c.picture, at);
    const glm::vec2 usual(std::min(size.x, room.x), std::min(size.y, room.y));
    const Area place = c.state.places.placeOf(name, c.picture, window, usual, at, gap);
    ImGui::SetNextWindowSize(ImVec2(place.size.x, place.size.y));
    ImGui::SetNextWindowPos(ImVec2(place.corner.x, place.corner.y));
    ImGui::SetNextWindowSizeConstraints(
        ImVec2(std::min(8 * c.em, room.x), std::min(5 * c.em, room.y)),
        ImVec2(c.window.x, c.window.y));
    ImGui::SetNextWindowBgAlpha(c.session.settings.panels.opacity);
    constexpr ImGuiWindowFlags kFlags =
        ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings;
    return ImGui::Begin(title, open, kFlags | tabFlags());
}

}  // namespace app

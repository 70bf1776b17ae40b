// Over the picture: the questions before something is lost, by quitting or by an action.
#include <algorithm>
#include <cctype>
#include <utility>

#include "app/view/imgui/input.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

constexpr const char* kQuit = "Quit?###quit";
constexpr const char* kQuestion = "###question";

/// Opens what has been asked for.
void openQuestions(const UiContext& c)
{
    if (std::exchange(c.app.askQuit, false)) {
        c.state.losses = lossesOf(c.session);
        ImGui::OpenPopup(kQuit);
    } else if (c.app.question) {
        c.state.intent = *std::exchange(c.app.question, std::nullopt);
        c.state.losses = lossesOf(c.session, c.state.intent.action->replaces);
        ImGui::OpenPopup(kQuestion);
    }
}

bool beginQuestion(const UiContext& c, const char* title)
{
    ImGui::SetNextWindowPos(ImVec2(c.window.x / 2, c.window.y / 2), ImGuiCond_Always,
                            ImVec2(0.5f, 0.5f));
    constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_AlwaysAutoResize |
                                        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings;
    if (!ImGui::BeginPopupModal(title, nullptr, kFlags)) return false;
    const float room = c.window.x - 4 * c.em;
    ImGui::Dummy(ImVec2(std::min(28 * c.em, room), 0));  // for the answers in one row
    ImGui::PushTextWrapPos(std::min(34 * c.em, room));
    ImGui::TextUnformatted("This would be lost:");
    for (const Loss& loss : c.state.losses) ImGui::BulletText("%s", loss.text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::Spacing();
    return true;
}

/// Ends the question, which an answer closes.
void endQuestion(const UiContext& c, bool answered)
{
    sameLineIfRoom(6 * c.em);
    const bool stay = ImGui::Button("Stay", ImVec2(6 * c.em, 0));
    // The key that asked is still down in the first frame: it must not answer as well.
    const bool escape = !ImGui::IsWindowAppearing() && escapePressed(false);
    if (answered || stay || escape) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
}

/// The losses that saving first would keep: the label of its button says when not all of them.
size_t savable(const UiContext& c)
{
    return static_cast<size_t>(std::ranges::count_if(
        c.state.losses, [&](const Loss& loss) { return canBeSaved(c.session, loss); }));
}

std::string whyNoSave(const UiContext& c)
{
    return savable(c) > 0 ? "" : "there is nothing yet that could be saved";
}

std::string saveLabel(const UiContext& c, const char* then)
{
    const bool all = savable(c) == c.state.losses.size();
    return (all ? "Save and " : "Save the others and ") + std::string(then);
}

void drawQuitQuestion(const UiContext& c)
{
    if (!beginQuestion(c, kQuit)) return;
    actionButton(c, saveLabel(c, "quit").c_str(), "save-and-quit", whyNoSave(c));
    sameLineIfRoom(6 * c.em);
    actionButton(c, "Quit", "quit-now", {}, nlohmann::ordered_json::object(), 6 * c.em);
    endQuestion(c, c.app.quit || c.app.quitWhenSaved);
}

/// "Render a reference in the background?"
std::string titleOf(const Action& action)
{
    std::string title = action.help;
    title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
    return title + "?" + kQuestion;
}

void drawActionQuestion(const UiContext& c)
{
    const Intent& intent = c.state.intent;
    if (intent.action == nullptr || !beginQuestion(c, titleOf(*intent.action).c_str())) return;
    const bool save = plainButton(saveLabel(c, "go on").c_str(),
                                  "each of it to a new file in the current folder", whyNoSave(c));
    sameLineIfRoom(6 * c.em);
    const bool goOn = plainButton("Go on", "it is lost", {}, 6 * c.em);
    if (save) {
        saveLosses(c.session, c.state.losses);
        c.app.whenSaved = intent;
    } else if (goOn) {
        doIntent(intent, c.session, c.app);
    }
    endQuestion(c, save || goOn);
}

}  // namespace

void drawQuestions(const UiContext& c)
{
    openQuestions(c);
    drawQuitQuestion(c);
    drawActionQuestion(c);
}

}  // namespace app

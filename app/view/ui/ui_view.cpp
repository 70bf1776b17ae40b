// Section of the panel: how the picture is looked at, and how the window behaves.
#include <cstring>
#include <initializer_list>

#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

constexpr FieldUnit kUnits[] = {{"exposure", "stops"},
                                {"frame-limit", "per second"},
                                {"moving-rate", "per second"},
                                {"moving-depth", "events"}};

bool among(const core::Field& field, std::initializer_list<const char*> names)
{
    for (const char* name : names) {
        if (std::strcmp(field.name, name) == 0) return true;
    }
    return false;
}

void group(const char* title)
{
    ImGui::Spacing();
    dimText(title);
}

/// The choice among the method's maps, and what the chosen one means.
void editMethodMap(const UiContext& c, ViewParams& view)
{
    const auto maps = core::methodNamed(c.session.render.method.id()).maps;
    if (maps.empty()) return;
    const size_t now = std::min(size_t(view.methodMap), maps.size() - 1);
    if (ImGui::BeginCombo("method map", maps[now].name)) {
        for (size_t i = 0; i < maps.size(); ++i)
            if (ImGui::Selectable(maps[i].name, i == now)) view.methodMap = uint32_t(i);
        ImGui::EndCombo();
    }
    dimText(maps[now].help);
}

}  // namespace

void drawViewSection(const UiContext& c)
{
    ViewParams& view = c.session.settings.view;
    const FieldOptions options{.onCommandLine = false, .units = kUnits};
    const auto some = [&](std::initializer_list<const char*> names) {
        editParams(view, options, [&](const core::Field& field) { return among(field, names); });
    };
    const Show before = view.show;
    some({"show", "exposure"});
    rowLabel("expose for", "what is on show");
    actionButton(c, "The picture", "expose", c.session.picture() ? "" : "there is no picture yet");
    some({"tone"});
    if (view.show != before) c.session.comparing = false;  // as the keys of views do
    if (view.show == Show::methodMap) editMethodMap(c, view);
    if (!c.frame.problem.empty()) {
        ImGui::PushStyleColor(ImGuiCol_Text, kWarningColour);
        ImGui::TextWrapped("%s", c.frame.problem.c_str());
        ImGui::PopStyleColor();
    }
    group("Maps and errors");
    some({"map", "error-kind", "error-range"});
    group("Resolution and motion");
    some(
        {"picture-scale", "moving", "moving-detail", "moving-rate", "moving-depth", "frame-limit"});
    group("Mouse");
    some({"wheel", "walls"});
    group("Window");
    editParams(c.session.settings.panels, options, [](const core::Field& field) {
        return among(field, {"panel-side", "ui-scale", "opacity"});  // others have buttons
    });
}

}  // namespace app

// Sections of the panel: method, device and parameters; when a picture is done.
#include <algorithm>

#include "app/pictures/error_text.h"
#include "app/view/ui/ui_parts.h"
#include "core/methods/method.h"

namespace app {
namespace {

/// A choice that says why it cannot be made, when so.
bool choice(const char* name, bool chosen, const std::string& help, const std::string& whyNot)
{
    const bool clicked = ImGui::Selectable(
        name, chosen, whyNot.empty() ? ImGuiSelectableFlags_None : ImGuiSelectableFlags_Disabled);
    tip(whyNot.empty() ? help : help + (help.empty() ? "" : "\n\n") + "Not now: " + whyNot);
    return clicked;
}

/// As much of it as has room in a list's box.
std::string deviceName(const UiContext& c, const RenderParams& render)
{
    const auto fitting = [](const char* whole, const char* brief) {
        const float room =
            ImGui::CalcItemWidth() - ImGui::GetFrameHeight() - 2 * ImGui::GetStyle().FramePadding.x;
        return ImGui::CalcTextSize(whole).x < room ? whole : brief;
    };
    if (render.device == DeviceKind::cpu) return fitting("CPU (Embree)", "CPU");
    if (render.deviceIndex < 0) return fitting("Vulkan, first suitable", "Vulkan");
    const auto index = static_cast<size_t>(render.deviceIndex);
    if (index < c.frame.devices.size()) return c.frame.devices[index].name;
    return "Vulkan device " + std::to_string(index);
}

bool vulkanChoice(const UiContext& c, size_t i, RenderParams& params)
{
    const gpu::DeviceInfo& info = c.frame.devices[i];
    std::string missing = whyNot(params.method.id(), DeviceKind::vulkan);
    for (const std::string& what : info.missing)
        missing += (missing.empty() ? "it lacks " : ", ") + what;
    const bool chosen =
        params.device == DeviceKind::vulkan && params.deviceIndex == static_cast<int>(i);
    const std::string help =
        info.type + ", " + info.driver + "\n" + bytesText(info.heapBytes) + " of device memory";
    ImGui::PushID(static_cast<int>(i));
    const bool clicked = choice(info.name.c_str(), chosen, help, missing);
    ImGui::PopID();
    if (!clicked) return false;
    params.device = DeviceKind::vulkan;
    params.deviceIndex = static_cast<int>(i);
    return true;
}

/// The name of the preset that the parameters equal; empty when there is none.
std::string presentPreset(const Session& session)
{
    for (const Preset& preset : session.settings.presets)
        if (preset.params == session.render.method) return preset.name;
    for (const core::MethodPreset& preset : core::methodNamed(session.render.method.id()).presets)
        if (preset.params == session.render.method) return preset.name;
    return {};
}

/// Presets of the method: those that come with it, then the user's own. Returns the index of one's
/// own preset that is to be removed, or -1.
int presetChoices(const UiContext& c, const std::string& now)
{
    int removed = -1;
    const std::string_view method = c.session.render.method.id();
    for (const core::MethodPreset& preset : core::methodNamed(method).presets) {
        if (ImGui::Selectable(preset.name, preset.name == now))
            c.act("preset", {{"name", preset.name}});
        tip(preset.help);
    }
    const std::vector<Preset>& own = c.session.settings.presets;
    bool separated = false;
    for (size_t i = 0; i < own.size(); ++i) {
        if (own[i].params.id() != method) continue;
        if (!separated) ImGui::Separator();
        separated = true;
        ImGui::PushID(static_cast<int>(i));
        const float cross = ImGui::GetFrameHeight();
        if (ImGui::Selectable(own[i].name.c_str(), own[i].name == now,
                              ImGuiSelectableFlags_AllowItemOverlap)) {
            c.act("preset", {{"name", own[i].name}});
        }
        ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - cross);
        if (ImGui::SmallButton("x")) removed = static_cast<int>(i);
        tip("delete this preset");
        ImGui::PopID();
    }
    return removed;
}

void savePreset(const UiContext& c)
{
    std::vector<Preset>& own = c.session.settings.presets;
    const auto same = std::find_if(own.begin(), own.end(), [&](const Preset& preset) {
        return preset.name == c.state.presetName &&
               preset.params.id() == c.session.render.method.id();
    });
    if (same != own.end())
        same->params = c.session.render.method;
    else
        own.push_back({c.state.presetName, c.session.render.method});
    c.state.presetName.clear();
}

void drawPresets(const UiContext& c)
{
    const std::string now = presentPreset(c.session);
    ImGui::PushID("presets");
    rowLabel("preset", "a named set of all parameters below; one's own can be added");
    if (ImGui::BeginCombo("##value", now.empty() ? "changed by hand" : now.c_str())) {
        const int removed = presetChoices(c, now);
        if (removed >= 0)
            c.session.settings.presets.erase(c.session.settings.presets.begin() + removed);
        ImGui::EndCombo();
    }
    ImGui::PopID();
}

void drawPresetName(const UiContext& c)
{
    ImGui::PushID("preset name");
    rowLabel("keep as", "a name for these parameters");
    ImGui::SetNextItemWidth(std::max(ImGui::GetContentRegionAvail().x - buttonWidth("Keep") -
                                         ImGui::GetStyle().ItemInnerSpacing.x,
                                     2 * c.em));
    const bool entered = textInput("##name", "name", c.state.presetName);
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    const std::string why = c.state.presetName.empty() ? "type a name first" : "";
    if (plainButton("Keep", "keep the parameters as a preset of this name", why) ||
        (entered && why.empty())) {
        savePreset(c);
    }
    ImGui::PopID();
}

/// A limit's bar; nothing without a limit.
void limitBar(double fraction, const std::string& text)
{
    ImGui::ProgressBar(static_cast<float>(std::clamp(fraction, 0.0, 1.0)),
                       ImVec2(-ImGui::GetFrameHeight(), ImGui::GetFontSize() * 0.95f),
                       text.c_str());
}

void limitRow(const char* label, const char* help, double& value, double most, const char* text)
{
    ImGui::PushID(label);
    rowLabel(label, help);
    auto shown = static_cast<float>(value);
    if (ImGui::InputFloat("##value", &shown, 0, 0, text) && shown >= 0) {
        value = std::min(static_cast<double>(shown), most);
    }
    tip(help);
    if (value == 0) zeroHint("no limit");
    if (rowReset(value != 0, "no limit")) value = 0;
    ImGui::PopID();
}

}  // namespace

std::string methodRow(const RenderParams& params)
{
    std::string chosen;
    ImGui::PushID("method");
    rowLabel("method", "how light is found");
    const std::string now(params.method.id());
    if (ImGui::BeginCombo("##value", now.c_str())) {
        for (const core::MethodInfo& method : core::methods()) {
            const std::string id(method.id());
            if (choice(id.c_str(), id == now, method.help, whyNot(id, params.device))) chosen = id;
        }
        ImGui::EndCombo();
    }
    ImGui::PopID();
    return chosen;
}

bool deviceRow(const UiContext& c, RenderParams& params)
{
    bool changed = false;
    ImGui::PushID("device");
    rowLabel("device", "where it is rendered");
    if (ImGui::BeginCombo("##value", deviceName(c, params).c_str())) {
        const auto one = [&](const char* name, DeviceKind kind, const char* help) {
            const bool chosen = params.device == kind && params.deviceIndex < 0;
            if (!choice(name, chosen, help, whyNot(params.method.id(), kind))) return;
            params.device = kind;
            params.deviceIndex = -1;
            changed = true;
        };
        one("CPU (Embree)", DeviceKind::cpu, "all cores");
        one("Vulkan, first suitable", DeviceKind::vulkan, "real GPUs before software");
        for (size_t i = 0; i < c.frame.devices.size(); ++i) changed |= vulkanChoice(c, i, params);
        ImGui::EndCombo();
    }
    ImGui::PopID();
    return changed;
}

void drawMethodSection(const UiContext& c)
{
    if (const std::string id = methodRow(c.session.render); !id.empty()) c.session.chooseMethod(id);
    deviceRow(c, c.session.render);
    drawPresets(c);
    ImGui::Spacing();
    editParams(c.session.render.method);
    ImGui::Spacing();
    drawPresetName(c);
}

void drawLimitsSection(const UiContext& c)
{
    RenderParams& render = c.session.render;
    const auto picture = shownPicture(c);
    ImGui::PushID("samples");
    const char* const help = "stops after so many samples per pixel; 0 never does";
    rowLabel("samples", help);
    countInput("##value", render.sppLimit, "no limit");
    tip(help);
    if (rowReset(render.sppLimit != 0, "no limit")) render.sppLimit = 0;
    ImGui::PopID();
    limitRow("seconds", "stops after so many seconds of rendering; 0 never does",
             render.secondsLimit, 1e7, "%.6g");
    limitRow("error",
             "stops at this RMSE: against the reference, or else as estimated from the samples; 0 "
             "never does",
             render.errorLimit, 1e6, "%.6g");
    if (!picture || picture->preview) return;
    if (render.sppLimit > 0) {
        limitBar(static_cast<double>(picture->samples) / static_cast<double>(render.sppLimit),
                 std::to_string(picture->samples) + " of " + std::to_string(render.sppLimit) +
                     " spp");
    }
    if (render.secondsLimit > 0) {
        limitBar(picture->seconds / render.secondsLimit,
                 secondsText(picture->seconds) + " of " + secondsText(render.secondsLimit));
    }
    if (render.errorLimit > 0 && !picture->curve.empty()) {
        const ErrorPoint& last = picture->curve.back();
        const double error = last.rmse > 0 ? last.rmse : last.estimated;
        const auto reference = c.session.reference();
        // Of the samples that the law of the root asks for.
        const double ratio = error > 0 ? render.errorLimit / error : 0;
        limitBar(ratio * ratio, errorText(last, reference ? reference->noise : 0) + "; limit " +
                                    digitsText(render.errorLimit));
    }
}

}  // namespace app

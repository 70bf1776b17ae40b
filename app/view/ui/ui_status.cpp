// Over the picture: the line that says how far it is, and the compare slider.
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/pictures/error_text.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

/// One thing that the status line says. What matters least is left out first where there is no
/// room.
struct StatusItem {
    std::string text, help;
    ImVec4 colour;
    int importance = 0;
};

ImVec4 textColour()
{
    return ImGui::GetStyleColorVec4(ImGuiCol_Text);
}
ImVec4 dimColour()
{
    return ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled);
}

/// Whether it is a part of the full picture's first sample, and not a small one.
bool isFirstSample(const Picture& picture)
{
    return picture.preview && picture.fraction > 0 && picture.mean.width == picture.fullSize.x;
}

StatusItem stateItem(const UiContext& c, const Picture* picture, const RenderThreadStatus& status)
{
    if (!status.error.empty()) return {"stopped", status.error, kErrorColour, 9};
    if (c.session.paused)
        return {"paused", "goes on with  [" + keyOf("pause") + "]", kWarningColour, 9};
    if (picture == nullptr) {
        return {status.stage.empty() ? "no picture" : status.stage, "no picture yet", dimColour(),
                9};
    }
    if (picture->preview && picture->fraction > 0) {
        return {
            format(isFirstSample(*picture) ? "first sample, %.0f %%" : "coarse picture, %.0f %%",
                   100 * picture->fraction),
            "the first sample of each pixel, or of every other one along a side where that "
            "takes more than a second; what has none yet shows the smaller picture before it",
            kWarningColour, 9};
    }
    if (picture->preview) {
        return {picture->shaded ? "preview, shaded" : "preview", previewMeans(*picture),
                kWarningColour, 9};
    }
    if (picture->finished) return {"done", "a limit is reached", kGoodColour, 9};
    if (status.rendering) return {"rendering", "samples are being taken", textColour(), 9};
    return {status.stage.empty() ? "waiting" : status.stage, "what the renderer does", dimColour(),
            9};
}

double luminanceOf(const UiContext& c, const std::shared_ptr<const Picture>& picture)
{
    KnownMean& known = c.state.mean;
    if (known.of.lock() != picture) known = {picture, meanLuminance(picture->mean)};
    return known.luminance;
}

void errorItem(const UiContext& c, const std::shared_ptr<const Picture>& picture,
               std::vector<StatusItem>& items)
{
    if (picture->curve.empty()) return;
    const auto reference = c.session.reference();
    const ErrorPoint& last = picture->curve.back();
    if (last.rmse > 0 && reference != nullptr) {
        std::string help = "root mean square error against the reference (" + reference->origin +
                           ") at " + std::to_string(last.samples) + " spp, with its standard error";
        const double noise = reference->noise;
        if (noiseShows(last.rmse, last.rmseSe, noise)) {
            help += "; the reference's own noise is " + digitsText(noise) +
                    " and part of it: the picture's error is less";
        }
        items.push_back({errorText(last, noise), help, textColour(), 7});
    } else if (last.estimated > 0) {
        const double mean = luminanceOf(c, picture);
        items.push_back({errorText(last, 0, mean),
                         "root of the mean variance, " + digitsText(last.estimated) +
                             ", in parts of the mean luminance, " + digitsText(mean) +
                             "; estimated from the samples' own spread at " +
                             std::to_string(last.samples) +
                             " spp; with the Sobol sampler an upper bound",
                         textColour(), 7});
    }
}

void counterItem(const core::FilmCounters& counters, std::vector<StatusItem>& items)
{
    if (counters.clean()) return;
    std::string text;
    const auto add = [&](uint64_t count, const char* name) {
        if (count > 0)
            text += (text.empty() ? "" : ", ") + countText(static_cast<double>(count)) + " " + name;
    };
    add(counters.nan, "NaN");
    add(counters.inf, "infinite");
    add(counters.negative, "negative");
    add(counters.stackOverflow, "rays cut short");
    items.push_back(
        {text,
         "samples that were dropped because they were no valid radiance, and rays that the device "
         "did not follow to their ends; there should be none",
         kErrorColour, 8});
}

void validationItem(const UiContext& c, std::vector<StatusItem>& items)
{
    const uint64_t count = c.frame.validationMessages.value_or(0);
    if (count == 0) return;
    items.push_back({countText(static_cast<double>(count)) + " validation",
                     "messages of the Vulkan validation layers in this run: they are on the "
                     "terminal; there should be none",
                     kErrorColour, 8});
}

std::vector<StatusItem> statusItems(const UiContext& c)
{
    const auto picture = shownPicture(c);
    const RenderThreadStatus status = c.session.rendering();
    std::vector<StatusItem> items{stateItem(c, picture.get(), status)};
    validationItem(c, items);
    if (!picture) return items;
    if (c.session.insideSolid()) {
        items.push_back({"inside a surface",
                         "the camera is inside something solid: wherever it looks it sees the back "
                         "of a surface  [" +
                             keyOf("previous-view") + ", " + keyOf("home") + "]",
                         kWarningColour, 9});
    } else if (picture->black) {
        items.push_back({"all black",
                         "no light comes from what the camera sees, if it sees anything  [" +
                             keyOf("previous-view") + ", " + keyOf("home") + "]",
                         kWarningColour, 9});
    }
    const ImVec4 text = textColour(), dim = dimColour();
    std::string samples = countText(static_cast<double>(picture->samples)) + " spp";
    if (!picture->preview && picture->fraction > 0)
        samples += format(", next %.0f %%", 100 * picture->fraction);
    // The strip of a coarse picture says how far it is; that it has no whole sample goes without.
    if (!picture->preview || picture->samples > 0)
        items.push_back({samples, "samples per pixel", text, 8});
    items.push_back({secondsText(picture->seconds), secondsMean(*picture), text, 5});
    errorItem(c, picture, items);
    for (const std::string& name : biases(picture->params)) {
        items.push_back({"biased: " + name,
                         "this parameter keeps the picture from converging to the right one",
                         kWarningColour, 8});
    }
    counterItem(picture->counters, items);
    if (picture->stats.rays > 0 && picture->seconds > 0) {
        const double rate = static_cast<double>(picture->stats.rays) / picture->seconds;
        items.push_back(
            {countText(rate) + " rays/s", "rays traced per second of rendering", dim, 3});
    }
    items.push_back({format("%u x %u", picture->fullSize.x, picture->fullSize.y),
                     "pixels of the full picture", dim, 2});
    items.push_back({std::string(picture->params.method.id()) + ", " + picture->stats.device,
                     paramsLabel(picture->params), dim, 1});
    return items;
}

/// Drops the least important items until the rest has room.
void fitItems(std::vector<StatusItem>& items, float room, float gap)
{
    const auto width = [&] {
        float sum = 0;
        for (const StatusItem& item : items) sum += ImGui::CalcTextSize(item.text.c_str()).x + gap;
        return sum;
    };
    while (items.size() > 1 && width() > room) {
        items.erase(std::min_element(
            items.begin(), items.end(),
            [](const StatusItem& a, const StatusItem& b) { return a.importance < b.importance; }));
    }
}

void drawSlotLabel(const UiContext& c, size_t side, float x)
{
    const Slot& slot = c.session.slots[side];
    std::string text =
        std::string(side == 0 ? "A: " : "B: ") + (slot.picture ? slot.label : "live");
    const float gap = 0.7f * c.em;
    const float room =
        side == 0 ? x - c.picture.corner.x - 2 * gap : c.picture.end().x - x - 2 * gap;
    if (ImGui::CalcTextSize(text.c_str()).x > room) text.resize(1);
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    if (size.x > room) return;
    ImVec2 place(side == 0 ? x - gap - size.x : x + gap, c.picture.end().y - 2.2f * c.em);
    const Area& plot = c.state.plot;
    const bool under = !plot.empty() && place.x < plot.end().x &&
                       place.x + size.x > plot.corner.x && place.y < plot.end().y &&
                       place.y + size.y > plot.corner.y;
    if (under) place.y = std::max(plot.corner.y - 2.2f * c.em, c.picture.corner.y);
    labelOnPicture(c, place, text);
}

}  // namespace

void drawStatusLine(const UiContext& c)
{
    const Area& place = c.frame.layout.status;
    ImGui::SetNextWindowPos(ImVec2(place.corner.x, place.corner.y));
    ImGui::SetNextWindowSize(ImVec2(place.size.x, place.size.y));
    ImGui::SetNextWindowBgAlpha(0);  // Gui's frames begin with that colour
    const float above = std::max(0.5f * (place.size.y - ImGui::GetFrameHeight()), 0.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0.7f * c.em, above));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.0f);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    if (ImGui::Begin("##status", nullptr, kOverlay)) {
        std::vector<StatusItem> items = statusItems(c);
        const float gap = 1.2f * c.em;
        if (c.frame.layout.panel.empty()) {
            actionButton(c, "Panel", "fold-panel");
            ImGui::SameLine(0, gap);
        }
        fitItems(items, ImGui::GetContentRegionAvail().x, gap);
        ImGui::AlignTextToFramePadding();
        for (size_t i = 0; i < items.size(); ++i) {
            if (i > 0) ImGui::SameLine(0, gap);
            ImGui::TextColored(items[i].colour, "%s", items[i].text.c_str());
            tip(items[i].help);
        }
    }
    ImGui::End();
    ImGui::PopStyleVar(4);
}

std::string previewMeans(const Picture& picture)
{
    return format("coarse, while the camera moves or until there is more of the full picture: "
                  "%u x %u pixels%s",
                  picture.mean.width, picture.mean.height,
                  picture.shaded ? ", lit from the camera" : "");
}

std::string secondsMean(const Picture& picture)
{
    return picture.preview && !isFirstSample(picture)
               ? "of rendering this small picture; the full one counts anew"
               : "of rendering, since this picture began";
}

std::string blackMeans(Show show, const core::World* world)
{
    if (show == Show::triangle || show == Show::material) return "; black: nothing hit";
    if (show != Show::emitter || world == nullptr) return {};
    // The sky and the sun are emitters, too, but no surface.
    const bool sky = world->environmentEmitter != shared::kNone,
               sun = world->sunEmitter != shared::kNone;
    if (world->emitters.empty()) return "; black: nothing emits light";
    if (world->emitters.size() > size_t(sky) + size_t(sun)) return "; black: no emitter";
    if (sky && sun) return "; black: only the sky and the sun shine";
    return sky ? "; black: only the sky shines" : "; black: only the sun shines";
}

void drawCaption(const UiContext& c)
{
    c.state.caption = {c.picture.corner.x, c.picture.corner.y};
    const auto picture = shownPicture(c);
    const Session& session = c.session;
    const ViewParams& view = session.settings.view;
    std::string text;
    if (session.holdReference && session.reference()) {
        const Reference& reference = *session.reference();
        text = "reference: " + reference.origin;
        if (reference.samples > 0) text += ", " + std::to_string(reference.samples) + " spp";
    } else if (picture && !session.comparing && view.show != Show::color &&
               c.frame.problem.empty()) {
        const auto maps = core::methodNamed(picture->params.method.id()).maps;
        text = view.show == Show::methodMap && !maps.empty()
                   ? maps[std::min(size_t(view.methodMap), maps.size() - 1)].name
                   : std::string(captionOf(view.show)) +
                         blackMeans(view.show, picture->world.lock().get());
        const std::string back = "  [" + keyOf("show-color") + ": the picture]";
        const float room = c.picture.size.x - 2.1f * c.em;
        if (ImGui::CalcTextSize((text + back).c_str()).x <= room) text += back;
    }
    if (text.empty()) return;
    const float gap = 0.7f * c.em;
    text = shortenedLabel(std::move(text), c.picture.size.x - 3 * gap);
    const ImVec2 place(c.picture.corner.x + 1.5f * gap, c.picture.corner.y + gap);
    labelOnPicture(c, place, text);
    c.state.caption = {place.x + ImGui::CalcTextSize(text.c_str()).x + gap,
                       place.y + ImGui::GetTextLineHeight()};
}

void drawCompareSlider(const UiContext& c)
{
    if (!c.session.comparing || c.session.holdReference || !shownPicture(c)) return;
    float& at = c.session.settings.view.compareAt;
    const float x = c.picture.corner.x + at * c.picture.size.x, reach = 0.6f * c.em;
    drawSlotLabel(c, 0, x);
    drawSlotLabel(c, 1, x);
    ImGui::SetNextWindowPos(ImVec2(x - reach, c.picture.corner.y));
    ImGui::SetNextWindowSize(ImVec2(2 * reach, c.picture.size.y));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
    ImGui::PushStyleVar(ImGuiStyleVar_WindowMinSize, ImVec2(1, 1));
    if (ImGui::Begin("##slider", nullptr, kOverlay | ImGuiWindowFlags_NoBackground)) {
        ImGui::InvisibleButton("##line", ImGui::GetWindowSize());
        const bool held = ImGui::IsItemActive();
        if (held)
            at = std::clamp((ImGui::GetIO().MousePos.x - c.picture.corner.x) / c.picture.size.x,
                            0.0f, 1.0f);
        if (held || ImGui::IsItemHovered()) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
        const ImVec2 grip(x, c.picture.corner.y + c.picture.size.y / 2);
        ImDrawList& list = *ImGui::GetWindowDrawList();
        list.PushClipRectFullScreen();
        list.AddCircleFilled(grip, 0.75f * c.em, IM_COL32(20, 22, 26, 200));
        list.AddCircle(grip, 0.75f * c.em, IM_COL32(240, 240, 240, 255), 0, 1.5f);
        const float s = 0.22f * c.em;
        list.AddTriangleFilled({grip.x - s, grip.y - s}, {grip.x - s, grip.y + s},
                               {grip.x - 2.2f * s, grip.y}, IM_COL32(240, 240, 240, 255));
        list.AddTriangleFilled({grip.x + s, grip.y - s}, {grip.x + s, grip.y + s},
                               {grip.x + 2.2f * s, grip.y}, IM_COL32(240, 240, 240, 255));
        list.PopClipRect();
    }
    ImGui::End();
    ImGui::PopStyleVar(2);
}

}  // namespace app

// Windows over the picture: error over time, and where time and memory go.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <unistd.h>

#include "app/view/ui/plot.h"
#include "app/view/ui/ui_parts.h"

namespace app {
namespace {

// In letters: in a narrower window the plot would cover a third of the picture.
constexpr float kRoomForPlot = 58;

PlotCurve plotCurve(const Curve& curve, bool against, ImVec4 colour, bool bold)
{
    PlotCurve plot{curve.label, {}, colour, bold};
    for (const ErrorPoint& p : curve.points) {
        if (against)
            plot.points.push_back({p.seconds, p.rmse, p.rmseSe});
        else
            plot.points.push_back({p.seconds, p.estimated, 0});
    }
    return plot;
}

/// Colours of past curves: told apart in hue and kept behind the present one, which is in the
/// style's accent.
ImVec4 pastColour(size_t index)
{
    const float hue = std::fmod(0.39f + 0.31f * static_cast<float>(index), 1.0f);
    ImVec4 colour{0, 0, 0, 0.75f};
    ImGui::ColorConvertHSVtoRGB(hue, 0.45f, 0.85f, colour.x, colour.y, colour.z);
    return colour;
}

double targetError(const UiContext& c)
{
    return c.session.render.errorLimit > 0 ? c.session.render.errorLimit : c.state.targetError;
}

std::string etaText(const Curve& curve, double target, double noise)
{
    const auto eta = etaToError(curve.points, curve.against, target, curve.against ? noise : 0);
    if (!eta) {
        if (curve.against && noise > 0 && target <= noise)
            return "below the reference's noise: never";
        return digitsText(target) + ": unknown as yet";
    }
    if (eta->seconds <= 0) return digitsText(target) + ": reached";
    std::string text = digitsText(target) + " in " + secondsText(eta->seconds);
    if (eta->low < eta->seconds)
        text += " (" + secondsText(eta->low) + " to " + secondsText(eta->high) + ")";
    return text;
}

/// What tells past curves apart: when their first points were measured, to the bit.
double curveNumber(const Curve& curve)
{
    return curve.points.empty() ? 0 : curve.points.front().seconds;
}

LogPlot convergencePlot(const UiContext& c)
{
    const Convergence& convergence = c.session.convergence();
    std::vector<double> numbers;
    for (const Curve& past : convergence.past()) numbers.push_back(curveNumber(past));
    c.state.colours.keep(numbers);
    const Curve& present = convergence.present();
    LogPlot plot;
    plot.xLabel = "seconds";
    plot.yLabel = present.against ? "RMSE" : "estimated error";
    for (const Curve& past : convergence.past()) {
        if (past.against != present.against) continue;  // another quantity
        const ImVec4 colour = pastColour(c.state.colours.of(curveNumber(past)));
        plot.curves.push_back(plotCurve(past, present.against, colour, false));
    }
    plot.curves.push_back(
        plotCurve(present, present.against, ImGui::GetStyleColorVec4(ImGuiCol_CheckMark), true));
    plot.guideSlope = -0.5;
    const auto reference = c.session.reference();
    if (present.against && reference) plot.floor = reference->noise;
    if (plot.floor > 0) plot.floorLabel = "noise of the reference, part of the RMSE";
    plot.target = targetError(c);
    if (plot.target > 0) plot.targetLabel = etaText(present, plot.target, plot.floor);
    return plot;
}

void drawFit(const Curve& curve)
{
    const auto fit = fitCurve(curve.points, curve.against);
    if (!fit) {
        ImGui::AlignTextToFramePadding();
        dimText("slope: not yet");
        return;
    }
    ImGui::AlignTextToFramePadding();
    ImGui::Text("slope %.2f \xC2\xB1 %.2f", fit->slope, fit->slopeSe);
    tip("Of the last points, on logarithmic axes; -0.5 (dashed) is what independent samples give. "
        "Steeper: the sampler "
        "does better than chance; flatter: rare bright samples, a bias, or the reference's own "
        "noise.");
}

void drawTarget(const UiContext& c)
{
    ImGui::SameLine();
    auto target = static_cast<float>(targetError(c));
    const bool limited = c.session.render.errorLimit > 0;
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted("  target");
    ImGui::SameLine();
    ImGui::SetNextItemWidth(5 * c.em);
    if (ImGui::InputFloat("##target", &target, 0, 0, "%.4g") && target >= 0 &&
        std::isfinite(target)) {
        (limited ? c.session.render.errorLimit : c.state.targetError) = static_cast<double>(target);
    }
    tip(limited ? "the limit of the error: the picture stops there"
                : "an error to reach: the plot tells how long it takes");
    sameLineIfRoom(buttonWidth("Clear"));
    actionButton(c, "Clear", "clear-curves",
                 c.session.convergence().past().empty() ? "there are no earlier curves" : "");
}

uint64_t residentBytes()
{
    std::ifstream file("/proc/self/statm");
    uint64_t total = 0, resident = 0;
    file >> total >> resident;
    return resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
}

void figure(const char* name, const std::string& value, const char* help)
{
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    dimText(name);
    tip(help);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(value.c_str());
    tip(help);
}

void pictureFigures(const Picture& picture)
{
    const core::RenderStats& s = picture.stats;
    const double rate = picture.seconds > 0 ? static_cast<double>(s.rays) / picture.seconds : 0;
    figure("rays", countText(static_cast<double>(s.rays)) + ", " + countText(rate) + " /s",
           "of this picture");
    figure("paths", countText(static_cast<double>(s.paths)), "of this picture");
    for (const core::StatsDetail& detail : s.details) {
        const std::string* word = std::get_if<std::string>(&detail.value);
        const double* number = std::get_if<double>(&detail.value);
        figure(detail.name.c_str(), word != nullptr ? *word : digitsText(*number),
               "of this method");
    }
    figure("build", secondsText(s.buildSeconds) + (s.hierarchyCached ? ", from a file" : ""),
           "the tree of boxes through which rays find triangles");
    figure("compile", secondsText(s.compileSeconds), "kernels specialised on the scene");
    figure("read back", secondsText(s.readbackSeconds), "from the device to where it can be shown");
    figure("device memory", bytesText(s.peakDeviceBytes), "of the renderer, at its peak");
}

void threadFigures(const UiContext& c)
{
    const RenderThreadStatus status = c.session.rendering();
    figure("renderer", status.stage.empty() ? "-" : status.stage, "what it does now");
    figure("preview",
           secondsText(status.previewSeconds) +
               format(", scale %.2f", static_cast<double>(status.previewScale)),
           "the last one while the camera moved: from the order to the picture, and the scale of "
           "its sides");
    figure("last stop", secondsText(status.lastStopSeconds),
           "from an edit to the end of the work that it overtook");
    figure("input", secondsText(c.frame.inputSeconds),
           "from the last input to the first picture that shows it");
    figure("host memory", bytesText(residentBytes()), "of the whole program, resident");
    figure("window's memory", bytesText(c.frame.presentBytes),
           "device memory of the window's own device");
    figure("window's device", c.frame.presentDevice.empty() ? "-" : c.frame.presentDevice,
           "presents the picture");
    if (c.frame.validationMessages)
        figure("validation", std::to_string(*c.frame.validationMessages) + " messages",
               "of the Vulkan validation layers, warnings and errors of both devices");
}

}  // namespace

bool showsPlot(const UiContext& c)
{
    if (!c.session.settings.panels.plot || !whyNoPlot(c).empty()) return false;
    return c.state.plotAsked || c.window.x >= kRoomForPlot * c.em;
}

void togglePlot(const UiContext& c)
{
    if (const std::string why = whyNoPlot(c); !why.empty())
        return c.session.notices.tell(Severity::news, "the plot cannot be shown: " + why);
    const bool show = !showsPlot(c);
    c.session.settings.panels.plot = c.state.plotAsked = show;
}

std::string whyNoPlot(const UiContext& c)
{
    const bool room = c.picture.size.x >= 36 * c.em && c.picture.size.y >= 22 * c.em;
    return room ? "" : "the window is too small for it";
}

void drawPlotWindow(const UiContext& c)
{
    bool& open = c.session.settings.panels.plot;
    c.state.plot = {};
    if (!showsPlot(c)) return;
    const ImVec2 size(std::min(27 * c.em, std::max(20 * c.em, 0.42f * c.picture.size.x)),
                      std::min(17 * c.em, std::max(14 * c.em, 0.42f * c.picture.size.y)));
    if (beginFloating(c, "Error over time###plot", &open, size, ImVec2(1, 1))) {
        const Convergence& convergence = c.session.convergence();
        drawFit(convergence.present());
        drawTarget(c);
        drawLogPlot("##plot", convergencePlot(c), ImGui::GetContentRegionAvail());
    }
    const ImVec2 corner = ImGui::GetWindowPos(), extent = ImGui::GetWindowSize();
    c.state.plot = {{corner.x, corner.y}, {extent.x, extent.y}};
    ImGui::End();
}

void drawProfilerWindow(const UiContext& c)
{
    bool& open = c.session.settings.panels.profiler;
    if (!open) return;
    if (beginFloating(c, "Profiler###profiler", &open, ImVec2(24 * c.em, 26 * c.em),
                      ImVec2(1, 0))) {
        const double budget =
            1 / static_cast<double>(std::max(c.session.settings.view.frameLimit, 1.0f));
        drawFrameTimes("##frames", c.frame.frameTimes, budget,
                       ImVec2(ImGui::GetContentRegionAvail().x, 4 * c.em));
        if (ImGui::BeginTable("##figures", 2)) {
            ImGui::TableSetupColumn("##name", ImGuiTableColumnFlags_WidthFixed, 9 * c.em);
            ImGui::TableSetupColumn("##value", ImGuiTableColumnFlags_WidthStretch);
            const std::string frames = secondsText(quantile(c.frame.frameTimes, 0.5)) + ", p99 " +
                                       secondsText(quantile(c.frame.frameTimes, 0.99));
            figure("frame", frames, "of the window: median and 99th percentile of the last ones");
            if (const auto picture = shownPicture(c)) pictureFigures(*picture);
            threadFigures(c);
            ImGui::EndTable();
        }
    }
    ImGui::End();
}

}  // namespace app

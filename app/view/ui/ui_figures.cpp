// Windows over the picture: error over time, and where time and memory go.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

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

/// What the host holds of the program in memory, in bytes.
struct HostMemory {
    uint64_t own = 0, files = 0;
};

/// From Linux's own account of the process; zeros elsewhere.
HostMemory hostMemory()
{
    HostMemory memory;
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string name;
        uint64_t kibibytes = 0;
        words >> name >> kibibytes;
        if (name == "RssAnon:") memory.own = kibibytes * 1024;
        if (name == "RssFile:" || name == "RssShmem:") memory.files += kibibytes * 1024;
    }
    return memory;
}

/// What the render thread does, in words.
std::string stageText(const std::string& stage)
{
    if (stage == "render") return "taking samples";
    if (stage == "idle") return "nothing: waiting";
    return stage.empty() ? "-" : stage;
}

/// Of something that may not have happened yet.
std::string onceText(double seconds)
{
    return seconds > 0 ? secondsText(seconds) : "not yet";
}

void figure(const char* name, const std::string& value, const char* help)
{
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    dimText(name);
    tip(help);
    ImGui::TableNextColumn();
    wrappedText(value);
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
        std::string name = detail.name;
        std::ranges::replace(name, '_', ' ');
        figure(name.c_str(), word != nullptr ? *word : digitsText(*number), "of this method");
    }
    figure("hierarchy", secondsText(s.buildSeconds) + (s.hierarchyCached ? ", from a file" : ""),
           "building the tree of boxes through which rays find triangles");
    figure("kernels", secondsText(s.compileSeconds),
           "compiling the device's programs, which are made for the scene");
    figure("fetching", secondsText(s.readbackSeconds),
           "pictures, from the device to where they can be shown");
}

void deviceFigure(const core::RenderStats& stats)
{
    figure("device", stats.peakDeviceBytes > 0 ? bytesText(stats.peakDeviceBytes) : "none",
           "memory of the renderer's device, at its peak: the scene, its hierarchy, the picture's "
           "samples; a software device has it within the program's");
}

void memoryFigures(const UiContext& c)
{
    const HostMemory memory = hostMemory();
    figure("program", bytesText(memory.own + memory.files),
           "all memory that the program holds on the host now");
    figure("  its data", bytesText(memory.own),
           "the scene, hierarchies, pictures; with a software device also the device's memory and "
           "its compiler");
    figure("  libraries", bytesText(memory.files),
           "the program's own code, its libraries and drivers, files that are mapped");
    figure("window", bytesText(c.frame.presentBytes),
           "memory of the window's own device: the picture on show, letters");
}

void threadFigures(const UiContext& c)
{
    const RenderThreadStatus status = c.session.rendering();
    figure("now", stageText(status.stage), "what the renderer does");
    figure(
        "in motion",
        status.movingSeconds > 0 ? secondsText(status.movingSeconds) +
                                       format(", light %.0f %%, surfaces %.0f %%",
                                              100 * static_cast<double>(status.movingScale),
                                              100 * static_cast<double>(status.movingSurfaceScale))
                                 : "not yet",
        "the last picture while the camera moved: from the order to the picture, and of how much "
        "of the sides its light was sampled and its surfaces were");
    figure("stopping", onceText(status.lastStopSeconds),
           "from an edit to the end of the work that it overtook");
    figure("answer", onceText(c.frame.inputSeconds),
           "from the last input to the first picture that shows it");
    figure("shown by", c.frame.presentDevice.empty() ? "-" : c.frame.presentDevice,
           "the device that presents the window");
    if (c.frame.validationMessages)
        figure("validation", std::to_string(*c.frame.validationMessages) + " messages",
               "of the Vulkan validation layers, warnings and errors of both devices");
}

/// A line across the table that says what comes.
void figureGroup(const char* title)
{
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::Spacing();
    ImGui::TextUnformatted(title);
}

void allFigures(const UiContext& c)
{
    figureGroup("Times");
    figure("frame",
           secondsText(quantile(c.frame.frameTimes, 0.5)) + ", slowest " +
               secondsText(quantile(c.frame.frameTimes, 0.99)),
           "of the window: half of the last ones were quicker, and all but one in a hundred than "
           "the slowest");
    threadFigures(c);
    const auto picture = shownPicture(c);
    if (picture) {
        figureGroup("Picture");
        pictureFigures(*picture);
    }
    figureGroup("Memory");
    if (picture) deviceFigure(picture->stats);
    memoryFigures(c);
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
    if (beginFloating(c, "Times and memory###profiler", &open, ImVec2(25 * c.em, 38 * c.em),
                      ImVec2(1, 0))) {
        const double budget =
            1 / static_cast<double>(std::max(c.session.settings.view.frameLimit, 1.0f));
        drawFrameTimes("##frames", c.frame.frameTimes, budget,
                       ImVec2(ImGui::GetContentRegionAvail().x, 4 * c.em));
        if (ImGui::BeginTable("##figures", 2)) {
            ImGui::TableSetupColumn("##name", ImGuiTableColumnFlags_WidthFixed, 9 * c.em);
            ImGui::TableSetupColumn("##value", ImGuiTableColumnFlags_WidthStretch);
            allFigures(c);
            ImGui::EndTable();
        }
    }
    ImGui::End();
}

}  // namespace app

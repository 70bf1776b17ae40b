// See render_words.h.
#include "app/commands/render_words.h"

#include <algorithm>
#include <cstdio>

#include "app/files/load.h"

namespace app {

namespace {

constexpr double kEndless = 1e30;  // seconds

/// "at most 0.01" where the spread of the samples tells no more.
std::string noiseText(const RenderReport& report, const char* pattern, double noise)
{
    const bool isBound = noiseIsBound(report.options->params);
    return (isBound ? "at most " : "") + printedNumber(pattern, noise);
}

}  // namespace

std::string printedNumber(const char* pattern, double value)
{
    char text[64];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

std::string progressText(const RenderReport& report, const Goal& goal, const Outcome& soFar)
{
    const RenderOptions& o = *report.options;
    const double done = static_cast<double>(soFar.samples), wanted = static_cast<double>(goal.spp);
    const double seconds = soFar.seconds;
    const double rate = done * report.size.x * report.size.y / std::max(seconds, 1e-9);
    std::string text = "render: ";
    if (o.frames)
        text += "frame " + std::to_string(o.frames->first + report.frames.size()) + " of " +
                std::to_string(o.frames->first) + '-' + std::to_string(o.frames->last) + ", ";
    text += std::to_string(soFar.samples) +
            (goal.spp < kMaxSpp ? " of " + std::to_string(goal.spp) : "") + " spp, " +
            printedNumber("%.1f s, ", seconds) + printedNumber("%.2f M samples/s", rate * 1e-6);
    if (soFar.rmse) text += printedNumber(", RMSE %.3g", *soFar.rmse);
    if (soFar.noise) text += ", noise " + noiseText(report, "%.3g", *soFar.noise);
    double left = goal.spp < kMaxSpp ? seconds * (wanted - done) / std::max(done, 1.0) : kEndless;
    if (goal.seconds > 0) left = std::min(left, goal.seconds - seconds);
    if (left < kEndless) text += printedNumber(", %.0f s left", std::max(left, 0.0));
    return text;
}

std::string savedText(const RenderReport& report, const std::filesystem::path& file)
{
    const FrameReport& frame = report.frames.back();
    return file.string() + ": " + std::to_string(report.size.x) + 'x' +
           std::to_string(report.size.y) + ", " + std::to_string(frame.spp) + " spp in " +
           printedNumber("%.2f s", frame.seconds) + " on " + report.renderer.device +
           (report.rmse ? printedNumber(", RMSE %.4g", *report.rmse) : "") +
           (report.noise ? ", noise " + noiseText(report, "%.4g", *report.noise) : "");
}

void MissedFrames::add(const RenderReport& report)
{
    // Too few samples to tell the noise is farther off than any noise. Only one picture has a
    // reference.
    const bool worse = !report.noise || (noise && *report.noise > *noise);
    if (count++ > 0 && !worse) return;
    worst = report.frames.back().index;
    rmse = report.rmse;
    noise = report.noise;
}

std::string missedText(const RenderReport& report, const MissedFrames& missed)
{
    const RenderOptions& o = *report.options;
    std::string text;
    if (o.frames) text = "frame " + std::to_string(missed.worst) + ": ";
    if (o.untilRmse)
        text += "RMSE " + printedNumber("%.4g", missed.rmse.value_or(0)) +
                " is above --until-rmse " + printedNumber("%.4g", *o.untilRmse);
    if (o.untilRmse && report.referenceNoise)
        text += printedNumber(" (the noise of the reference is %.4g)", *report.referenceNoise);
    if (o.untilRmse && o.untilNoise) text += ", ";
    if (o.untilNoise && missed.noise)
        text += "noise " + printedNumber("%.4g", *missed.noise) + " is above --until-noise " +
                printedNumber("%.4g", *o.untilNoise);
    else if (o.untilNoise)
        text += "there are too few samples to tell their noise";
    if (o.frames)
        text += "; " + std::to_string(missed.count) + " of " +
                std::to_string(report.frames.size()) + " frames missed it";
    return text;
}

std::string overBudgetText(const RenderReport& report)
{
    if (report.overBudget == 0) return {};
    return std::to_string(report.overBudget) + " of " + std::to_string(report.frames.size()) +
           " frames took more than " +
           (report.options->budgetMs ? "--budget-ms" : "--budget-rays") +
           " allows: one sample is the least";
}

std::vector<std::string> ToldWarnings::add(const core::Warnings& pose)
{
    constexpr size_t kPlaces = 10;
    const bool first = codes_.empty();
    core::Warnings fresh;
    for (const core::Warning& warning : pose.listed) {
        const std::set<std::string>& known = codes_[warning.code].places;
        if (known.size() < kPlaces && !known.contains(warning.pointer))
            fresh.add(warning.code, warning.pointer, warning.message);
    }
    for (const core::Warning& warning : pose.listed)
        codes_[warning.code].places.insert(warning.pointer);
    for (const core::Warnings::Count& count : pose.counts) {
        uint64_t& most = codes_[count.code].most;
        most = std::max(most, count.count);
    }
    return warningLines(first ? pose : fresh);
}

uint64_t ToldWarnings::total() const
{
    uint64_t sum = 0;
    for (const auto& [code, of] : codes_) sum += std::max<uint64_t>(of.places.size(), of.most);
    return sum;
}

std::string interruptedText(const RenderReport& report)
{
    const FrameReport& last = report.frames.back();
    const size_t before = report.frames.size() - 1;  // whole ones
    if (!report.options->frames)
        return last.spp > 0 ? "interrupted: what was rendered so far is saved"
                            : "interrupted before the first sample: nothing saved";
    if (last.spp == 0 && before == 0) return "interrupted before the first sample: nothing saved";
    std::string text = "interrupted: " + std::to_string(before) +
                       (before == 1 ? " whole frame is saved" : " whole frames are saved");
    if (last.spp > 0) text += ", and what was rendered of frame " + std::to_string(last.index);
    return text;
}

}  // namespace app

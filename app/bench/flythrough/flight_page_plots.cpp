// Curves of the page on flights. See flight_page_parts.h.
#include <algorithm>
#include <array>
#include <functional>

#include "app/base/read_value.h"
#include "app/bench/flythrough/flight_page_parts.h"
#include "app/report/text.h"

namespace app::flight {

namespace {

using namespace report;

constexpr double kWidth = 490, kHeight = 270;

/// What a row is worth in a plot: value and standard error.
using Value = std::function<Measured(const Row&)>;

/// A curve of one strategy.
struct Curve {
    std::string strategy;
    std::vector<Point> points;
    std::vector<double> errors;
};

Measured ratioOf(const Row& row)
{
    return row.ratio;
}

Measured trimmedOf(const Row& row)
{
    return row.trimmedRatio;
}

Value signedPercent(const SceneResult& scene)
{
    return [radiance = scene.radiance](const Row& row) {
        const Measured& e = row.errors.signedError;
        return Measured{100 * e.value / radiance, 100 * e.error / radiance};
    };
}

std::vector<Curve> curves(const Results& results, const SceneResult& scene, const Value& value,
                          const std::function<double(const Row&)>& place,
                          const std::function<bool(const Row&)>& wanted)
{
    std::vector<Curve> all;
    for (const std::string& strategy : results.strategies) {
        Curve curve{strategy, {}, {}};
        for (const Row& row : scene.rows) {
            if (row.strategy != strategy || !wanted(row)) continue;
            const Measured m = value(row);
            curve.points.push_back({place(row), m.value});
            curve.errors.push_back(std::isfinite(m.error) ? m.error : 0);
        }
        all.push_back(std::move(curve));
    }
    return all;
}

void draw(Plot& plot, const std::vector<Curve>& all)
{
    for (const Curve& curve : all) {
        const Look look = lookOf(curve.strategy);
        plot.curve(curve.points, look.style);
        plot.errorBars(curve.points, curve.errors, look.style);
        plot.markers(curve.points, look.shape, look.style);
        plot.legend({curve.strategy, look.style, true, true, false, look.shape});
    }
}

/// Least and greatest value with its bar; `start` are in it.
std::pair<double, double> extent(const std::vector<Curve>& all, double low, double high)
{
    for (const Curve& curve : all)
        for (size_t i = 0; i < curve.points.size(); ++i) {
            const double y = curve.points[i].y;
            if (!std::isfinite(y)) continue;
            low = std::min(low, y - curve.errors[i]);
            high = std::max(high, y + curve.errors[i]);
        }
    return {low, high};
}

std::vector<Tick> ticksAt(const std::vector<double>& values)
{
    std::vector<Tick> ticks;
    for (const double value : values) ticks.push_back({value, numberText(value)});
    return ticks;
}

Axis frameAxis(const Results& results)
{
    return logAxisAt("frame",
                     ticksAt(std::vector<double>(results.frames.begin(), results.frames.end())));
}

/// Ratios below nothing come from noise; the axis stays where it can be read.
Axis ratioAxis(const std::string& of, const std::vector<Curve>& all)
{
    double low = 0.5, high = 1;
    for (const Curve& curve : all)
        for (const Point& p : curve.points)
            if (std::isfinite(p.y) && p.y > 0) {
                low = std::min(low, p.y);
                high = std::max(high, p.y);
            }
    return logAxis(of + " / that of discard", std::max(low, 1e-4), high);
}

std::string figure(const Plot& plot)
{
    return "<figure>" + plot.element() + "</figure>\n";
}

std::string ratioPlot(const std::string& title, const std::string& of, const Axis& x,
                      const std::vector<Curve>& all)
{
    Plot plot(title, x, ratioAxis(of, all), kWidth, kHeight);
    draw(plot, all);
    return figure(plot);
}

std::string signedPlot(const std::string& title, const Axis& x, const std::vector<Curve>& all)
{
    const auto [low, high] = extent(all, -0.2, 0.2);
    Plot plot(title, x, linearAxis("mean signed error, % of the mean", low, high), kWidth, kHeight);
    plot.horizontal(0, "", "soft dashed");
    draw(plot, all);
    return figure(plot);
}

std::vector<double> stepsOf(const SceneResult& scene)
{
    std::vector<double> steps;
    for (const Row& row : scene.rows)
        if (std::ranges::find(steps, row.step) == steps.end()) steps.push_back(row.step);
    std::ranges::sort(steps);
    return steps;
}

/// Which rows stand along which axis.
struct Along {
    std::string words;  // of titles
    Axis axis;
    std::function<double(const Row&)> place;
    std::function<bool(const Row&)> wanted;
};

Along alongFrames(const Results& r, const SceneResult& scene, double step)
{
    return {"over frames, steps of " + stepText(scene, step), frameAxis(r),
            [](const Row& row) { return double(row.frame); },
            [step](const Row& row) { return row.step == step; }};
}

Along alongSteps(const Results& r, const SceneResult& scene)
{
    return {"over steps, frame " + std::to_string(r.longest()),
            logAxisAt("step, " + scene.unit, ticksAt(stepsOf(scene))),
            [](const Row& row) { return row.step; },
            [frame = r.longest()](const Row& row) { return row.frame == frame; }};
}

std::string relMsePlot(const Results& r, const SceneResult& scene, const Along& along)
{
    return ratioPlot("Error " + along.words, "relMSE", along.axis,
                     curves(r, scene, ratioOf, along.place, along.wanted));
}

std::string trimmedPlot(const Results& r, const SceneResult& scene, const Along& along)
{
    return ratioPlot("Error without fireflies, " + along.words, "trimmed relMSE", along.axis,
                     curves(r, scene, trimmedOf, along.place, along.wanted));
}

std::string biasPlot(const Results& r, const SceneResult& scene, const Along& along)
{
    return signedPlot("Signed error " + along.words, along.axis,
                      curves(r, scene, signedPercent(scene), along.place, along.wanted));
}

std::string pairs(const std::string& figures)
{
    return "<div class=\"pairoffigures\">\n" + figures + "</div>\n";
}

}  // namespace

Look lookOf(const std::string& strategy)
{
    constexpr std::array kColours{"c-grey", "c-orange", "c-pink", "c-green",
                                  "c-blue", "c-sky",    "c-red",  "c-yellow"};
    constexpr std::array kShapes{Shape::circle, Shape::square, Shape::triangle, Shape::diamond,
                                 Shape::circle, Shape::square, Shape::diamond};
    const auto names = core::enumNames<core::ReuseStrategy>();
    const auto at = static_cast<size_t>(std::ranges::find(names, strategy) - names.begin());
    return {std::string(kColours[at % kColours.size()]) + (at < kColours.size() ? "" : " dashed"),
            kShapes[at % kShapes.size()]};
}

std::string stepText(const SceneResult& scene, double step)
{
    return numberText(step) + ' ' + scene.unit;
}

std::string scenePlots(const Results& r, const SceneResult& scene)
{
    std::vector<Along> both{alongFrames(r, scene, scene.shownStep)};
    if (stepsOf(scene).size() > 1) both.push_back(alongSteps(r, scene));
    std::string figures;
    for (const auto plot : {relMsePlot, trimmedPlot, biasPlot})
        for (const Along& along : both) figures += plot(r, scene, along);
    return pairs(figures);
}

std::string morePlots(const Results& results, const SceneResult& scene)
{
    std::string figures;
    for (const double step : stepsOf(scene))
        if (step != scene.shownStep) {
            const Along along = alongFrames(results, scene, step);
            figures += relMsePlot(results, scene, along) + biasPlot(results, scene, along);
        }
    if (figures.empty()) return {};
    return "<details><summary>Over frames, for the other steps</summary>\n" + pairs(figures) +
           "</details>\n";
}

std::string sweepPlots(const Results& results)
{
    constexpr std::array kStyles{"c-sky", "c-blue"};
    constexpr std::array kShapes{Shape::square, Shape::circle};
    std::vector<std::string> parameters;
    std::vector<double> steps;
    for (const SweepPoint& p : results.sweeps) {
        if (std::ranges::find(parameters, p.parameter) == parameters.end())
            parameters.push_back(p.parameter);
        if (std::ranges::find(steps, p.step) == steps.end()) steps.push_back(p.step);
    }
    std::string figures;
    for (const std::string& parameter : parameters) {
        std::vector<double> values;
        std::vector<Curve> all(steps.size());
        double standard = kUnknown;
        for (const SweepPoint& p : results.sweeps) {
            if (p.parameter != parameter) continue;
            const auto i = static_cast<size_t>(std::ranges::find(steps, p.step) - steps.begin());
            if (std::ranges::find(values, p.value) == values.end()) values.push_back(p.value);
            if (p.standard) standard = p.value;
            // Zero has no place on this axis; it stands where half of the least value would.
            all[i].points.push_back({p.value, p.trimmedRatio.value});
            all[i].errors.push_back(std::isfinite(p.trimmedRatio.error) ? p.trimmedRatio.error : 0);
        }
        std::ranges::sort(values);
        std::vector<Tick> ticks = ticksAt(values);
        if (values.front() == 0 && values.size() > 1) {
            ticks.front().value = values[1] / 2;
            for (Curve& curve : all)
                for (Point& p : curve.points) p.x = std::max(p.x, ticks.front().value);
        }
        const auto [low, high] = extent(all, 1e9, -1e9);
        Plot plot(parameter, logAxisAt(parameter, ticks),
                  linearAxis("trimmed relMSE / that of discard", std::min(0.0, low), high), kWidth,
                  kHeight);
        if (std::isfinite(standard)) plot.vertical(standard, "as usual", "soft dashed");
        for (size_t i = 0; i < all.size(); ++i) {
            const std::string style = kStyles[i % kStyles.size()];
            const Shape shape = kShapes[i % kShapes.size()];
            plot.curve(all[i].points, style);
            plot.errorBars(all[i].points, all[i].errors, style);
            plot.markers(all[i].points, shape, style);
            plot.legend({"steps of " + stepText(results.scenes.front(), steps[i]), style, true,
                         true, false, shape});
        }
        figures += figure(plot);
    }
    return pairs(figures);
}

}  // namespace app::flight

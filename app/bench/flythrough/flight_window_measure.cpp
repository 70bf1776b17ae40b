// Flights in the window's own loop: every strategy, and fewer paths than pixels, at the same rates
// of pictures. Part of Measurement, see flight_measure.h.
#include <algorithm>
#include <memory>

#include "app/bench/bench_scenes.h"
#include "app/bench/flythrough/flight_measure.h"
#include "app/bench/flythrough/flight_window.h"
#include "app/pictures/fine_light.h"
#include "core/base/check.h"

namespace app::flight {

namespace {

constexpr double kDegreesPerSecond = 20;             // as seen from what the camera looks at
constexpr double kFramesPerSecond = 24;              // of a given path
constexpr double kSeconds = 2, kQuickSeconds = 1.2;  // of a flight
constexpr double kTargets[] = {0.033, 0.1};          // seconds from picture to picture
constexpr float kFewerPaths[] = {0.5f, 0.25f};
// Of the reference, whose pictures are larger than the others'. With 64 the staircase's had a third
// of the error that Discard has on show.
constexpr uint64_t kLeastSpp = 256, kLeastSppQuick = 64;

/// Of a picture that a flight ended with: in how many pixels its light was sampled and its
/// surfaces, and the guide to these.
struct Landed {
    glm::uvec2 size, fineSize;
    std::shared_ptr<const core::Image> guide;
};

/// All that is known of one crew at one rate.
struct WindowCell {
    ErrorSum errors, shown, underWay;
    std::vector<double> scales, fineScales, pictureSeconds, shares;
    std::vector<Landed> landed;

    /// `colours`: of the reference. Noise that is left in it counts as an error of all.
    WindowCell(const FlightReference& reference, const core::Image& colours,
               const core::Image& noVariance, uint32_t tileSide)
        : errors(reference.mean, reference.variance, tileSide),
          shown(colours, noVariance, tileSide), underWay(colours, noVariance, tileSide)
    {}

    void add(const WindowLanding& landing)
    {
        errors.add(landing.picture);
        shown.add(landing.colours);
        underWay.add(landing.underWay);
        scales.push_back(landing.scale);
        fineScales.push_back(landing.fineScale);
        pictureSeconds.push_back(landing.pictureSeconds());
        shares.push_back(landing.share);
        landed.push_back({landing.size, landing.fineSize, landing.guide});
    }
};

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double x : values) sum += x;
    return sum / static_cast<double>(values.size());
}

WindowRow rowOf(const Crew& crew, double target, const WindowCell& cell)
{
    // Without a history there is no pixel that could do with fewer than one.
    const bool remembers = crew.strategy != core::ReuseStrategy::discard;
    return {.strategy = std::string(core::enumName(crew.strategy)),
            .paths = static_cast<double>(remembers ? crew.rays : std::max(crew.rays, 1.0f)),
            .target = target,
            .pictureSeconds = mean(cell.pictureSeconds),
            .scale = mean(cell.scales),
            .fineScale = mean(cell.fineScales),
            .share = mean(cell.shares),
            .errors = cell.errors.errors(),
            .shown = cell.shown.errors().mse,
            .underWay = cell.underWay.errors().mse};
}

}  // namespace

std::vector<Crew> crewsOf(const std::vector<std::string>& strategies, float rays)
{
    using enum core::ReuseStrategy;
    std::vector<Crew> crews;
    // The others are of interest for theory, and not for a window.
    for (const core::ReuseStrategy strategy : {discard, naive, mis, ra, svgf}) {
        const bool measured =
            std::ranges::find(strategies, core::enumName(strategy)) != strategies.end();
        if (!measured) continue;
        crews.push_back({strategy, rays});
        if (strategy != ra) continue;
        for (const float fewer : kFewerPaths)
            if (fewer < rays) crews.push_back({strategy, fewer});
    }
    return crews;
}

/// A picture of the last view without noise: of a camera that rests, whose first hits lie anywhere
/// in the pixel, or of one that moves.
std::optional<FlightReference> Measurement::windowReference(size_t index, glm::uvec2 size,
                                                            bool rests)
{
    const uint64_t samples = std::max(o_.quick ? kLeastSppQuick : kLeastSpp, o_.referenceSpp / 8);
    core::ReuseParams params = results_.params.as<core::ReuseParams>();
    if (rests) params.jitter = core::PixelJitter::always;
    const std::filesystem::path file =
        referenceFile(o_.output, scene_.name + (rests ? "-window" : "-moving"), size,
                      std::to_string(samples) + "spp");
    const auto part = [this](double done) {
        char text[48];
        std::snprintf(text, sizeof text, "reference of the window, %.0f %%", 100 * done);
        tools_.progress(scene_.name + ": " + text);
    };
    return reference({file, {flight_->end(), size, params}, o_.scenes[index].at, samples},
                     pilot_.renderer(), *world_, part, tools_.stop);
}

/// Light of the last view on surfaces of that size, as the window puts it there.
core::Image Measurement::onSurfaces(const core::Image& light, glm::uvec2 size)
{
    const glm::uvec2 small(light.width, light.height);
    if (small == size) return light;
    core::Renderer& renderer = pilot_.renderer();
    const core::Camera end = flight_->end();
    renderer.setView({end, small, results_.params}, core::Start::anew);
    return lightOnSurfaces(light, {renderer.surfaces(end, small, core::Sight::clear), end},
                           {renderer.surfaces(end, size, core::Sight::clear), end});
}

void Measurement::measureWindow(size_t index)
{
    try {
        flyInWindow(index);
    } catch (const core::Error& error) {
        const core::ExitCode code = error.code();
        if (code == core::ExitCode::interrupted || code == core::ExitCode::deviceLost) throw;
        tools_.warn(scene_.name + ": no flights in the window's loop: " + error.what());
    }
}

void Measurement::flyInWindow(size_t index)
{
    const double seconds = o_.quick ? kQuickSeconds : kSeconds;
    const double wished = o_.path.empty() ? kDegreesPerSecond : kFramesPerSecond;
    const double speed = speedThatFits(*flight_, wished, seconds);
    if (speed == 0) {
        tools_.warn(scene_.name + ": no room for flights in the window's loop");
        return;
    }
    const std::optional<FlightReference> truth = windowReference(index, *o_.window, true);
    if (!truth) return;
    const std::vector<Crew> crews =
        crewsOf(results_.strategies, o_.params.as<core::ReuseParams>().rays);
    const CameraTrack track = lastSeconds(*flight_, speed, seconds),
                      warmUp = lastSeconds(*flight_, speed, 0.3);
    WindowPilot window(o_.scenes[index], {.device = o_.device, .deviceIndex = o_.deviceIndex},
                       *o_.window, tools_.stop);
    const core::Image colours = displayColours(truth->mean, nullptr, *o_.window),
                      noVariance(o_.window->x, o_.window->y, 3);
    const uint32_t tileSide = windowTileSide(o_.window->x, o_.window->y);
    std::vector<WindowRow> rows;
    for (const double target : kTargets) {
        std::vector<WindowCell> cells(crews.size(),
                                      WindowCell(*truth, colours, noVariance, tileSide));
        for (uint32_t seed = 0; seed < o_.seeds; ++seed)
            for (size_t i = 0; i < crews.size(); ++i) {
                tools_.progress(scene_.name + ": in the window's loop, " +
                                core::enumName(crews[i].strategy).data());
                core::ReuseParams params = o_.params.as<core::ReuseParams>();
                params.reuse = crews[i].strategy;
                params.rays = crews[i].rays;
                params.seed += flights_++;
                // How long a picture takes is learnt before.
                if (!window.fly(warmUp, params, target)) return;
                const std::optional<WindowLanding> landing = window.fly(track, params, target);
                if (!landing) return;
                cells[i].add(*landing);
            }
        for (size_t i = 0; i < crews.size(); ++i) {
            rows.push_back(rowOf(crews[i], target, cells[i]));
            const WindowRow& first = rows[rows.size() - 1 - i];
            ErrorSum bySize(colours, noVariance, tileSide);
            for (const Landed& landed : cells[i].landed) {
                const auto small = windowReference(index, landed.size, false);
                if (!small) return;
                const core::Image fine = onSurfaces(small->mean, landed.fineSize);
                bySize.add(displayColours(fine, landed.guide.get(), *o_.window));
            }
            rows.back().bySize = bySize.errors().mse;
            rows.back().bySizeRatio = quotient(rows.back().bySize, first.shown);
            rows.back().ratio = quotient(rows.back().errors.relMse, first.errors.relMse);
            rows.back().trimmedRatio = quotient(rows.back().errors.trimmed, first.errors.trimmed);
            rows.back().shownRatio = quotient(rows.back().shown, first.shown);
            rows.back().underWayRatio = quotient(rows.back().underWay, first.underWay);
        }
    }
    SceneResult& result = results_.scenes.back();
    result.windowSpeed = speed;
    result.windowSeconds = seconds;
    result.windowRadiance = truth->radiance;
    result.window = std::move(rows);
}

}  // namespace app::flight

// See flight_measure.h.
#include "app/bench/flythrough/flight_measure.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "app/base/program_version.h"
#include "app/base/read_value.h"
#include "app/bench/bench_clock.h"
#include "app/bench/bench_scenes.h"
#include "core/base/check.h"
#include "core/scene/moved_pieces.h"

namespace app::flight {

namespace {

constexpr uint32_t kAtRest[] = {1, 2, 4};  // n of Discard, to know its error after any time
const std::string kDiscard(core::enumName(core::ReuseStrategy::discard));

/// Frames after which flights are looked at: one, and each power of `factor` up to the longest.
std::vector<uint32_t> measuredFrames(uint32_t longest, uint32_t factor)
{
    std::vector<uint32_t> frames;
    for (uint64_t frame = 1; frame < longest; frame *= factor)
        frames.push_back(static_cast<uint32_t>(frame));
    frames.push_back(longest);
    return frames;
}

}  // namespace

Measurement::Measurement(const FlightBenchOptions& options, const BenchTools& tools)
    : o_(options), tools_(tools),
      pilot_({.device = options.device, .deviceIndex = options.deviceIndex})
{
    results_.version = kVersion;
    results_.commit = kCommit;
    results_.clock = pilot_.clock();
    core::ReuseParams params = options.params.as<core::ReuseParams>();
    // One place in the pixel for all frames and their reference: they measure the same picture.
    if (params.jitter == core::PixelJitter::settled) params.jitter = core::PixelJitter::never;
    results_.params = params;
    results_.rays = static_cast<double>(params.rays);
    results_.steps = options.steps;
    results_.frames = measuredFrames(options.frames, options.quick ? 4 : 2);
    results_.seeds = options.seeds;
    results_.referenceSpp = options.referenceSpp;
    results_.framesPerSecond = options.framesPerSecond;
    results_.windowSize = options.window.value_or(glm::uvec2(0));
    results_.quick = options.quick;
}

void Measurement::Cell::add(Landing landing)
{
    errors.add(landing.picture);
    seconds.push_back(landing.seconds);
    rays = landing.rays;
    if (first.pixels.empty()) first = std::move(landing.picture);
}

core::ReuseParams Measurement::paramsOf(const std::string& strategy) const
{
    core::ReuseParams params = results_.params.as<core::ReuseParams>();
    const std::string problem = readValue(strategy, {}, params.reuse);
    CHECK(problem.empty());
    return params;
}

std::optional<Landing> Measurement::fly(core::ReuseParams params, double step, uint32_t frames,
                                        uint32_t samples)
{
    params.seed += flights_++;
    return pilot_.fly(*flight_, {step, frames, samples, params}, tools_.stop);
}

/// The instant of the scene's animation, in seconds, at which all its flights end.
double Measurement::endsAt(size_t index) const
{
    const double at = o_.scenes[index].at;
    return o_.framesPerSecond > 0 ? at + (results_.longest() - 1) / o_.framesPerSecond : at;
}

/// Everything that can be refused before work begins.
void Measurement::load(size_t index)
{
    SceneOptions options = o_.scenes[index];
    options.at = endsAt(index);
    world_ = loadBenchScene(options, tools_);
    if (o_.framesPerSecond > 0 && !core::mayMove(*world_))
        tools_.warn(options.file.string() + ": nothing moves in this scene");
    const core::Camera camera = chooseCamera(*world_, o_.camera);
    scene_ = {};
    std::vector<std::string> taken;
    for (const SceneResult& before : results_.scenes) taken.push_back(before.name);
    scene_.name = sceneName(options.file, taken);
    scene_.file = options.file;
    scene_.triangles = core::shownTriangles(*world_);
    scene_.size = o_.size ? *o_.size : core::sizeForWidth(camera, o_.width);
    flight_ = o_.path.empty() ? Flight::around(world_, camera, scene_.size, o_.steps.back())
                              : Flight::along(readCameraPath(o_.path, camera, world_->placement));
    scene_.way = flight_->words();
    if (o_.framesPerSecond > 0)
        scene_.way += ", while the scene's animation runs, " + numberText(o_.framesPerSecond) +
                      " frames per second";
    scene_.unit = flight_->unit();
    chooseSteps();
    std::optional<Play> play;
    if (o_.framesPerSecond > 0) play = {options.at, o_.framesPerSecond};
    pilot_.setWorld(world_, tools_.loading, play);
    pilot_.setSize(scene_.size);
    discard_.clear();
    discardSeconds_.clear();
}

/// Those that the flight has room for; throws core::Error when it has none for any.
void Measurement::chooseSteps()
{
    steps_.clear();
    std::vector<std::string> refused;
    for (const double step : results_.steps) {
        const std::string why = flight_->whyNot(step, results_.longest());
        if (why.empty())
            steps_.push_back(step);
        else
            refused.push_back(scene_.file.string() + ": " + why);
    }
    if (steps_.empty()) throw core::Error(refused.front());
    for (const std::string& why : refused) tools_.warn(why);
    scene_.shownStep = steps_[steps_.size() / 2];
}

/// False: stopped.
bool Measurement::findReference(size_t index)
{
    const std::filesystem::path file =
        referenceFile(o_.output, scene_.name, scene_.size, std::to_string(o_.referenceSpp) + "spp");
    const ReferenceOrder order{
        file, {flight_->end(), scene_.size, results_.params}, endsAt(index), o_.referenceSpp};
    const auto part = [this](double done) {
        char text[32];
        std::snprintf(text, sizeof text, "reference, %.0f %%", 100 * done);
        tools_.progress(scene_.name + ": " + text);
    };
    reference_ = reference(order, pilot_.renderer(), *world_, part, tools_.stop);
    if (!reference_) return false;
    scene_.radiance = reference_->radiance;
    scene_.referenceSeconds = reference_->seconds;
    scene_.referenceKept = reference_->kept;
    scene_.referenceRelMse = noiseOf(reference_->mean, reference_->variance);
    const core::RenderStats stats = pilot_.renderer().stats();
    results_.device = stats.device;
    results_.driver = stats.driver;
    return true;
}

/// Flies each strategy for two frames: kernels are compiled before times are taken, and one that
/// cannot work here is left out, with the reason.
void Measurement::chooseStrategies()
{
    results_.strategies.clear();
    results_.leftOut.clear();
    for (const core::ReuseStrategy strategy : o_.strategies) {
        const std::string name(core::enumName(strategy));
        try {
            fly(paramsOf(name), o_.steps.front(), 2, 1);
            results_.strategies.push_back(name);
        } catch (const core::Error& error) {
            if (name == kDiscard || error.code() == core::ExitCode::deviceLost) throw;
            results_.leftOut.emplace_back(name, error.what());
            tools_.warn(name + " is left out: " + error.what());
        }
    }
}

/// One picture of Discard for each n, after a move.
bool Measurement::measureDiscard(double step, uint32_t frame, std::vector<double>& seconds)
{
    for (const uint32_t n : kAtRest) {
        if (n > 1 && frame != results_.longest()) continue;
        std::optional<Landing> landing = fly(paramsOf(kDiscard), step, std::min(frame, 2u), n);
        if (!landing) return false;
        if (n == 1) seconds.push_back(landing->seconds);
        discard_.try_emplace(n, *reference_).first->second.add(std::move(*landing));
    }
    return true;
}

/// All strategies in one place, seed by seed. False: stopped, and nothing was added.
bool Measurement::measureCell(double step, uint32_t frame)
{
    Cells cells;
    std::vector<double> discardSeconds;
    for (uint32_t seed = 0; seed < o_.seeds; ++seed) {
        if (!measureDiscard(step, frame, discardSeconds)) return false;
        for (const std::string& strategy : results_.strategies) {
            if (strategy == kDiscard) continue;
            std::optional<Landing> landing = fly(paramsOf(strategy), step, frame, 1);
            if (!landing) return false;
            cells.try_emplace(strategy, *reference_).first->second.add(std::move(*landing));
        }
    }
    discardSeconds_[{step, frame}] = median(discardSeconds);
    for (auto& [strategy, cell] : cells)
        scene_.rows.push_back({.strategy = strategy,
                               .step = step,
                               .distance = flight_->distance(step),
                               .frame = frame,
                               .rays = cell.rays,
                               .seconds = median(cell.seconds),
                               .errors = cell.errors.errors()});
    if (step == scene_.shownStep && frame == results_.longest()) takeShots(cells);
    return true;
}

void Measurement::measureScene(size_t index)
{
    load(index);
    if (!findReference(index)) return;
    if (index == 0) chooseStrategies();
    bool goesOn = true;
    size_t done = 0;
    for (const double step : steps_)
        for (const uint32_t frame : results_.frames) {
            tools_.progress(scene_.name + ": steps of " + numberText(step) + ", " +
                            std::to_string(frame) + " frames (" + std::to_string(++done) + " of " +
                            std::to_string(steps_.size() * results_.frames.size()) + ")");
            goesOn = goesOn && measureCell(step, frame);
        }
    finishScene();
}

/// What needs all of the scene: everything relative to Discard, and Discard's own rows.
void Measurement::finishScene()
{
    if (scene_.rows.empty() && discardSeconds_.empty()) return;
    for (const auto& [n, cell] : discard_)
        scene_.atRest.push_back({.strategy = kDiscard,
                                 .samples = n,
                                 .rays = cell.rays,
                                 .seconds = median(cell.seconds),
                                 .errors = cell.errors.errors()});
    const Row unit = scene_.atRest.front();
    std::vector<Row> rows;
    for (const auto& [place, seconds] : discardSeconds_) {
        rows.push_back(unit);
        rows.back().step = place.first;
        rows.back().frame = place.second;
        rows.back().distance = flight_->distance(place.first);
        rows.back().seconds = seconds;
    }
    rows.insert(rows.end(), scene_.rows.begin(), scene_.rows.end());
    for (std::vector<Row>* all : {&rows, &scene_.atRest})
        for (Row& row : *all) {
            const bool same = row.strategy == kDiscard && row.samples == 1;
            row.ratio = same ? Measured{1, 0} : quotient(row.errors.relMse, unit.errors.relMse);
            row.mseRatio = row.errors.mse.value / unit.errors.mse.value;
            row.trimmedRatio =
                same ? Measured{1, 0} : quotient(row.errors.trimmed, unit.errors.trimmed);
            row.timeRatio = row.trimmedTimeRatio = same ? 1 : kUnknown;
        }
    std::vector<Reached> plain, trimmed;
    for (const Row& row : scene_.atRest) {
        plain.push_back({row.seconds, row.errors.relMse.value});
        trimmed.push_back({row.seconds, row.errors.trimmed.value});
    }
    for (Row& row : rows) {
        if (row.strategy == kDiscard) continue;
        // In units of what Discard took in the same rounds.
        const double seconds =
            row.seconds * unit.seconds / discardSeconds_.at({row.step, row.frame});
        row.timeRatio = equalTimeRatio(plain, {seconds, row.errors.relMse.value});
        row.trimmedTimeRatio = equalTimeRatio(trimmed, {seconds, row.errors.trimmed.value});
    }
    scene_.rows = std::move(rows);
    results_.scenes.push_back(scene_);
}

double equalTimeRatio(const std::vector<Reached>& discard, const Reached& reached)
{
    const auto known = [](const Reached& r) { return r.seconds > 0 && r.error > 0; };
    if (discard.size() < 2 || !std::ranges::all_of(discard, known) || !(reached.seconds > 0))
        return kUnknown;
    size_t i = 0;
    while (i + 2 < discard.size() && discard[i + 1].seconds < reached.seconds) ++i;
    const Reached &a = discard[i], &b = discard[i + 1];
    const double slope = std::log(b.error / a.error) / std::log(b.seconds / a.seconds);
    const double ratio =
        reached.error / (a.error * std::exp(slope * std::log(reached.seconds / a.seconds)));
    return std::isfinite(ratio) ? ratio : kUnknown;
}

}  // namespace app::flight

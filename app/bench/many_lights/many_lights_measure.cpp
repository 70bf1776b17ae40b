// See many_lights_measure.h.
#include "app/bench/many_lights/many_lights_measure.h"

#include <algorithm>
#include <cmath>

#include "app/base/program_version.h"
#include "app/base/read_value.h"
#include "app/bench/bench_clock.h"
#include "app/bench/bench_scenes.h"
#include "app/bench/many_lights/many_lights_error.h"
#include "app/bench/many_lights/many_lights_rates.h"
#include "app/files/camera_file.h"
#include "core/base/check.h"

namespace app::many_lights {

namespace {

/// What a lit subset says of the whole frame; `receivers` of it.
Sample sampleOf(const Lit& lit, size_t receivers)
{
    const core::many_lights::SliceStats& s = lit.stats;
    const double whole = double(receivers) / double(std::max<uint64_t>(1, s.rows));
    Sample sample;
    sample.seconds = whole * lit.seconds;
    sample.wallSeconds = lit.wallSeconds;
    const double completion = s.completion.seconds;
    sample.threadSeconds =
        s.cutSeconds + s.orderSeconds + completion + s.shadingSeconds + s.lostSeconds;
    // Threads are timed by the clock on the wall, which other processes slow; what they tell is how
    // the time divides.
    const double scale = sample.threadSeconds > 0 ? sample.seconds / sample.threadSeconds : 0;
    sample.cut = scale * s.cutSeconds;
    sample.order = scale * s.orderSeconds;
    sample.tracing = scale * s.completion.traceSeconds;
    sample.matching = scale * (completion - s.completion.traceSeconds);
    sample.shading = scale * (s.shadingSeconds + s.lostSeconds);
    if (const uint64_t columns = s.completion.columns - s.completion.inactive; columns > 0)
        sample.columnOverhead = 1e6 * sample.matching * cores() / (whole * double(columns));
    sample.seconds += lit.beforeSeconds;
    sample.cut += lit.beforeSeconds;
    sample.rays = whole * double(s.completion.rays) + lit.beforeRays;
    sample.visibility = s.completion.visibility();
    sample.authorVisibility = s.completion.authorVisibility();
    return sample;
}

/// Landscapes of that width, portraits of that height.
glm::uvec2 sizeFor(const core::Camera& camera, uint32_t longest)
{
    const glm::uvec2 size = core::sizeForWidth(camera, longest);
    if (size.y <= size.x) return size;
    return core::sizeForWidth(camera, std::max(1u, longest * size.x / size.y));
}

uint32_t seedOf(uint32_t seed, uint32_t repetition)
{
    return repetition == 0 ? seed : shared::hashUint(seed + 0x9e3779b9u * repetition);
}

}  // namespace

Measurement::Measurement(const ManyLightsBenchOptions& options, const BenchTools& tools)
    : o_(options), tools_(tools), cases_(casesOf(options))
{
    results_.version = kVersion;
    results_.commit = kCommit;
    results_.params = options.params;
    results_.clusters = options.clusters;
    results_.mainClusters = options.mainClusters;
    results_.repetitions = options.repetitions;
    results_.cores = cores();
    results_.exposure = options.exposure;
    results_.quick = options.quick;
}

/// Everything that can be refused before work begins.
void Measurement::load(size_t index)
{
    const SceneOptions& options = o_.scenes[index];
    const auto world = loadBenchScene(options, tools_);
    const core::Camera camera = chooseCamera(*world, o_.camera);
    scene_ = {};
    std::vector<std::string> taken;
    for (const SceneResult& before : results_.scenes) taken.push_back(before.name);
    scene_.name = sceneName(options.file, taken);
    scene_.file = options.file;
    scene_.triangles = core::shownTriangles(*world);
    scene_.size = o_.size ? *o_.size : sizeFor(camera, o_.width);
    lit_ = std::make_unique<LitScene>(world, camera, scene_.size, o_.params, tools_.loading,
                                      tools_.stop);
}

/// Lights, receivers and the slices that stand for all; false: stopped.
bool Measurement::findSubset()
{
    tools_.progress(about("lights and receivers"));
    if (!lit_->findLights()) return false;
    uint32_t largest = o_.params.sliceSize;
    for (const Case& c : cases_) largest = std::max(largest, c.params.sliceSize);
    const auto coarse = lit_->points(largest), fine = lit_->points(o_.params.sliceSize);
    if (!coarse || !fine) return false;
    subset_ = randomSubset(*coarse, lit_->perPixel(), {o_.share, o_.receivers}, o_.params.seed);
    scene_.lights = lit_->lights()->set.lights.size();
    scene_.receivers = fine->receivers.size();
    scene_.litReceivers = subset_.receivers;
    scene_.pixels = subset_.pixels.size();
    scene_.slices = fine->slices.ranges.size();
    scene_.litSlices = size_t(std::ranges::count(slicesOf(*fine, subset_), uint8_t(1)));
    scene_.clampDistance = lit_->clampDistance();
    scene_.lightSeconds = lit_->lights()->lightSeconds;
    scene_.treeSeconds = lit_->lights()->treeSeconds;
    scene_.receiverSeconds = fine->seconds;
    return true;
}

std::filesystem::path Measurement::referenceFile(const std::string& part) const
{
    return app::referenceFile(o_.output, scene_.name, scene_.size,
                              numberText(double(o_.params.lights)) + part);
}

void Measurement::measureScene(size_t index)
{
    load(index);
    if (!findSubset()) return;
    tools_.progress(about("reference, all " + std::to_string(scene_.lights) + " lights for " +
                          std::to_string(scene_.litReceivers) + " of " +
                          std::to_string(scene_.receivers) + " receivers"));
    reference_ = lightsReference(*lit_, subset_, o_.scenes[index].at, referenceFile(""));
    if (!reference_) return;
    scene_.referenceSeconds = reference_->seconds;
    scene_.referenceKept = reference_->kept;
    scene_.clipped = clippedShare(reference_->values, o_.exposure);
    tools_.progress(about("raw rays"));
    if (const auto rates = measureRates(*lit_, subset_, o_.mainClusters)) scene_.rates = *rates;
    for (const Case& c : cases_)
        scene_.rows.push_back(
            {c.method->name, c.clusters, c.rowRate, c.params, c.method->packets, {}});
    pictures_.clear();
    bool whole = true;
    for (uint32_t r = 0; r < o_.repetitions && whole; ++r) whole = repeat(r);
    std::erase_if(scene_.rows, [](const Row& row) { return row.samples.empty(); });
    if (whole && o_.pictures) takeShots(index);
    if (!scene_.rows.empty()) results_.scenes.push_back(scene_);
    lit_.reset();
}

/// One turn of all cases, with a tree and random numbers of its own; false: stopped.
bool Measurement::repeat(uint32_t repetition)
{
    const auto lights = lit_->lightsOf(repetition);
    if (!lights) return false;
    std::vector<std::vector<glm::vec3>> pictures(cases_.size());
    std::vector<size_t> measured;
    bool whole = true;
    for (size_t i = 0; i < cases_.size() && whole; ++i) {
        const size_t at = repetition % 2 == 0 ? i : cases_.size() - 1 - i;
        const Case& c = cases_[at];
        tools_.progress(about("repetition " + std::to_string(repetition + 1) + " of " +
                              std::to_string(o_.repetitions) + ", " + c.method->name + ", " +
                              std::to_string(c.clusters) + " clusters"));
        auto lit = lit_->light(c.params, c.method->packets, lights, subset_,
                               seedOf(o_.params.seed, repetition));
        whole = lit.has_value();
        if (!whole) break;
        Sample sample = sampleOf(*lit, scene_.receivers);
        const LightErrors errors = errorsOf(lit->values, reference_->values, o_.exposure);
        sample.rmse8 = errors.rmse8;
        sample.rmse = errors.rmse;
        sample.relMse = errors.relMse;
        scene_.rows[at].samples.push_back(sample);
        pictures[at] = std::move(lit->values);
        measured.push_back(at);
    }
    for (const size_t at : measured) {
        const Row* full = fullInSameSlices(scene_, scene_.rows[at]);
        const auto index = full == nullptr ? at : size_t(full - scene_.rows.data());
        if (index != at && !pictures[index].empty())
            scene_.rows[at].samples.back().toFull8 =
                errorsOf(pictures[at], pictures[index], o_.exposure).rmse8;
    }
    if (repetition == 0 && whole) pictures_ = std::move(pictures);
    return whole;
}

}  // namespace app::many_lights

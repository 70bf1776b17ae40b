// See light_measure.h.
#include "app/bench/light/light_measure.h"

#include <algorithm>

#include "app/bench/bench_clock.h"
#include "app/bench/bench_scenes.h"
#include "app/bench/pair_error.h"
#include "app/files/camera_file.h"
#include "core/base/check.h"
#include "core/base/time.h"

namespace app::light {

namespace {

/// The parameters with that seed, whatever their method.
core::AnyParams withSeed(const Strategy& strategy, core::PathParams common, uint32_t seed)
{
    common.seed = seed;
    return strategy.params(common);
}

}  // namespace

Measurement::Measurement(const LightBenchOptions& options, const BenchTools& tools)
    : o_(options), tools_(tools)
{
    static_cast<PictureRun&>(results_) = pictureRun(options);
    results_.params = options.params;
    results_.pairs = options.pairs;
    devices_ = openDevices(o_.devices, o_.deviceIndex, tools_.warn);
    for (const OpenedDevice& opened : devices_) results_.devices.push_back(opened.device);
}

/// Everything that can be refused before work begins.
void Measurement::load(size_t index)
{
    const SceneOptions& options = o_.scenes[index];
    stations_.clear();
    const core::Clock::time_point start = core::Clock::now();
    world_ = loadBenchScene(options, tools_);
    const core::Camera camera = chooseCamera(*world_, o_.camera);
    scene_ = {};
    std::vector<std::string> taken;
    for (const SceneResult& before : results_.scenes) taken.push_back(before.name);
    static_cast<PictureScene&>(scene_) = pictureScene(o_, index, *world_, camera, taken);
    scene_.loadSeconds = core::secondsSince(start);
    scene_.emitters = world_->emitters.size();
    scene_.hasTree = !world_->emitterTree.empty();
    scene_.choosesByTree = world_->treeEmitters > 0;
    view_ = {camera, scene_.size, o_.params};
    cells_.clear();
}

void Measurement::build()
{
    for (size_t device = 0; device < devices_.size(); ++device)
        for (const Strategy* strategy : strategiesOf(o_, *world_)) {
            Station s{strategy, device,
                      makeRenderer(strategy->params(o_.params).id(), devices_[device].target)};
            s.renderer->setWorld(worldOf(*strategy, world_), tools_.loading);
            s.buildSeconds = s.renderer->stats().buildSeconds;
            stations_.push_back(std::move(s));
        }
    for (const uint32_t spp : o_.samples)
        for (size_t i = 0; i < stations_.size(); ++i) cells_.push_back({i, spp, {}});
}

/// Every strategy on every device. False: stopped.
bool Measurement::warmUp()
{
    for (Station& s : stations_) {
        core::View view = view_;
        view.params = s.strategy->params(o_.params);
        if (!app::warmUp(*s.renderer, view, tools_, results_.devices[s.device])) return false;
    }
    return true;
}

void Measurement::measureScene(size_t index)
{
    load(index);
    build();
    if (!warmUp()) return;
    bool goesOn = true;
    for (uint32_t pair = 0; pair < o_.pairs && goesOn; ++pair)
        for (const uint32_t spp : o_.samples)
            for (size_t device = 0; device < devices_.size(); ++device)
                goesOn = goesOn && measureTurn(device, spp, pair);
    finishScene();
}

/// All strategies on one device with one pair of seeds. False: stopped, and nothing was added.
bool Measurement::measureTurn(size_t device, uint32_t spp, uint32_t pair)
{
    std::vector<Cell*> cells;
    for (Cell& cell : cells_)
        if (stations_[cell.station].device == device && cell.spp == spp) cells.push_back(&cell);
    std::vector<Pair> pairs(cells.size());
    for (size_t k = 0; k < cells.size(); ++k) {
        const size_t at = pair % 2 == 0 ? k : cells.size() - 1 - k;
        tools_.progress(about(stations_[cells[at]->station].strategy->name + std::string(" on ") +
                              results_.devices[device].name + ", " + std::to_string(spp) +
                              " spp, pair " + std::to_string(pair + 1) + " of " +
                              std::to_string(o_.pairs)));
        auto rendered = renderPair(*cells[at], pair);
        if (!rendered) return false;
        pairs[at] = std::move(*rendered);
    }
    for (size_t k = 0; k < cells.size(); ++k) cells[k]->pairs.push_back(std::move(pairs[k]));
    return true;
}

/// Nothing when a stop came first.
std::optional<Measurement::Pair> Measurement::renderPair(const Cell& cell, uint32_t pair)
{
    Pair result;
    const uint32_t seed = o_.params.seed + 2 * pair;
    auto a = render(cell, seed, result.sample), b = a ? render(cell, seed + 1, result.sample) : a;
    if (!b) return {};
    result.a = std::move(*a);
    result.b = std::move(*b);
    return result;
}

/// Adds half of what it took to `sample`.
std::optional<core::Image> Measurement::render(const Cell& cell, uint32_t seed, Sample& sample)
{
    const Station& station = stations_[cell.station];
    core::Renderer& renderer = *station.renderer;
    core::View view = view_;
    view.params = withSeed(*station.strategy, o_.params, seed);
    const double start = processSeconds();
    renderer.setView(view, core::Start::anew);
    const core::RenderStats before = renderer.stats();
    renderer.advance({.samples = cell.spp}, tools_.stop);
    if (tools_.stop.stop_requested()) return {};
    const core::RenderStats after = renderer.stats();
    sample.cpuSeconds += (processSeconds() - start) / 2;
    sample.renderSeconds += (after.renderSeconds - before.renderSeconds) / 2;
    sample.rays += double(after.rays - before.rays) / 2;
    return renderer.read(core::Reading::mean).mean;
}

/// What errors of a pair are relative to: the mean of the scene's pictures of other pairs, of which
/// there are some unless a single one was asked for or a stop came. A bright pixel by chance would
/// hide its own error.
core::Image Measurement::level(size_t pair) const
{
    core::Image mean(scene_.size.x, scene_.size.y, 3);
    const auto add = [&](const core::Image& picture) {
        for (size_t i = 0; i < mean.pixels.size(); ++i) mean.pixels[i] += picture.pixels[i];
    };
    float count = 0;
    const bool isAlone = cells_.front().pairs.size() < 2;
    for (const Cell& cell : cells_)
        for (size_t k = 0; k < cell.pairs.size(); ++k) {
            if (k == pair && !isAlone) continue;
            add(cell.pairs[k].a);
            add(cell.pairs[k].b);
            count += 2;
        }
    for (float& x : mean.pixels) x /= count;
    return mean;
}

Row Measurement::rowOf(const Cell& cell, const Cell& plain,
                       const std::vector<core::Image>& levels) const
{
    const Station& station = stations_[cell.station];
    Row row;
    row.strategy = station.strategy->name;
    row.device = results_.devices[station.device].name;
    row.spp = cell.spp;
    row.buildSeconds = station.buildSeconds;
    TileSums differences;
    double mean = 0;
    for (size_t k = 0; k < cell.pairs.size(); ++k) {
        const Pair& pair = cell.pairs[k];
        const PairError error = pairError(pair.a, pair.b, levels[k]);
        row.samples.push_back(pair.sample);
        row.samples.back().relMse = error.all;
        row.samples.back().trimmed = error.trimmed;
        mean += pictureMean(pair.a) + pictureMean(pair.b);
        differences.add(tileDifferences(pair.a, plain.pairs[k].a));
        differences.add(tileDifferences(pair.b, plain.pairs[k].b));
    }
    row.mean = mean / (2 * static_cast<double>(cell.pairs.size()));
    if (&cell != &plain) row.difference = differences.mean();
    return row;
}

void Measurement::finishScene()
{
    std::vector<core::Image> levels;
    for (size_t k = 0; k < cells_.front().pairs.size(); ++k) levels.push_back(level(k));
    const Cell* plain = nullptr;  // power comes first on each device
    for (const Cell& cell : cells_) {
        if (stations_[cell.station].strategy == &strategyTable().front()) plain = &cell;
        if (!cell.pairs.empty()) scene_.rows.push_back(rowOf(cell, *plain, levels));
    }
    if (!scene_.rows.empty()) results_.scenes.push_back(std::move(scene_));
}

}  // namespace app::light

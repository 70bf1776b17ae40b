// See guiding_measure.h.
#include "app/bench/guiding/guiding_measure.h"

#include <algorithm>
#include <cmath>

#include "app/bench/bench_clock.h"
#include "app/bench/bench_scenes.h"
#include "app/bench/flight.h"
#include "app/files/camera_file.h"

namespace app::guiding {

namespace {

/// A number of the method's own; NaN where it has none of that name.
double detailOf(const core::RenderStats& stats, std::string_view name)
{
    for (const core::StatsDetail& detail : stats.details)
        if (detail.name == name)
            if (const double* value = std::get_if<double>(&detail.value)) return *value;
    return kUnknown;
}

}  // namespace

Measurement::Measurement(const GuidingBenchOptions& options, const BenchTools& tools)
    : o_(options), tools_(tools)
{
    static_cast<PictureRun&>(results_) = pictureRun(options);
    results_.params = options.params;
    results_.seeds = options.seeds;
    results_.sweep = options.sweep;
    for (const auto& [device, target] : openDevices(o_.devices, o_.deviceIndex, tools_.warn)) {
        results_.devices.push_back(device);
        stations_.push_back({target, makeRenderer(core::PathParams::kMethod, target),
                             makeRenderer(core::GuidedParams::kMethod, target)});
    }
}

/// Everything that can be refused before work begins.
void Measurement::load(size_t index)
{
    options_ = &o_.scenes[index];
    world_ = loadBenchScene(*options_, tools_);
    const core::Camera camera = chooseCamera(*world_, o_.camera);
    scene_ = {};
    std::vector<std::string> taken;
    for (const SceneResult& before : results_.scenes) taken.push_back(before.name);
    static_cast<PictureScene&>(scene_) = pictureScene(o_, index, *world_, camera, taken);
    view_ = {camera, scene_.size, o_.params};
    double degrees = kArrivalDegrees;
    const auto way = flight::Flight::around(world_, camera, scene_.size, degrees);
    while (!way.whyNot(degrees, 2).empty()) degrees /= 2;
    away_ = {way.before(degrees, 1), scene_.size, o_.params};
    orbit_.reset();
    if (o_.window) planWindow(way, degrees);
    for (const BenchDevice& device : results_.devices) {
        scene_.arrivals.push_back({device.name, degrees, o_.samples.back(), {}, {}});
        if (orbit_)
            scene_.arrivals.push_back({device.name, degrees, o_.samples.back(), {}, {}, true});
    }
    for (const Station& s : stations_)
        for (core::Renderer* renderer : {s.path.get(), s.guided.get()})
            renderer->setWorld(world_, tools_.loading);
    cells_.clear();
    shown_.clear();
}

/// The camera takes a second from there to here.
void Measurement::planWindow(const flight::Flight& way, double degrees)
{
    for (Station& station : stations_) station.window.reset();
    if (flight::speedThatFits(way, degrees, 1) == degrees)
        orbit_ = flight::lastSeconds(way, degrees, 1);
    else
        tools_.warn(scene_.name + ": no room for an orbit in the window's loop");
}

/// False: stopped.
bool Measurement::findReference(size_t index)
{
    // A real GPU is quicker than the host.
    size_t best = 0;
    for (size_t i = 0; i < stations_.size(); ++i)
        if (!results_.devices[i].onHost) best = i;
    scene_.referenceSpp = o_.referenceSpp;
    const ReferenceOrder order{
        referenceFile(o_.output, scene_.name, scene_.size, std::to_string(o_.referenceSpp) + "spp"),
        view_, o_.scenes[index].at, o_.referenceSpp};
    const auto part = [this](double done) {
        char text[32];
        std::snprintf(text, sizeof text, "reference, %.0f %%", 100 * done);
        tools_.progress(about(text));
    };
    reference_ = reference(order, *stations_[best].guided, *world_, part, tools_.stop);
    if (!reference_) return false;
    scene_.referenceSeconds = reference_->seconds;
    scene_.referenceKept = reference_->kept;
    scene_.referenceRelMse = noiseOf(reference_->level, reference_->variance);
    return true;
}

/// Both methods on every device. False: stopped.
bool Measurement::warmUp()
{
    for (size_t i = 0; i < stations_.size(); ++i)
        for (const Variant& variant : variantTable().first(2)) {
            core::View view = view_;
            view.params = paramsOf(variant, o_.params, o_.params.seed, 2);
            core::Renderer& renderer = stations_[i].rendererOf(variant);
            if (!app::warmUp(renderer, view, tools_, results_.devices[i])) return false;
        }
    return true;
}

void Measurement::makeCells()
{
    for (const uint32_t spp : o_.sweep)
        for (size_t i = 0; i < stations_.size(); ++i)
            for (const Variant* variant : variantsOf(o_)) {
                const bool usual = std::ranges::find(o_.samples, spp) != o_.samples.end();
                if (!usual && !variant->isSwept()) continue;
                Row row;
                row.variant = variant->name;
                row.device = results_.devices[i].name;
                row.spp = spp;
                cells_.push_back(
                    {variant,
                     i,
                     std::move(row),
                     ErrorSum(reference_->mean, reference_->variance, reference_->level),
                     {}});
            }
}

void Measurement::measureScene(size_t index)
{
    load(index);
    if (!findReference(index) || !warmUp()) return;
    makeCells();
    bool goesOn = true;
    for (uint32_t seed = 0; seed < o_.seeds && goesOn; ++seed) {
        for (const uint32_t spp : o_.sweep)
            for (size_t i = 0; i < stations_.size(); ++i)
                goesOn = goesOn && measureTurn(i, spp, seed);
        goesOn = goesOn && measureArrivals(seed);
    }
    finishScene();
}

/// On every device. False: stopped.
bool Measurement::measureArrivals(uint32_t seed)
{
    for (size_t i = 0; i < scene_.arrivals.size(); ++i) {
        Arrival& arrival = scene_.arrivals[i];
        Station& station = stations_[orbit_ ? i / 2 : i];
        tools_.progress(about("arrival, " + arrival.place() + ", seed " + std::to_string(seed + 1) +
                              " of " + std::to_string(o_.seeds)));
        const auto plain = arrive(station, arrival.window, variantTable()[0], seed),
                   guided = arrive(station, arrival.window, variantTable()[1], seed);
        if (!plain || !guided) return false;
        arrival.plain.push_back(*plain);
        arrival.guided.push_back(*guided);
    }
    return true;
}

/// The error of the view's first sample; a guide has learnt where the camera comes from. Nothing
/// when a stop came first.
std::optional<double> Measurement::arrive(Station& station, bool window, const Variant& variant,
                                          uint32_t seed)
{
    const core::AnyParams params =
        paramsOf(variant, o_.params, o_.params.seed + seed, o_.samples.back());
    std::optional<core::Image> picture;
    if (window) {
        if (!station.window)
            station.window = std::make_unique<WindowArrivals>(*options_, station.target, params,
                                                              scene_.size, *orbit_, tools_.stop);
        picture = station.window->arrive(params, variant.change == nullptr ? 1 : o_.samples.back());
    } else {
        picture = arriveByRenderer(station, variant, params);
    }
    if (!picture) return {};
    return relMseOf(*picture);
}

std::optional<core::Image> Measurement::arriveByRenderer(const Station& station,
                                                         const Variant& variant,
                                                         const core::AnyParams& params)
{
    core::Renderer& renderer = station.rendererOf(variant);
    const uint32_t before = variant.change == nullptr ? 0 : o_.samples.back();
    for (uint32_t k = 0; k <= before; ++k) {
        core::View view = k == before ? view_ : away_;
        view.params = params;
        renderer.setView(view, k == 0 ? core::Start::anew : core::Start::moved);
        renderer.advance({.samples = 1}, tools_.stop);
        if (tools_.stop.stop_requested()) return {};
    }
    return renderer.read(core::Reading::mean).mean;
}

double Measurement::relMseOf(const core::Image& picture) const
{
    ErrorSum alone(reference_->mean, reference_->variance, reference_->level);
    alone.add(picture);
    return alone.errors().relMse.value;
}

/// All variants on one device with one seed. False: stopped, and nothing was added.
bool Measurement::measureTurn(size_t station, uint32_t spp, uint32_t seed)
{
    std::vector<Cell*> cells;
    for (Cell& cell : cells_)
        if (cell.station == station && cell.row.spp == spp) cells.push_back(&cell);
    std::vector<Picture> pictures(cells.size());
    for (size_t k = 0; k < cells.size(); ++k) {
        const size_t at = seed % 2 == 0 ? k : cells.size() - 1 - k;
        tools_.progress(about(cells[at]->row.variant + " on " + cells[at]->row.device + ", " +
                              std::to_string(spp) + " spp, seed " + std::to_string(seed + 1) +
                              " of " + std::to_string(o_.seeds)));
        auto picture = render(*cells[at], o_.params.seed + seed);
        if (!picture) return false;
        pictures[at] = std::move(*picture);
    }
    const bool isShown = seed == 0 && station == 0 && spp == o_.samples.back();
    for (size_t k = 0; k < cells.size(); ++k) {
        add(*cells[k], pictures[k], pictures.front().image);
        if (isShown && cells[k]->variant->isMain)
            shown_.emplace_back(cells[k]->row.variant, pictures[k].image);
    }
    return true;
}

/// Nothing when a stop came first.
std::optional<Measurement::Picture> Measurement::render(const Cell& cell, uint32_t seed)
{
    core::Renderer& renderer = stations_[cell.station].rendererOf(*cell.variant);
    core::View view = view_;
    view.params = paramsOf(*cell.variant, o_.params, seed, cell.row.spp);
    const double start = processSeconds();
    renderer.setView(view, core::Start::anew);
    const core::RenderStats before = renderer.stats();
    renderer.advance({.samples = cell.row.spp}, tools_.stop);
    if (tools_.stop.stop_requested()) return {};
    const core::RenderStats after = renderer.stats();
    Picture picture;
    picture.sample = {.cpuSeconds = processSeconds() - start,
                      .renderSeconds = after.renderSeconds - before.renderSeconds,
                      .rays = double(after.rays - before.rays),
                      .guidedShare = detailOf(after, "guided_share"),
                      .leaves = detailOf(after, "guide_leaves"),
                      .bytes = detailOf(after, "guide_bytes"),
                      .guideSeconds = detailOf(after, "guide_seconds")};
    picture.image = renderer.read(core::Reading::mean).mean;
    return picture;
}

void Measurement::add(Cell& cell, const Picture& picture, const core::Image& plain)
{
    cell.errors.add(picture.image);
    if (cell.variant->change != nullptr)
        cell.differences.add(tileDifferences(picture.image, plain));
    Row& row = cell.row;
    row.samples.push_back(picture.sample);
    row.samples.back().relMse = relMseOf(picture.image);
    const auto count = static_cast<double>(row.samples.size());
    const double mean = pictureMean(picture.image);
    row.mean = count == 1 ? mean : row.mean + (mean - row.mean) / count;
}

void Measurement::finishScene()
{
    for (Cell& cell : cells_) {
        if (cell.row.samples.empty()) continue;
        cell.row.relMse = cell.errors.errors().relMse;
        if (cell.variant->change != nullptr) cell.row.difference = cell.differences.mean();
        scene_.rows.push_back(std::move(cell.row));
    }
    std::erase_if(scene_.arrivals, [](const Arrival& a) { return a.guided.empty(); });
    if (scene_.rows.empty()) return;
    takeShots();
    results_.scenes.push_back(std::move(scene_));
}

void Measurement::takeShots()
{
    namespace fs = std::filesystem;
    if (shown_.empty()) return;
    scene_.shownSpp = o_.samples.back();
    scene_.shownDevice = results_.devices.front().name;
    std::error_code error;
    fs::create_directories(o_.output / "pictures", error);
    shown_.emplace_back("reference", reference_->mean);
    for (const auto& [name, picture] : shown_) {
        Shot shot;
        shot.name = name;
        shot.file = fs::path("pictures") / (scene_.name + '-' + name + ".png");
        if (const Row* row = findRow(scene_, name, scene_.shownDevice, scene_.shownSpp)) {
            shot.relMse = row->samples.front().relMse;
            shot.seconds = secondsOf(results_.devices.front(), row->samples.front());
        }
        core::writePng(o_.output / shot.file, picture, static_cast<float>(o_.exposure),
                       static_cast<uint32_t>(Tone::agx), {{"Software", "rekindle bench guiding"}});
        scene_.shots.push_back(shot);
    }
}

}  // namespace app::guiding

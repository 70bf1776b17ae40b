// Path tracing that keeps its samples when the camera moves, on all cores. The estimator is that of
// shaders/shared/reuse_path.h. A pass takes one new path per pixel; the first one of a view looks
// at the samples of the view before. Two stores take turns: one is read, one is written, and they
// change places only after a whole pass.
#include <array>
#include <cmath>
#include <mutex>

#include "core/base/check.h"
#include "core/methods/method.h"
#include "core/methods/reuse_figures.h"
#include "core/methods/reuse_maps.h"
#include "core/methods/reuse_settings.h"
#include "core/methods/tiled_renderer.h"
#include "core/trace/scene_view.h"
#include "shared/reuse_path.h"

namespace core {

namespace {

/// The scene as the shared text reads it, and rays through it.
struct TracedScene : shared::SceneView {
    const Accel* accel;
};

}  // namespace

}  // namespace core

namespace shared {

bool traceWay(const SceneView& scene, vec3 origin, vec3 direction, uint seed, Hit& hit)
{
    return static_cast<const core::TracedScene&>(scene).accel->closest(
        {origin, kInfinity, direction, seed}, hit);
}

bool wayIsOpen(const SceneView& scene, const ShadowRay& shadow, uint seed)
{
    return !static_cast<const core::TracedScene&>(scene).accel->occluded(
        {shadow.origin, shadow.tMax, shadow.direction, seed});
}

}  // namespace shared

namespace core {

namespace {

using glm::uvec2, glm::vec2, glm::vec3;

/// What a view leaves to the next one.
struct Store {
    std::vector<shared::ReusePixel> pixels;
    std::vector<shared::ReuseSample> samples;  // `records` per pixel
    std::vector<shared::ReuseLight> lights;    // `lights` per pixel
    std::vector<vec3> means;                   // of strategies that keep one
    std::vector<shared::ReuseMapPixel> maps;
    shared::CameraData camera{};
    uvec2 size{0};  // 0: there is nothing

    void reset(uvec2 newSize, const ReuseParams& params)
    {
        const size_t count = size_t(newSize.x) * newSize.y;
        pixels.resize(count);
        maps.resize(count);
        samples.resize(count * recordsKept(params));
        lights.resize(count * lightsKept(params));
        means.resize(shared::keepsMeans(uint32_t(params.reuse)) ? count : 0);
        size = newSize;
    }
};

/// Samples that compete for the places of a store.
template <class Record> struct Competition {
    std::array<Record, shared::kReuseMostScores> records;
    std::array<vec2, shared::kReuseMostScores> worth;  // v, and what it brings
    uint32_t count = 0;

    void add(const Record& record, vec2 itsWorth)
    {
        records[count] = record;
        worth[count++] = itsWorth;
    }

    /// Keeps `out.size()` of them by threshold resampling; `weight` is the member that is paid,
    /// `mean` what all together have brought.
    void keep(std::span<Record> out, float Record::*weight, const shared::ReuseSettings& settings,
              vec3 mean, float xi) const
    {
        std::array<float, shared::kReuseMostScores> scores;
        for (uint32_t i = 0; i < count; ++i)
            scores[i] = shared::reuseScore(settings, worth[i].x, worth[i].y, mean);
        const auto most = static_cast<uint32_t>(out.size());
        const float kappa = shared::reuseThreshold(scores.data(), count, most);
        float sum = 0;
        uint32_t kept = 0;
        for (uint32_t i = 0; i < count && kept < most; ++i) {
            if (!shared::usableDensity(scores[i])) continue;
            if (kappa > 0 && !shared::reuseKeep(sum, scores[i], kappa, xi)) continue;
            out[kept] = records[i];
            if (kappa > 0) out[kept].*weight *= shared::reuseKeepScale(scores[i], kappa);
            ++kept;
        }
        for (; kept < most; ++kept) out[kept].*weight = 0;
    }
};

class SampleReuse : public TiledRenderer {
public:
    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override
    {
        before_ = {};
        TiledRenderer::setWorld(std::move(world), progress);
    }

    void setView(const View& view, Start start) override
    {
        const ReuseParams last = params_;
        visibility_ = askedVisibility(last, visibility_, figures_);
        TiledRenderer::setView(view, start);
        passes_ = 0;
        figures_ = {};
        if (start == Start::anew || !(last == params_)) {
            before_ = {};
            visibility_ = askedVisibility(params_, 0, {});
        }
        if (start == Start::anew) samplesBefore_ = 0;
    }

    void advance(const Budget& budget, std::stop_token stop) override
    {
        const auto begin = Clock::now();
        for (uint32_t i = 0; i < std::max(budget.samples, 1u); ++i) {
            const double left = budget.seconds - secondsSince(begin);
            if (i > 0 && (left <= 0 || stop.stop_requested())) return;
            const uint64_t had = film_.progress().samples;
            pass({std::min(budget.samples, 1u), left}, stop);
            if (film_.progress().samples == had) return;
        }
    }

    RenderStats stats() const override
    {
        RenderStats stats = TiledRenderer::stats();
        const std::lock_guard lock(figuresMutex_);
        const double pixels = double(film_.size().x) * film_.size().y * std::max(passes_, 1u);
        stats.details = figures_.details(params_, visibility_, recordsKept(params_), pixels);
        return stats;
    }

    std::vector<Image> maps() override
    {
        if (passes_ == 0) return {};
        return makeReuseMaps(
            before_.size, [this](size_t i) { return before_.pixels[i]; },
            [this](size_t i, float) { return before_.maps[i]; });
    }

private:
    void setParams(const AnyParams& params) override { params_ = params.as<ReuseParams>(); }

    /// One pass over the picture, or what a budget allows of it.
    void pass(const Budget& budget, const std::stop_token& stop)
    {
        now_.reset(film_.size(), params_);
        now_.camera = frameCamera();
        path_ = frameSettings();
        setPathSettings(params_, path_);
        scene_ = {sceneView(accel_->world()), accel_.get()};
        settings_ = reuseSettings(params_);
        settings_.visibility = visibility_;
        settings_.flags = reuseFlags(params_, passes_);
        const uint64_t had = film_.progress().samples;
        film_.advance(budget, stop, [this](const Tile& tile, uint32_t, uint32_t, Film& film) {
            TileTally tally;
            ReuseFigures figures;
            for (uint32_t y = tile.y0; y < tile.y1; ++y)
                for (uint32_t x = tile.x0; x < tile.x1; ++x) addPixel({x, y}, film, tally, figures);
            count(figures);
            return tally;
        });
        if (film_.progress().samples == had) return;
        std::swap(before_, now_);
        ++passes_;
        samplesBefore_ += samplesPerPass(params_);
    }

    void count(const ReuseFigures& figures)
    {
        const std::lock_guard lock(figuresMutex_);
        figures_.scatters += figures.scatters;
        figures_.withHistory += figures.withHistory;
        figures_.weights += figures.weights;
        figures_.shares += figures.shares;
        figures_.paths += figures.paths;
        figures_.leaked += figures.leaked;
        figures_.lost += figures.lost;
    }

    void addPixel(uvec2 pixel, Film& film, TileTally& tally, ReuseFigures& figures)
    {
        const size_t i = size_t(pixel.y) * film.width + pixel.x;
        shared::ReuseTally rays{1, 0};
        const shared::ReuseSums sums = estimate(pixel, i, rays);
        const float weight = sums.nominal + sums.rays;
        now_.maps[i] = shared::reuseMap(sums, settings_.strategy);
        if (passes_ > 0) {
            film.add(i, shared::plainRadiance(sums), tally.counters);
        } else if (keepsMeans()) {
            film.begin(i, now_.means[i], now_.means[i] * now_.means[i], weight, tally.counters);
        } else {
            film.begin(i, shared::reusedRadiance(sums), shared::reusedSquares(sums), weight,
                       tally.counters);
        }
        const bool scatters = shared::unpackHistory(now_.pixels[i].history).nominal > 0;
        const uint32_t paths = scatters ? sums.taken : 1;
        figures.scatters += scatters ? 1 : 0;
        figures.withHistory += sums.nominal > 0 ? 1 : 0;
        figures.weights += double(sums.weightSum);
        figures.shares += double(sums.nominal / weight);
        figures.paths += paths;
        figures.leaked += double(shared::biasShare(sums, sums.leaked));
        figures.lost += double(shared::biasShare(sums, sums.lost));
        tally.paths += paths;
        tally.rays += rays.closestRays + rays.shadowRays;
    }

    /// What is known of a pixel while it is estimated.
    struct Pixel {
        size_t index;
        shared::SampleStream stream;
        shared::ReuseTally& tally;
        shared::ReuseVertex v{};
        shared::PathSettings path{};  // what paths from the first hit may do
        ptrdiff_t source = -1;        // the pixel of the view before; -1: there is none
        bool chained = false;         // seen over mirrors or through glass
    };

    /// The pixel of the view before whose history belongs to this first hit; -1: there is none.
    /// `cameraBefore` is the one of that view, or where it appears to be. What is seen through
    /// curved glass is not where a camera would see it without: it may be far away on the same
    /// surface.
    ptrdiff_t findHistory(const Pixel& p, const shared::ReuseChain& chain,
                          const shared::CameraData& cameraBefore) const
    {
        if (before_.size.x == 0 || params_.reuse == ReuseStrategy::discard) return -1;
        vec2 film;
        const shared::SurfacePoint& surface = p.v.vertex.surface;
        const vec3 here = surface.position;
        if (!shared::projectToFilm(cameraBefore, vec2(before_.size), here, film)) return -1;
        const float distance = glm::length(here - cameraBefore.position);
        const glm::ivec2 middle =
            shared::historyPixel(settings_.strategy, film, shared::tapNumbers(p.stream));
        const float reach = p.chained
                                ? shared::reachOfHistory(cameraBefore, float(before_.size.y),
                                                         distance, chain.direction, surface.normal)
                                : shared::kInfinity;
        for (uint32_t k = 0; k < 9; ++k) {
            const glm::ivec2 at = middle + shared::historyOffset(k);
            if (at.x < 0 || at.y < 0 || at.x >= int(before_.size.x) || at.y >= int(before_.size.y))
                continue;
            const ptrdiff_t source = ptrdiff_t(at.y) * before_.size.x + at.x;
            vec3 position;
            if (shared::historyFits(scene_, cameraBefore, before_.pixels[size_t(source)], surface,
                                    distance, reach, position))
                return source;
        }
        return -1;
    }

    shared::ReuseSums estimate(uvec2 pixel, size_t index, shared::ReuseTally& tally)
    {
        shared::ReuseSums sums = shared::noReuseSums();
        Pixel p{index,
                shared::makeStream(path_.samplerKind, path_.seed, pixel, samplesBefore_,
                                   shared::kPurposePath),
                tally};
        if (!findVertex(pixel, p, sums)) {
            if (keepsMeans()) now_.means[index] = sums.seen + sums.rest;
            return sums;
        }
        std::array<shared::ReuseNew, shared::kReuseMostRays> fresh;
        const uint32_t taken = shared::raysTaken(p.v.history, p.v.rays);
        for (uint32_t k = 0; k < taken; ++k)
            fresh[k] = shared::takePath(scene_, p.path, settings_, p.v, shared::pathFromHere(p.v),
                                        shared::pathStream(p.stream, p.v.rays, k), tally);
        now_.pixels[index].history = shared::packHistory(shared::grownHistory(
            settings_, p.v.history, p.v.rays, taken, shared::narrowestLobe(p.v.vertex.bsdf)));
        combine(p, std::span(fresh).first(taken), sums);
        return sums;
    }

    /// The first hit of a pixel and its history, and what comes to the camera beside its light.
    /// False where nothing is scattered.
    bool findVertex(uvec2 pixel, Pixel& p, shared::ReuseSums& sums)
    {
        shared::PathState ray = shared::pixelRay(now_.camera, path_, settings_, pixel, p.stream);
        shared::ReusePixel& here = now_.pixels[p.index];
        float t;
        here = shared::findFirstHit(scene_, ray, p.stream, t);
        shared::CameraData cameraBefore = before_.camera;
        shared::ReuseChain chain = shared::noChain(ray.direction);
        if ((accel_->world().features & shared::kFeatureDelta) != 0)
            chain =
                shared::followChain(scene_, path_, ray, t, p.stream, here, cameraBefore, p.tally);
        p.chained = chain.bounces > 0;
        if (p.chained) ray = shared::rayOfChain(scene_, chain, here);
        sums.seen = chain.seen;
        if (chain.restBounces > 0) sums.rest = takeRest(chain, p);
        if (!shared::beginReuse(scene_, path_, ray, here, p.v, sums.seen)) return false;
        p.path = shared::settingsAfter(path_, chain.bounces);
        if (!p.chained)
            chain.towardsBefore = shared::towardsCamera(cameraBefore, p.v.vertex.surface.position);
        p.source = findHistory(p, chain, cameraBefore);
        if (p.source >= 0) {
            shared::takeHistory(scene_, settings_, chain.towardsBefore,
                                before_.pixels[size_t(p.source)], p.v);
        } else {
            p.v.rays = shared::raysDue(settings_, p.v.history, 0);
            p.v.history.credit = shared::firstCredit(p.stream);
        }
        sums.beta = p.v.beta;
        sums.nominal = p.v.history.nominal;
        sums.rays = p.v.rays;
        return true;
    }

    vec3 takeRest(const shared::ReuseChain& chain, Pixel& p)
    {
        const shared::SampleStream stream = shared::purposeStream(p.stream, shared::kPurposeRest);
        return shared::takePath(scene_, shared::restSettings(path_), settings_, {},
                                shared::restOfChain(chain), stream, p.tally)
            .around;
    }

    /// Old samples, and what is kept of them and the new ones.
    void combine(Pixel& p, std::span<const shared::ReuseNew> fresh, shared::ReuseSums& sums)
    {
        Competition<shared::ReuseSample> samples;
        Competition<shared::ReuseLight> lights;
        if (p.source >= 0 && !keepsMeans()) lookAtOld(p, samples, lights, sums);
        for (const shared::ReuseNew& n : fresh) {
            shared::addReuseNew(sums, n);
            if (n.record.u > 0)
                samples.add(n.record, {n.scale, n.scale * shared::luminance(n.around)});
            if (n.light.v > 0)
                lights.add(n.light, {n.light.v, n.light.v * shared::luminance(n.direct)});
        }
        if (keepsMeans()) {
            vec3 before = p.source >= 0 ? before_.means[size_t(p.source)] : vec3(0);
            // What is seen over mirrors or through glass has no other taps: it is not known where
            // they would lie.
            if (params_.reuse == ReuseStrategy::svgf && p.source >= 0 && !p.chained)
                before = meanOfTaps(p.v.vertex.surface, before);
            now_.means[p.index] = shared::naiveMean(sums, before);
            return;
        }
        samples.keep({&now_.samples[p.index * recordsKept(params_)], recordsKept(params_)},
                     &shared::ReuseSample::u, settings_, sums.around, keepNumber(p.stream, 0));
        lights.keep({&now_.lights[p.index * lightsKept(params_)], lightsKept(params_)},
                    &shared::ReuseLight::v, settings_, sums.direct, keepNumber(p.stream, 1));
    }

    void lookAtOld(Pixel& p, Competition<shared::ReuseSample>& samples,
                   Competition<shared::ReuseLight>& lights, shared::ReuseSums& sums) const
    {
        const auto source = size_t(p.source);
        for (uint32_t i = 0; i < recordsKept(params_); ++i) {
            shared::ReuseSample r = before_.samples[source * recordsKept(params_) + i];
            shared::ReuseView view;
            if (!shared::aimOldSample(scene_, settings_, p.v, r, view)) continue;
            if (!shared::survivesRejection(shared::rejectionNumber(p.stream, i), view)) continue;
            const bool hidden =
                shared::oldSampleHides(scene_, settings_, p.v, view, p.stream, i, p.tally);
            vec3 L = shared::unpackRgbe(r.radiance);
            if (r.radiance == shared::kReuseEvaluated)
                L = shared::evaluateArriving(scene_, p.path, p.v, r, view);
            if (hidden) {
                shared::dropOldSample(sums, view, L);
                continue;
            }
            const float brings = shared::addOldSample(sums, view, L);
            r.u = view.u * view.perPlace;
            samples.add(r, {view.u * view.p, brings});
        }
        for (uint32_t i = 0; i < lightsKept(params_); ++i) {
            shared::ReuseLight r = before_.lights[source * lightsKept(params_) + i];
            if (!(r.v > 0)) continue;
            const float brings =
                shared::addOldLight(scene_, p.path, settings_, p.v, p.stream, i, r, sums, p.tally);
            if (r.v > 0) lights.add(r, {r.v, brings});
        }
    }

    bool keepsMeans() const { return shared::keepsMeans(static_cast<uint32_t>(params_.reuse)); }

    /// Mean of the four pixels around where the first hit was before, of those whose history fits;
    /// `nearest` where none does.
    vec3 meanOfTaps(const shared::SurfacePoint& s, vec3 nearest) const
    {
        vec2 film;
        shared::projectToFilm(before_.camera, vec2(before_.size), s.position, film);
        const float distance = glm::length(s.position - before_.camera.position);
        glm::vec4 sum(0);
        for (uint32_t k = 0; k < 4; ++k) {
            glm::ivec2 at;
            const float weight = shared::historyTap(film, k, at);
            if (at.x < 0 || at.y < 0 || at.x >= int(before_.size.x) || at.y >= int(before_.size.y))
                continue;
            const size_t source = size_t(at.y) * before_.size.x + size_t(at.x);
            vec3 position;
            if (shared::historyFits(scene_, before_.camera, before_.pixels[source], s, distance,
                                    shared::kInfinity, position))
                sum += weight * glm::vec4(before_.means[source], 1);
        }
        return sum.w > 0.01f ? vec3(sum) / sum.w : nearest;
    }

    static float keepNumber(const shared::SampleStream& stream, uint32_t dimension)
    {
        return shared::streamFloat(shared::decisionStream(stream, shared::kPurposeResampling),
                                   dimension);
    }

    ReuseParams params_;
    Store before_, now_;
    float visibility_ = 0;
    uint32_t passes_ = 0;         // of this view
    uint32_t samplesBefore_ = 0;  // of all views since the last that began anew
    mutable std::mutex figuresMutex_;
    ReuseFigures figures_;  // of this view
    // Of the present pass.
    TracedScene scene_{};
    shared::PathSettings path_{};
    shared::ReuseSettings settings_{};
};

}  // namespace

std::unique_ptr<Renderer> makeSampleReuse()
{
    return std::make_unique<SampleReuse>();
}

std::span<const MapInfo> reuseMaps()
{
    static constexpr std::array kMaps{
        MapInfo{"history", "samples that the history of a pixel stands for (N)"},
        MapInfo{"alpha", "share of the picture that old samples answer for", 1},
        MapInfo{"c", "N / (N + n): the share where the surface's lobe has not turned", 1},
        MapInfo{"residual", "share that is left to new paths: 1 - alpha", 1},
        MapInfo{"ess", "equal samples that would be as good as the weights are (ESS)"},
        MapInfo{"rays", "new paths of the last pass"},
    };
    return kMaps;
}

std::span<const MethodPreset> reusePresets()
{
    static const std::array kPresets{
        MethodPreset{"flight", ReuseParams{},
                     "Reweighting-Augmentation with eight samples a pixel"},
        MethodPreset{"balance", ReuseParams{.reuse = ReuseStrategy::mis},
                     "the balance heuristic between old and new samples: nearly as good, cheaper"},
        MethodPreset{"fresh", ReuseParams{.reuse = ReuseStrategy::discard},
                     "nothing is kept: what the others are measured against"},
    };
    return kPresets;
}

}  // namespace core

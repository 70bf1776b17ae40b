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
    std::vector<vec3> means;                   // of `naive`
    shared::CameraData camera{};
    uvec2 size{0};  // 0: there is nothing

    void reset(uvec2 newSize, const ReuseParams& params)
    {
        const size_t count = size_t(newSize.x) * newSize.y;
        pixels.resize(count);
        samples.resize(count * params.records);
        lights.resize(count * params.lights);
        means.resize(params.reuse == ReuseStrategy::naive ? count : 0);
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
        TiledRenderer::setView(view, start);
        passes_ = 0;
        figures_ = {};
        if (start == Start::anew || !(last == params_)) before_ = {};
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
        stats.details = figures_.details(params_.reuse, params_.records);
        return stats;
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
        ++samplesBefore_;
    }

    void count(const ReuseFigures& figures)
    {
        const std::lock_guard lock(figuresMutex_);
        figures_.scatters += figures.scatters;
        figures_.withHistory += figures.withHistory;
        figures_.weights += figures.weights;
        figures_.shares += figures.shares;
    }

    void addPixel(uvec2 pixel, Film& film, TileTally& tally, ReuseFigures& figures)
    {
        const size_t i = size_t(pixel.y) * film.width + pixel.x;
        shared::ReuseTally rays{1, 0};
        const shared::ReuseSums sums = estimate(pixel, i, rays);
        if (passes_ > 0) {
            film.add(i, shared::plainRadiance(sums), tally.counters);
        } else if (params_.reuse == ReuseStrategy::naive) {
            film.begin(i, now_.means[i], now_.means[i] * now_.means[i], sums.nominal + 1,
                       tally.counters);
        } else {
            film.begin(i, shared::reusedRadiance(sums), shared::reusedSquares(sums),
                       sums.nominal + 1, tally.counters);
        }
        figures.scatters += now_.pixels[i].nominal > 0 ? 1 : 0;
        figures.withHistory += sums.nominal > 0 ? 1 : 0;
        figures.weights += double(sums.weightSum);
        figures.shares += double(sums.nominal / (sums.nominal + 1));
        ++tally.paths;
        tally.rays += rays.closestRays + rays.shadowRays;
    }

    /// The pixel of the view before whose history belongs to this first hit; -1: there is none.
    ptrdiff_t findHistory(const shared::ReuseVertex& v, vec3& position) const
    {
        if (before_.size.x == 0 || params_.reuse == ReuseStrategy::discard) return -1;
        vec2 film;
        const vec3 here = v.vertex.surface.position;
        if (!shared::projectToFilm(before_.camera, vec2(before_.size), here, film)) return -1;
        const float distance = glm::length(here - before_.camera.position);
        const glm::ivec2 middle(glm::floor(film));
        for (uint32_t k = 0; k < 9; ++k) {
            const glm::ivec2 at = middle + shared::historyOffset(k);
            if (at.x < 0 || at.y < 0 || at.x >= int(before_.size.x) || at.y >= int(before_.size.y))
                continue;
            const ptrdiff_t source = ptrdiff_t(at.y) * before_.size.x + at.x;
            if (shared::historyFits(scene_, before_.pixels[size_t(source)], v.vertex.surface,
                                    distance, position))
                return source;
        }
        return -1;
    }

    shared::ReuseSums estimate(uvec2 pixel, size_t index, shared::ReuseTally& tally)
    {
        shared::ReuseSums sums = shared::noReuseSums();
        const shared::SampleStream stream = shared::makeStream(
            path_.samplerKind, path_.seed, pixel, samplesBefore_, shared::kPurposePath);
        const shared::PathState ray =
            shared::pixelRay(now_.camera, path_, settings_, pixel, stream);
        shared::ReusePixel& here = now_.pixels[index];
        here = shared::findFirstHit(scene_, ray, stream);
        shared::ReuseVertex v;
        if (!shared::beginReuse(scene_, path_, ray, here, v, sums.seen)) {
            if (params_.reuse == ReuseStrategy::naive) now_.means[index] = sums.seen;
            return sums;
        }
        vec3 position;
        const ptrdiff_t source = findHistory(v, position);
        if (source >= 0)
            shared::takeHistory(before_.camera, position, before_.pixels[size_t(source)].nominal,
                                v);
        sums.nominal = v.nominal;
        here.nominal = std::min(v.nominal + 1, params_.cap);
        const shared::ReuseNew fresh = shared::takeNew(scene_, path_, settings_, v, stream, tally);
        if (params_.reuse == ReuseStrategy::naive) {
            shared::addReuseNew(sums, fresh);
            const vec3 plain = shared::plainRadiance(sums);
            now_.means[index] = plain;
            if (source >= 0) now_.means[index] += v.c * (before_.means[size_t(source)] - plain);
        } else {
            reuse(v, stream, source, index, fresh, sums);
        }
        return sums;
    }

    /// Old samples of the pixel `source` (-1: none), and what is kept of them and the new one.
    void reuse(const shared::ReuseVertex& v, const shared::SampleStream& stream, ptrdiff_t source,
               size_t index, const shared::ReuseNew& fresh, shared::ReuseSums& sums)
    {
        Competition<shared::ReuseSample> samples;
        Competition<shared::ReuseLight> lights;
        for (uint32_t i = 0; source >= 0 && i < params_.records; ++i) {
            shared::ReuseSample r = before_.samples[size_t(source) * params_.records + i];
            shared::ReuseView view;
            if (!shared::aimOldSample(scene_, settings_, v, r, view)) continue;
            const vec3 L = r.radiance == shared::kReuseEvaluated
                               ? shared::evaluateArriving(scene_, path_, v.vertex.surface.position,
                                                          r, view)
                               : shared::unpackRgbe(r.radiance);
            const float brings = shared::addOldSample(sums, view, L);
            r.u = view.u * view.perPlace;
            samples.add(r, {view.u * view.p, brings});
        }
        for (uint32_t i = 0; source >= 0 && i < params_.lights; ++i) {
            shared::ReuseLight r = before_.lights[size_t(source) * params_.lights + i];
            if (!(r.v > 0)) continue;
            const float brings = shared::addOldLight(scene_, path_, v, r, sums);
            lights.add(r, {r.v, brings});
        }
        shared::addReuseNew(sums, fresh);
        if (fresh.record.u > 0)
            samples.add(fresh.record, {fresh.scale, fresh.scale * shared::luminance(fresh.around)});
        if (fresh.light.v > 0)
            lights.add(fresh.light,
                       {fresh.light.v, fresh.light.v * shared::luminance(fresh.direct)});
        samples.keep({&now_.samples[index * params_.records], params_.records},
                     &shared::ReuseSample::u, settings_, sums.around, keepNumber(stream, 0));
        lights.keep({&now_.lights[index * params_.lights], params_.lights}, &shared::ReuseLight::v,
                    settings_, sums.direct, keepNumber(stream, 1));
    }

    static float keepNumber(const shared::SampleStream& stream, uint32_t dimension)
    {
        return shared::streamFloat(shared::decisionStream(stream, shared::kPurposeResampling),
                                   dimension);
    }

    ReuseParams params_;
    Store before_, now_;
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

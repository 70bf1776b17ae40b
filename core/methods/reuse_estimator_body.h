// What sample reuse does at the pixels of a tile: their first hits and histories, then the new
// paths of all (reuse_paths_body.h), then each pixel's old samples and what is kept. Included once
// by each reuse_*.cpp, after REKINDLE_FEATURES is defined.
#include <array>
#include <vector>

#include "core/base/per_thread.h"
#include "core/methods/reuse_competition_body.h"
#include "core/methods/reuse_paths_body.h"
#include "core/methods/tiled_film.h"

namespace core {

using glm::uvec2, glm::vec2, glm::vec3;

namespace {

float keepNumber(const shared::SampleStream& stream, uint32_t dimension)
{
    return shared::streamFloat(shared::decisionStream(stream, shared::kPurposeResampling),
                               dimension);
}

/// What is known of a pixel while it is estimated.
struct Pixel {
    size_t index;
    shared::SampleStream stream;
    shared::ReuseVertex v;
    shared::PathSettings path;  // what paths from the first hit may do
    shared::SurfaceMotion motion;
    ptrdiff_t source;  // the pixel of the view before; -1: there is none
    float deviation;   // of that one
    bool scatters;     // else no path begins here
    bool chained;      // seen over mirrors or through glass
    uint32_t taken;    // new paths
    size_t fresh;      // where they begin among those of the tile
};

/// A way that mirrors and glass have not taken.
struct RestWay {
    uint32_t pixel;
    shared::PathState ray;
};

class TileEstimator {
public:
    TileEstimator(const ReuseJob& job, const Tile& tile, std::span<shared::ReuseSums> sums,
                  shared::ReuseTally& tally)
        : job_(job), tile_(tile), sums_(sums), tally_(tally),
          records_(shared::recordsOf(job.settings)), lights_(shared::lightsOf(job.settings))
    {}

    void estimate()
    {
        findFirstHits();
        takePaths();
        for (size_t i = 0; i < sums_.size(); ++i) finish(work_.pixels[i], sums_[i]);
    }

private:
    static constexpr size_t kMost = size_t(kFilmTile) * kFilmTile;

    struct Work {
        std::array<Pixel, kMost> pixels;
        std::array<shared::PathState, kMost> cameraRays;
        std::array<Ray, kMost> rays;
        std::array<shared::Hit, kMost> hits;
        std::vector<RestWay> rest;
        std::vector<shared::ReuseNew> fresh;  // where samples are kept
    };

    void findFirstHits();
    bool findVertex(uint32_t i, shared::ReuseSums& sums) const;
    ptrdiff_t findHistory(const Pixel& p, const shared::ReuseChain& chain,
                          const shared::CameraData& cameraBefore) const;
    float deviationAround(size_t source) const;
    void countPaths(Pixel& p, shared::ReuseSums& sums) const;
    void takePaths();
    void add(const NewPath& path);
    void finish(Pixel& p, shared::ReuseSums& sums) const;
    void keepSamples(Pixel& p, std::span<const shared::ReuseNew> fresh,
                     shared::ReuseSums& sums) const;
    void keepMean(const Pixel& p, const shared::ReuseSums& sums) const;
    void lookAtOld(Pixel& p, Competition<shared::ReuseSample>& samples,
                   Competition<shared::ReuseLight>& lights, shared::ReuseSums& sums) const;
    vec3 meanOfTaps(const Pixel& p, vec3 nearest) const;
    bool keepsMeans() const { return shared::keepsMeans(job_.settings.strategy); }
    bool keepsSamples() const { return shared::keepsSamples(job_.settings.strategy); }

    Work& work_ = perThread<Work>();
    const ReuseJob& job_;
    const Tile& tile_;
    std::span<shared::ReuseSums> sums_;
    shared::ReuseTally& tally_;
    uint32_t records_, lights_;
};

/// What the pixels see, and what each has due of new paths.
void TileEstimator::findFirstHits()
{
    uint32_t i = 0;
    for (uint32_t y = tile_.y0; y < tile_.y1; ++y) {
        for (uint32_t x = tile_.x0; x < tile_.x1; ++x, ++i) {
            Pixel& p = work_.pixels[i];
            p.index = size_t(y) * job_.now.size.x + x;
            p.stream = shared::makeStream(job_.path.samplerKind, job_.path.seed, {x, y},
                                          job_.firstSample, shared::kPurposePath);
            const shared::PathState ray =
                shared::pixelRay(job_.now.camera, job_.path, job_.settings, {x, y}, p.stream);
            work_.cameraRays[i] = ray;
            work_.rays[i] = {ray.origin, shared::kInfinity, ray.direction,
                             shared::alphaSeed(p.stream, 0, 0)};
        }
    }
    CHECK(i == sums_.size());
    tally_.closestRays += i;
    job_.scene.accel->closest({work_.rays.data(), i}, work_.hits.data(), true);
    work_.rest.clear();
    for (uint32_t k = 0; k < i; ++k) {
        Pixel& p = work_.pixels[k];
        sums_[k] = shared::noReuseSums();
        p.taken = 0;
        p.scatters = findVertex(k, sums_[k]);
        if (p.scatters) countPaths(p, sums_[k]);
    }
}

/// The first hit of pixel `i` and its history, and what comes to the camera beside its light.
/// False where nothing is scattered.
bool TileEstimator::findVertex(uint32_t i, shared::ReuseSums& sums) const
{
    Pixel& p = work_.pixels[i];
    shared::PathState ray = work_.cameraRays[i];
    const shared::Hit& hit = work_.hits[i];
    shared::ReusePixel& here = job_.now.pixels[p.index];
    here = shared::firstHitAt(job_.scene, hit);
    shared::CameraData cameraBefore = job_.before.camera;
    shared::ReuseChain chain = shared::noChain(ray.direction);
    if (FEATURE(shared::kFeatureDelta) &&
        (job_.scene.accel->world().features & shared::kFeatureDelta) != 0)
        chain = shared::followChain(job_.scene, job_.path, job_.settings, ray, hit.t, p.stream,
                                    here, cameraBefore, tally_);
    p.chained = chain.bounces > 0;
    if (p.chained) ray = shared::rayOfChain(job_.scene, chain, here);
    sums.seen = chain.seen;
    if (chain.restBounces > 0) work_.rest.push_back({i, shared::restOfChain(chain)});
    p.source = -1;
    if (!shared::beginReuse(job_.scene, job_.path, ray, here, p.v, sums.seen)) return false;
    p.path = shared::settingsAfter(job_.path, chain.bounces);
    p.motion = shared::motionAt(job_.scene, shared::movedPieces(job_.settings), here.slot,
                                here.barycentrics);
    if (!p.chained) {
        cameraBefore = shared::movedCamera(cameraBefore, p.motion);
        chain.towardsBefore = shared::towardsCamera(cameraBefore, p.v.vertex.surface.position);
    }
    p.source = findHistory(p, chain, cameraBefore);
    if (p.source >= 0) {
        shared::takeHistory(job_.scene, job_.settings, chain.towardsBefore,
                            job_.before.pixels[size_t(p.source)], p.motion, p.v);
    } else {
        p.v.rays = shared::raysDue(job_.settings, p.v.history, 0);
        p.v.history.credit = shared::firstCredit(p.stream);
    }
    sums.beta = p.v.beta;
    sums.nominal = p.v.c > 0 ? p.v.history.nominal : 0;
    sums.rays = p.v.rays;
    return true;
}

/// How many paths a pixel takes, and what each counts as.
void TileEstimator::countPaths(Pixel& p, shared::ReuseSums& sums) const
{
    p.deviation = shared::kNoDeviation;
    float part = 1;
    if (p.source >= 0) {
        p.deviation = job_.before.maps[size_t(p.source)].deviation;
        sums.noise = deviationAround(size_t(p.source));
        part = shared::allocatedPart(job_.settings, job_.perDeviation, sums.noise);
    }
    p.taken = shared::takeRays(job_.settings, p.v.rays * part, p.v.history);
    sums.part = shared::partOfPath(p.v.rays, p.taken);
}

/// The new paths of all pixels, and the ways not taken.
void TileEstimator::takePaths()
{
    NewPaths paths(job_.scene, job_.settings, tally_);
    work_.fresh.clear();
    const auto trace = [&] {
        for (const NewPath& path : paths.trace()) add(path);
    };
    const shared::PathSettings restSettings = shared::restSettings(job_.path);
    for (const RestWay& rest : work_.rest)
        paths.addRest(rest.pixel, restSettings,
                      shared::purposeStream(work_.pixels[rest.pixel].stream, shared::kPurposeRest),
                      rest.ray);
    size_t fresh = 0;
    for (uint32_t i = 0; i < sums_.size(); ++i) {
        Pixel& p = work_.pixels[i];
        p.fresh = fresh;
        fresh += p.taken;
        for (uint32_t k = 0; k < p.taken; ++k) {
            if (paths.isFull()) trace();
            paths.add(i, p.v, p.path, shared::pathStream(job_.settings, p.stream, p.v.rays, k));
        }
    }
    trace();
}

/// Adds what a path has brought to its pixel.
void TileEstimator::add(const NewPath& path)
{
    shared::ReuseSums& sums = sums_[path.pixel];
    if (!path.v) {
        sums.rest = path.gathered;
        return;
    }
    shared::ReuseNew found = path.result;
    shared::countAsPart(sums.part, found);
    if (keepsSamples())
        work_.fresh.push_back(found);
    else
        shared::addReuseNew(sums, found);
}

/// What old samples add to new ones, and what is kept of both.
void TileEstimator::finish(Pixel& p, shared::ReuseSums& sums) const
{
    float deviation = shared::kNoDeviation;
    if (p.scatters) {
        if (keepsSamples()) keepSamples(p, std::span(work_.fresh).subspan(p.fresh, p.taken), sums);
        if (keepsMeans()) keepMean(p, sums);
        deviation = shared::grownDeviation(sums, p.v.history.nominal, p.deviation);
        job_.now.pixels[p.index].history = shared::packHistory(shared::grownHistory(
            job_.settings, p.v.history, p.v.rays, shared::narrowestLobe(p.v.vertex.bsdf)));
    } else {
        if (keepsMeans())
            job_.now.means[p.index] = shared::keptMean(sums.seen + sums.rest, vec3(0));
        if (shared::carriesRemainder(job_.settings)) job_.now.remainders[p.index] = vec3(0);
    }
    job_.now.maps[p.index] = shared::reuseMap(sums, job_.settings.strategy, deviation);
}

/// Mean deviation of the pixels around one of the view before.
float TileEstimator::deviationAround(size_t source) const
{
    if (!shared::allocatesPaths(job_.settings)) return shared::kNoDeviation;
    const glm::ivec2 size(job_.before.size);
    const glm::ivec2 middle(int(source) % size.x, int(source) / size.x);
    float sum = 0, count = 0;
    for (uint32_t k = 0; k < 9; ++k) {
        const glm::ivec2 at = middle + shared::historyOffset(k);
        if (at.x < 0 || at.y < 0 || at.x >= size.x || at.y >= size.y) continue;
        const float deviation =
            job_.before.maps[size_t(at.y) * job_.before.size.x + size_t(at.x)].deviation;
        if (!(deviation >= 0)) continue;
        sum += deviation;
        ++count;
    }
    return count > 0 ? sum / count : shared::kNoDeviation;
}

/// The pixel of the view before whose history belongs to this first hit; -1: there is none.
/// `cameraBefore` is the one of that view, or where it appears to be. What is seen through
/// curved glass is not where a camera would see it without: it may be far away on the same
/// surface.
ptrdiff_t TileEstimator::findHistory(const Pixel& p, const shared::ReuseChain& chain,
                                     const shared::CameraData& cameraBefore) const
{
    if (job_.before.size.x == 0 || !shared::looksBack(job_.settings) ||
        !(cameraBefore.tanHalfHeight > 0))
        return -1;
    vec2 film;
    const shared::SurfacePoint& surface = p.v.vertex.surface;
    const vec3 here = surface.position;
    if (!shared::projectToFilm(cameraBefore, vec2(job_.before.size), here, film)) return -1;
    const float distance = glm::length(here - cameraBefore.position);
    const glm::ivec2 size = job_.before.size;
    const glm::ivec2 middle = shared::historyPixelOf(
        size, film, shared::tapNumbers(job_.settings, p.stream, job_.magnified()),
        job_.magnified());
    if (!shared::isPixelOf(size, middle)) return -1;
    const float reach = p.chained
                            ? shared::reachOfHistory(cameraBefore, float(job_.before.size.y),
                                                     distance, chain.direction, surface.normal)
                            : shared::kInfinity;
    for (uint32_t k = 0; k < 9; ++k) {
        const glm::ivec2 at = middle + shared::historyOffset(k);
        if (!shared::isPixelOf(size, at)) continue;
        const ptrdiff_t source = ptrdiff_t(at.y) * size.x + at.x;
        if (shared::historyFits(job_.scene, job_.settings, cameraBefore,
                                job_.before.pixels[size_t(source)], surface, p.motion.piece,
                                distance, reach))
            return source;
    }
    return -1;
}

/// Adds up old samples and new ones, and keeps some of both.
void TileEstimator::keepSamples(Pixel& p, std::span<const shared::ReuseNew> fresh,
                                shared::ReuseSums& sums) const
{
    Competition<shared::ReuseSample> samples;
    Competition<shared::ReuseLight> lights;
    const bool carries = shared::carriesRemainder(job_.settings);
    if (p.source >= 0) {
        if (carries) shared::giveBack(p.v, job_.before.remainders[size_t(p.source)], sums);
        lookAtOld(p, samples, lights, sums);
    }
    for (const shared::ReuseNew& n : fresh) {
        shared::addReuseNew(sums, n);
        if (n.record.u > 0) samples.add(n.record, n.scale, n.scale * n.around);
        if (n.light.v > 0) lights.add(n.light, n.light.v, n.light.v * n.direct);
    }
    sums.remainder =
        samples.keep({&job_.now.samples[p.index * records_], records_}, &shared::ReuseSample::u,
                     job_.settings, sums.around, keepNumber(p.stream, 0));
    const vec3 ofLights =
        lights.keep({&job_.now.lights[p.index * lights_], lights_}, &shared::ReuseLight::v,
                    job_.settings, sums.direct, keepNumber(p.stream, 1));
    if (!shared::isUnbiased(job_.settings)) sums.remainder += ofLights;  // else not looked at again
    if (carries) job_.now.remainders[p.index] = shared::remainderNow(sums);
}

/// The mean of old light and new.
void TileEstimator::keepMean(const Pixel& p, const shared::ReuseSums& sums) const
{
    vec3 before = p.source >= 0 ? job_.before.means[size_t(p.source)] : vec3(0);
    // What is seen over mirrors or through glass has no other taps: it is not known where they
    // would lie.
    if (job_.settings.strategy == shared::kReuseSvgf && p.source >= 0 && !p.chained)
        before = meanOfTaps(p, before);
    job_.now.means[p.index] = shared::keptMean(shared::naiveMean(sums, before), before);
}

void TileEstimator::lookAtOld(Pixel& p, Competition<shared::ReuseSample>& samples,
                              Competition<shared::ReuseLight>& lights,
                              shared::ReuseSums& sums) const
{
    const auto source = size_t(p.source);
    for (uint32_t i = 0; i < records_; ++i) {
        shared::ReuseSample r = job_.before.samples[source * records_ + i];
        shared::ReuseView view;
        if (!shared::aimOldSample(job_.scene, job_.settings, p.v, r, view)) continue;
        if (job_.settings.strategy == shared::kReuseRejection &&
            !shared::survivesRejection(shared::rejectionNumber(p.stream, i), view))
            continue;
        const bool hidden =
            shared::oldSampleHides(job_.scene, job_.settings, p.v, view, p.stream, i, tally_);
        vec3 L = shared::unpackRgbe(r.radiance);
        if (shared::isEvaluated(job_.settings, r)) {
            const vec3 place = p.v.vertex.surface.position + view.distance * view.direction;
            if (!shared::arrivingIsOld(job_.scene, job_.settings, place, r)) continue;
            if (shared::showsElse(r, view)) continue;
            L = shared::evaluateArriving(job_.scene, p.path, job_.settings, p.v, r, view);
        }
        if (hidden) {
            shared::dropOldSample(sums, view, L);
            continue;
        }
        const vec3 brings = shared::addOldSample(sums, view, L);
        r.u = view.u * view.perPlace;
        samples.add(r, view.u * view.p, brings);
    }
    for (uint32_t i = 0; i < lights_; ++i) {
        shared::ReuseLight r = job_.before.lights[source * lights_ + i];
        if (!(r.v > 0)) continue;
        const vec3 brings = shared::addOldLight(job_.scene, p.path, job_.settings, p.v, p.stream, i,
                                                r, sums, tally_);
        if (r.v > 0) lights.add(r, r.v, brings);
    }
}

/// Mean of the four pixels around where the first hit was before, of those whose history fits;
/// `nearest` where none does.
vec3 TileEstimator::meanOfTaps(const Pixel& p, vec3 nearest) const
{
    const shared::SurfacePoint& s = p.v.vertex.surface;
    const shared::CameraData cameraBefore = shared::movedCamera(job_.before.camera, p.motion);
    vec2 film;
    shared::projectToFilm(cameraBefore, vec2(job_.before.size), s.position, film);
    const float distance = glm::length(s.position - cameraBefore.position);
    glm::vec4 sum(0);
    for (uint32_t k = 0; k < 4; ++k) {
        glm::ivec2 at;
        const float weight = shared::historyTap(film, k, at);
        if (at.x < 0 || at.y < 0 || at.x >= int(job_.before.size.x) ||
            at.y >= int(job_.before.size.y))
            continue;
        const size_t source = size_t(at.y) * job_.before.size.x + size_t(at.x);
        if (shared::historyFits(job_.scene, job_.settings, cameraBefore, job_.before.pixels[source],
                                s, p.motion.piece, distance, shared::kInfinity))
            sum += weight * glm::vec4(job_.before.means[source], 1);
    }
    return sum.w > 0.01f ? vec3(sum) / sum.w : nearest;
}

}  // namespace

}  // namespace core

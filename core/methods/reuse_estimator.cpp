// See reuse_estimator.h.
#include "core/methods/reuse_estimator.h"

#include <array>

#include "core/methods/reuse_settings.h"

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

MovedPiece fetchMovedPiece(const SceneView& scene, uint i)
{
    return static_cast<const core::TracedScene&>(scene).moved[i];
}

/// Slots are triangles here, those of both poses.
Triangle fetchTriangleBefore(const SceneView& scene, uint slot)
{
    const core::World& before = *static_cast<const core::TracedScene&>(scene).worldBefore;
    const WorldTriangle& t = before.triangles[slot];
    const auto vertex = [&](uint index) { return vec4(before.positions[index], 0.0f); };
    return {vertex(t.v0), vertex(t.v1), vertex(t.v2)};
}

}  // namespace shared

namespace core {

using glm::uvec2, glm::vec2, glm::vec3;

void ReuseStore::reset(uvec2 newSize, const ReuseParams& params)
{
    const size_t count = size_t(newSize.x) * newSize.y;
    pixels.resize(count);
    maps.resize(count);
    const bool keeps = shared::keepsSamples(uint32_t(params.reuse));
    samples.resize(keeps ? count * recordsKept(params) : 0);
    lights.resize(keeps ? count * lightsKept(params) : 0);
    means.resize(shared::keepsMeans(uint32_t(params.reuse)) ? count : 0);
    remainders.resize(carriesRemainder(params) ? count : 0);
    size = newSize;
}

static float keepNumber(const shared::SampleStream& stream, uint32_t dimension)
{
    return shared::streamFloat(shared::decisionStream(stream, shared::kPurposeResampling),
                               dimension);
}

/// Samples that compete for the places of a store.
template <class Record> struct ReuseEstimator::Competition {
    std::array<Record, shared::kReuseMostScores> records;
    std::array<float, shared::kReuseMostScores> weights;  // v
    std::array<vec3, shared::kReuseMostScores> brings;    // u F
    uint32_t count = 0;

    void add(const Record& record, float v, vec3 itBrings)
    {
        records[count] = record;
        weights[count] = v;
        brings[count++] = itBrings;
    }

    /// Keeps `out.size()` of them by threshold resampling; `weight` is the member that is paid,
    /// `mean` what all together have brought. Returns what they brought less what the kept ones
    /// bring.
    vec3 keep(std::span<Record> out, float Record::*weight, const shared::ReuseSettings& settings,
              vec3 mean, float xi) const
    {
        std::array<float, shared::kReuseMostScores> scores;
        vec3 remainder(0);
        for (uint32_t i = 0; i < count; ++i) {
            scores[i] =
                shared::reuseScore(settings, weights[i], shared::luminance(brings[i]), mean);
            remainder += brings[i];
        }
        const auto most = static_cast<uint32_t>(out.size());
        const float kappa = shared::reuseThreshold(scores.data(), count, most);
        float sum = 0;
        uint32_t kept = 0;
        for (uint32_t i = 0; i < count && kept < most; ++i) {
            if (!shared::usableDensity(scores[i])) continue;
            if (kappa > 0 && !shared::reuseKeep(sum, scores[i], kappa, xi)) continue;
            const float scale = kappa > 0 ? shared::reuseKeepScale(scores[i], kappa) : 1.0f;
            out[kept] = records[i];
            out[kept++].*weight *= scale;
            remainder -= scale * brings[i];
        }
        for (; kept < most; ++kept) out[kept].*weight = 0;
        return remainder;
    }
};

/// What is known of a pixel while it is estimated.
struct ReuseEstimator::Pixel {
    size_t index;
    shared::SampleStream stream;
    shared::ReuseTally& tally;
    shared::ReuseVertex v{};
    shared::PathSettings path{};  // what paths from the first hit may do
    ptrdiff_t source = -1;        // the pixel of the view before; -1: there is none
    bool chained = false;         // seen over mirrors or through glass
    shared::SurfaceMotion motion = shared::noMotion();
};

ReuseEstimator::ReuseEstimator(const Accel& accel, const ReuseStore& before, ReuseStore& now,
                               std::span<const shared::MovedPiece> moved,
                               const shared::PathSettings& path,
                               const shared::ReuseSettings& settings, float perDeviation,
                               uint32_t firstSample)
    : scene_{sceneView(accel.world()), &accel, before.world.get(), moved}, before_(before),
      now_(now), path_(path), settings_(settings), perDeviation_(perDeviation),
      records_(shared::recordsOf(settings)), lights_(shared::lightsOf(settings)),
      firstSample_(firstSample)
{
    settings_.flags |= static_cast<uint32_t>(moved.size()) << shared::kReuseMovedShift;
}

shared::ReuseSums ReuseEstimator::estimate(uvec2 pixel, shared::ReuseTally& tally) const
{
    const size_t index = size_t(pixel.y) * now_.size.x + pixel.x;
    shared::ReuseSums sums = shared::noReuseSums();
    Pixel p{index,
            shared::makeStream(path_.samplerKind, path_.seed, pixel, firstSample_,
                               shared::kPurposePath),
            tally};
    float deviation = shared::kNoDeviation;
    if (findVertex(pixel, p, sums)) {
        float part = 1;
        if (p.source >= 0) {
            deviation = before_.maps[size_t(p.source)].deviation;
            sums.noise = deviationAround(size_t(p.source));
            part = shared::allocatedPart(settings_, perDeviation_, sums.noise);
        }
        const uint32_t taken = shared::takeRays(settings_, p.v.rays * part, p.v.history);
        sums.part = shared::partOfPath(p.v.rays, taken);
        takePaths(p, taken, sums);
        deviation = shared::grownDeviation(sums, p.v.history.nominal, deviation);
        now_.pixels[index].history = shared::packHistory(shared::grownHistory(
            settings_, p.v.history, p.v.rays, shared::narrowestLobe(p.v.vertex.bsdf)));
    } else {
        if (keepsMeans()) now_.means[index] = sums.seen + sums.rest;
        if (shared::carriesRemainder(settings_)) now_.remainders[index] = vec3(0);
    }
    now_.maps[index] = shared::reuseMap(sums, settings_.strategy, deviation);
    return sums;
}

/// New paths, what old samples add to them, and what is kept of both.
void ReuseEstimator::takePaths(Pixel& p, uint32_t taken, shared::ReuseSums& sums) const
{
    std::array<shared::ReuseNew, shared::kReuseMostRays> fresh;
    for (uint32_t k = 0; k < taken; ++k) {
        shared::ReuseNew found =
            shared::takePath(scene_, p.path, settings_, p.v,
                             shared::pathStream(settings_, p.stream, p.v.rays, k), p.tally);
        shared::countAsPart(sums.part, found);
        if (keepsSamples()) {
            fresh[k] = found;
        } else {
            shared::addReuseNew(sums, found);
        }
    }
    if (keepsSamples()) keepSamples(p, std::span(fresh).first(taken), sums);
    if (keepsMeans()) keepMean(p, sums);
}

/// Mean deviation of the pixels around one of the view before.
float ReuseEstimator::deviationAround(size_t source) const
{
    if (!shared::allocatesPaths(settings_)) return shared::kNoDeviation;
    const glm::ivec2 size(before_.size);
    const glm::ivec2 middle(int(source) % size.x, int(source) / size.x);
    float sum = 0, count = 0;
    for (uint32_t k = 0; k < 9; ++k) {
        const glm::ivec2 at = middle + shared::historyOffset(k);
        if (at.x < 0 || at.y < 0 || at.x >= size.x || at.y >= size.y) continue;
        const float deviation =
            before_.maps[size_t(at.y) * before_.size.x + size_t(at.x)].deviation;
        if (!(deviation >= 0)) continue;
        sum += deviation;
        ++count;
    }
    return count > 0 ? sum / count : shared::kNoDeviation;
}

/// The first hit of a pixel and its history, and what comes to the camera beside its light.
/// False where nothing is scattered.
bool ReuseEstimator::findVertex(uvec2 pixel, Pixel& p, shared::ReuseSums& sums) const
{
    shared::PathState ray = shared::pixelRay(now_.camera, path_, settings_, pixel, p.stream);
    shared::ReusePixel& here = now_.pixels[p.index];
    float t;
    here = shared::findFirstHit(scene_, ray, p.stream, t);
    shared::CameraData cameraBefore = before_.camera;
    shared::ReuseChain chain = shared::noChain(ray.direction);
    if ((scene_.accel->world().features & shared::kFeatureDelta) != 0)
        chain = shared::followChain(scene_, path_, settings_, ray, t, p.stream, here, cameraBefore,
                                    p.tally);
    p.chained = chain.bounces > 0;
    if (p.chained) ray = shared::rayOfChain(scene_, chain, here);
    sums.seen = chain.seen;
    if (chain.restBounces > 0) sums.rest = takeRest(chain, p);
    if (!shared::beginReuse(scene_, path_, ray, here, p.v, sums.seen)) return false;
    p.path = shared::settingsAfter(path_, chain.bounces);
    p.motion =
        shared::motionAt(scene_, shared::movedPieces(settings_), here.slot, here.barycentrics);
    if (!p.chained) {
        cameraBefore = shared::movedCamera(cameraBefore, p.motion);
        chain.towardsBefore = shared::towardsCamera(cameraBefore, p.v.vertex.surface.position);
    }
    p.source = findHistory(p, chain, cameraBefore);
    if (p.source >= 0) {
        shared::takeHistory(scene_, settings_, chain.towardsBefore,
                            before_.pixels[size_t(p.source)], p.motion, p.v);
    } else {
        p.v.rays = shared::raysDue(settings_, p.v.history, 0);
        p.v.history.credit = shared::firstCredit(p.stream);
    }
    sums.beta = p.v.beta;
    sums.nominal = p.v.c > 0 ? p.v.history.nominal : 0;
    sums.rays = p.v.rays;
    return true;
}

vec3 ReuseEstimator::takeRest(const shared::ReuseChain& chain, Pixel& p) const
{
    const shared::SampleStream stream = shared::purposeStream(p.stream, shared::kPurposeRest);
    return shared::takeRest(scene_, shared::restSettings(path_), settings_,
                            shared::restOfChain(chain), stream, p.tally);
}

/// The pixel of the view before whose history belongs to this first hit; -1: there is none.
/// `cameraBefore` is the one of that view, or where it appears to be. What is seen through
/// curved glass is not where a camera would see it without: it may be far away on the same
/// surface.
ptrdiff_t ReuseEstimator::findHistory(const Pixel& p, const shared::ReuseChain& chain,
                                      const shared::CameraData& cameraBefore) const
{
    if (before_.size.x == 0 || !shared::looksBack(settings_) || !(cameraBefore.tanHalfHeight > 0))
        return -1;
    vec2 film;
    const shared::SurfacePoint& surface = p.v.vertex.surface;
    const vec3 here = surface.position;
    if (!shared::projectToFilm(cameraBefore, vec2(before_.size), here, film)) return -1;
    const float distance = glm::length(here - cameraBefore.position);
    const glm::ivec2 middle = shared::historyPixel(film, shared::tapNumbers(settings_, p.stream));
    const float reach = p.chained
                            ? shared::reachOfHistory(cameraBefore, float(before_.size.y), distance,
                                                     chain.direction, surface.normal)
                            : shared::kInfinity;
    for (uint32_t k = 0; k < 9; ++k) {
        const glm::ivec2 at = middle + shared::historyOffset(k);
        if (at.x < 0 || at.y < 0 || at.x >= int(before_.size.x) || at.y >= int(before_.size.y))
            continue;
        const ptrdiff_t source = ptrdiff_t(at.y) * before_.size.x + at.x;
        if (shared::historyFits(scene_, settings_, cameraBefore, before_.pixels[size_t(source)],
                                surface, p.motion.piece, distance, reach))
            return source;
    }
    return -1;
}

/// Adds up old samples and new ones, and keeps some of both.
void ReuseEstimator::keepSamples(Pixel& p, std::span<const shared::ReuseNew> fresh,
                                 shared::ReuseSums& sums) const
{
    Competition<shared::ReuseSample> samples;
    Competition<shared::ReuseLight> lights;
    const bool carries = shared::carriesRemainder(settings_);
    if (p.source >= 0) {
        if (carries) shared::giveBack(p.v, before_.remainders[size_t(p.source)], sums);
        lookAtOld(p, samples, lights, sums);
    }
    for (const shared::ReuseNew& n : fresh) {
        shared::addReuseNew(sums, n);
        if (n.record.u > 0) samples.add(n.record, n.scale, n.scale * n.around);
        if (n.light.v > 0) lights.add(n.light, n.light.v, n.light.v * n.direct);
    }
    sums.remainder =
        samples.keep({&now_.samples[p.index * records_], records_}, &shared::ReuseSample::u,
                     settings_, sums.around, keepNumber(p.stream, 0));
    const vec3 ofLights =
        lights.keep({&now_.lights[p.index * lights_], lights_}, &shared::ReuseLight::v, settings_,
                    sums.direct, keepNumber(p.stream, 1));
    if (!shared::isUnbiased(settings_)) sums.remainder += ofLights;  // else not looked at again
    if (carries) now_.remainders[p.index] = shared::remainderNow(sums);
}

/// The mean of old light and new.
void ReuseEstimator::keepMean(const Pixel& p, const shared::ReuseSums& sums) const
{
    vec3 before = p.source >= 0 ? before_.means[size_t(p.source)] : vec3(0);
    // What is seen over mirrors or through glass has no other taps: it is not known where they
    // would lie.
    if (settings_.strategy == shared::kReuseSvgf && p.source >= 0 && !p.chained)
        before = meanOfTaps(p, before);
    now_.means[p.index] = shared::naiveMean(sums, before);
}

void ReuseEstimator::lookAtOld(Pixel& p, Competition<shared::ReuseSample>& samples,
                               Competition<shared::ReuseLight>& lights,
                               shared::ReuseSums& sums) const
{
    const auto source = size_t(p.source);
    for (uint32_t i = 0; i < records_; ++i) {
        shared::ReuseSample r = before_.samples[source * records_ + i];
        shared::ReuseView view;
        if (!shared::aimOldSample(scene_, settings_, p.v, r, view)) continue;
        if (!shared::survivesRejection(shared::rejectionNumber(p.stream, i), view)) continue;
        const bool hidden =
            shared::oldSampleHides(scene_, settings_, p.v, view, p.stream, i, p.tally);
        vec3 L = shared::unpackRgbe(r.radiance);
        if (shared::isEvaluated(settings_, r)) {
            const vec3 place = p.v.vertex.surface.position + view.distance * view.direction;
            if (!shared::arrivingIsOld(scene_, settings_, place, r)) continue;
            if (shared::showsElse(r, view)) continue;
            L = shared::evaluateArriving(scene_, p.path, settings_, p.v, r, view);
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
        shared::ReuseLight r = before_.lights[source * lights_ + i];
        if (!(r.v > 0)) continue;
        const vec3 brings =
            shared::addOldLight(scene_, p.path, settings_, p.v, p.stream, i, r, sums, p.tally);
        if (r.v > 0) lights.add(r, r.v, brings);
    }
}

/// Mean of the four pixels around where the first hit was before, of those whose history fits;
/// `nearest` where none does.
vec3 ReuseEstimator::meanOfTaps(const Pixel& p, vec3 nearest) const
{
    const shared::SurfacePoint& s = p.v.vertex.surface;
    const shared::CameraData cameraBefore = shared::movedCamera(before_.camera, p.motion);
    vec2 film;
    shared::projectToFilm(cameraBefore, vec2(before_.size), s.position, film);
    const float distance = glm::length(s.position - cameraBefore.position);
    glm::vec4 sum(0);
    for (uint32_t k = 0; k < 4; ++k) {
        glm::ivec2 at;
        const float weight = shared::historyTap(film, k, at);
        if (at.x < 0 || at.y < 0 || at.x >= int(before_.size.x) || at.y >= int(before_.size.y))
            continue;
        const size_t source = size_t(at.y) * before_.size.x + size_t(at.x);
        if (shared::historyFits(scene_, settings_, cameraBefore, before_.pixels[source], s,
                                p.motion.piece, distance, shared::kInfinity))
            sum += weight * glm::vec4(before_.means[source], 1);
    }
    return sum.w > 0.01f ? vec3(sum) / sum.w : nearest;
}

}  // namespace core

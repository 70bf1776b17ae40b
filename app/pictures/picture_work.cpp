// Rules of a picture: the first sample is shown at once, parts of a slow one every third of a
// second; then showing and measuring may cost 15 % of the time each; the curve of errors gets a
// point each time the samples have grown by a fifth, or doubled where that would cost more; what
// points and pictures cost does not count as rendering.
#include "app/pictures/picture_work.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/pictures/error_point.h"
#include "app/pictures/fine_light.h"
#include "app/pictures/preview_shading.h"
#include "app/pictures/spread_light.h"
#include "core/base/time.h"
#include "core/image/metrics.h"
#include "core/methods/method.h"

namespace app {

namespace {

constexpr double kPieceStill = 0.02, kPieceMoving = 0.008;  // seconds of one dispatch
constexpr double kPieceBridged = 0.016;     // and of one where surfaces may be shown in between
constexpr double kLeastBridged = 1.0 / 60;  // seconds of light before they are
constexpr double kWorthBridging = 0.5;      // of the time for surfaces that a motion gains by it
constexpr double kCallSeconds = 0.1;        // of one call of the renderer
constexpr double kFirstLookSeconds = 0.05;  // of the small sample that comes first
constexpr double kOverhead = 0.15;
constexpr double kLeastForPaths = 0.5;  // of the time of a picture in motion
constexpr double kGrowthBetweenPoints = 1.2;

/// What has the edges and textures of a coarse picture: what is seen behind panes and in mirrors,
/// but for who looks at first hits themselves.
core::Sight sightOf(const RenderRequest& request)
{
    return request.wantAovs ? core::Sight::first : core::Sight::clear;
}

}  // namespace

Change changeBetween(const RenderRequest& from, const RenderRequest& to)
{
    const RenderParams &a = from.params, &b = to.params;
    if (a.device != b.device || a.deviceIndex != b.deviceIndex || a.method.id() != b.method.id() ||
        from.validation != to.validation) {
        return Change::renderer;
    }
    if (from.world != to.world) return Change::world;
    const bool same = from.camera == to.camera && from.size == to.size && sameRendering(a, b) &&
                      from.restarts == to.restarts;
    return same ? Change::nothing : Change::view;
}

void PictureWork::begin(core::Renderer& renderer, const RenderRequest& request, Coarse coarse,
                        core::Start start, ResolutionControl& control, double paceFactor)
{
    std::shared_ptr<const core::Image> backdrop = std::move(backdrop_);
    std::optional<KnownLight> known = std::move(light_);
    const MovingDetail detail = detail_;
    *this = {};
    detail_ = detail;
    if (coarse == Coarse::moving && start == core::Start::moved) light_ = std::move(known);
    coarse_ = coarse;
    if (!quick()) backdrop_ = std::move(backdrop);
    shaded_ = coarse == Coarse::moving && request.movingShows == Moving::shaded;
    core::AnyParams params = request.params.method;
    const core::MethodInfo& method = core::methodNamed(params.id());
    if (coarse == Coarse::moving && method.whileMoving != nullptr)
        params = method.whileMoving(params);
    uint32_t* const depth = core::findParam<uint32_t>(params, "max-depth");
    depth_ = depth != nullptr ? *depth : 1;
    size_ = request.size;
    if (coarse == Coarse::half) {
        scale_ = 0.5f;
        size_ = glm::max(size_ / 2u, glm::uvec2(1));
    } else if (quick()) {
        // Samples that are kept from view to view must be those of one kind of path.
        const bool keeps = method.traits.keepsOnMove;
        if (shaded_)
            depth_ = 0;
        else if (coarse == Coarse::moving && !keeps)
            depth_ = std::min(depth_, request.movingDepth);
        double target = coarse == Coarse::moving ? request.targetFrameSeconds : kFirstLookSeconds;
        const bool detailed = !shaded_ && MovingDetail::wanted(request);
        if (detailed) {
            fineSize_ = detail_.affordable(request.size, target);
            target = std::max(target - detail_.seconds(fineSize_), kLeastForPaths * target);
        }
        const PreviewSize preview = control.choose(request.size, depth_, target, {keeps, detailed});
        size_ = preview.size;
        detailed_ = detailed && fineSize_.x > size_.x;
        scale_ = preview.scale;
        depth_ = preview.depth;
    }
    if (depth != nullptr && !shaded_) *depth = depth_;
    const double light = control.predict(double(size_.x) * size_.y, depth_);
    bridged_ = light_ && detailed_ &&
               light > secondsBeforeAhead() + kWorthBridging * detail_.seconds(fineSize_);
    // The first sample of a small picture is finished whatever comes.
    const double piece = bridges() ? kPieceBridged : quick() ? kPieceMoving : kPieceStill;
    pace_ = {.dispatchSeconds = piece * paceFactor, .whole = quick() && !bridges()};
    renderer.setPace(pace_);
    const bool centred = quick() && request.movingShows != Moving::path;
    renderer.setView({request.camera, size_, params, centred}, start);
    follows_ = start == core::Start::moved && method.traits.keepsOnMove;
    version_ = publishedVersion_ = renderer.progress().version;
    nextPoint_ = 2;
    begun_ = true;
}

/// What light gets before surfaces are shown without it: as long as they take themselves, at least.
double PictureWork::secondsBeforeAhead() const
{
    return std::max(detail_.seconds(fineSize_), kLeastBridged);
}

std::shared_ptr<Picture> PictureWork::look(core::Renderer& renderer, const RenderRequest& request,
                                           ResolutionControl& control)
{
    *this = {};
    const auto start = Clock::now();
    const PreviewSize preview = control.choose(request.size, 0, kFirstLookSeconds);
    renderer.setPace({.dispatchSeconds = kPieceMoving});
    const std::optional<core::Aovs> aovs =
        renderer.look({request.camera, preview.size, request.params.method});
    if (!aovs) return nullptr;
    auto picture = std::make_shared<Picture>();
    picture->mean = litFromCamera(*aovs, request.camera);
    picture->guide = std::make_shared<const core::Image>(surfaceGuide(*aovs));
    picture->shaded = picture->preview = true;
    picture->samples = 1;
    picture->seconds = core::secondsSince(start);
    describe(*picture, renderer, request);
    scale_ = preview.scale;
    return picture;
}

/// What a picture is of.
void PictureWork::describe(Picture& picture, const core::Renderer& renderer,
                           const RenderRequest& request) const
{
    picture.follows = follows_;
    picture.world = request.world;
    picture.scene = request.world->scene;
    picture.time = request.world->time;
    picture.camera = request.camera;
    picture.fullSize = request.size;
    picture.params = request.params;
    picture.restarts = request.restarts;
    picture.stats = renderer.stats();
}

uint32_t PictureWork::nextCount(const RenderRequest& request) const
{
    if (samples_ == 0 || coarse_ != Coarse::no) return 1;
    // The first sample may have warmed something up: it does not tell the rate once there are
    // others.
    const double each =
        samples_ == 1 ? seconds_ : (seconds_ - firstSeconds_) / double(samples_ - 1);
    double most = kCallSeconds / std::max(each, 1e-9);
    const RenderParams& limits = request.params;
    if (limits.secondsLimit > 0)
        most = std::min(most, std::ceil((limits.secondsLimit - seconds_) / std::max(each, 1e-9)));
    if (limits.sppLimit > 0) most = std::min(most, double(limits.sppLimit) - double(samples_));
    // For a point, whatever it costs
    const uint64_t latest = curve_.empty() ? 2 : 2 * curve_.back().samples;
    for (const uint64_t point : {nextPoint_, latest}) {
        if (point > samples_) most = std::min(most, double(point - samples_));
    }
    return static_cast<uint32_t>(std::clamp(most, 1.0, 4096.0));
}

void PictureWork::advance(core::Renderer& renderer, const RenderRequest& request,
                          ResolutionControl& control, std::stop_token stop)
{
    estimate_.reset();
    if (shaded_) return advanceShaded(renderer, request, control);
    const auto start = Clock::now();
    core::Budget budget{.samples = nextCount(request)};
    if (!quick()) budget.seconds = kCallSeconds;
    if (bridges()) budget.seconds = secondsBeforeAhead();
    renderer.advance(budget, stop);
    const core::RenderProgress now = renderer.progress();
    const bool some = now.samples > 0 || (now.fraction > 0 && coarse_ == Coarse::half);
    if (some && !aovs_ && (coarse_ == Coarse::moving || detailed_ || spreads(request)))
        aovs_ = surfaces(renderer, request);
    const double seconds = core::secondsSince(start);
    if (now.version == version_) return;
    version_ = now.version;
    fraction_ = now.fraction;
    seconds_ += seconds;
    stepSeconds_ += seconds;
    if (now.samples <= samples_) return;
    if (samples_ > 0 || coarse_ != Coarse::no) {
        control.observe(double(now.samples - samples_) * size_.x * size_.y, depth_, stepSeconds_,
                        quick());
    }
    if (samples_ == 0) firstSeconds_ = stepSeconds_;
    if (std::exchange(pace_.whole, false)) renderer.setPace(pace_);
    samples_ = now.samples;
    stepSeconds_ = 0;
}

/// Those that the pixels of this picture show.
std::shared_ptr<const core::Aovs> PictureWork::surfaces(core::Renderer& renderer,
                                                        const RenderRequest& request) const
{
    return std::make_shared<core::Aovs>(renderer.surfaces(request.camera, size_, sightOf(request)));
}

/// Surfaces are found at once, whole.
void PictureWork::advanceShaded(core::Renderer& renderer, const RenderRequest& request,
                                ResolutionControl& control)
{
    if (samples_ > 0) return;
    const auto start = Clock::now();
    aovs_ = surfaces(renderer, request);
    seconds_ = core::secondsSince(start);
    control.observe(double(size_.x) * size_.y, 0, seconds_, true);
    samples_ = 1;
    version_ = publishedVersion_ + 1;
}

/// Whether the light of a coarse picture's few samples is averaged over surfaces: not for who wants
/// paths alone, nor where all pixels have the light of all.
bool PictureWork::spreads(const RenderRequest& request) const
{
    const core::Traits& traits = core::methodNamed(request.params.method.id()).traits;
    return coarse_ != Coarse::no && !shaded_ && request.movingShows != Moving::path &&
           traits.radiance && !traits.sharesLight;
}

/// What makes a coarse picture easier to read than its few pixels are.
void PictureWork::addPreview(core::Renderer& renderer, Picture& picture,
                             const RenderRequest& request, const core::Camera& ahead)
{
    if (!aovs_ || !fits(*aovs_, picture.mean)) return;
    if (shaded_) {
        picture.mean = litFromCamera(*aovs_, request.camera);
        picture.shaded = true;
    } else if (spreads(request)) {
        spreadLight(picture.mean, *aovs_, request.camera);
    } else if (request.movingShows != Moving::path && coarse_ == Coarse::moving &&
               core::methodNamed(request.params.method.id()).traits.radiance) {
        fillUnlit(picture.mean, *aovs_, request.camera);
    }
    if (detailed_) {
        const core::Camera shown = light_ ? light_->shown : request.camera;
        light_ = {std::move(picture.mean), aovs_, request.camera, shown};
        addDetail(renderer, picture, request, ahead);
    }
    picture.guide = std::make_shared<const core::Image>(surfaceGuide(fine_ ? *fine_ : *aovs_));
}

/// The newest light on surfaces that are finer, as `ahead` sees them. Made again a picture keeps
/// them, and none goes back to a camera before the one on show.
void PictureWork::addDetail(core::Renderer& renderer, Picture& picture,
                            const RenderRequest& request, const core::Camera& ahead)
{
    const auto start = Clock::now();
    KnownLight& light = *light_;
    const bool keeps = fine_ && (published_ > 0 || ahead == request.camera || ahead == light.shown);
    if (!keeps) {
        fine_ = std::make_shared<const core::Aovs>(
            renderer.surfaces(ahead, fineSize_, sightOf(request)));
        light.shown = ahead;
    }
    picture.mean = lightOnSurfaces(light.mean, {*light.aovs, light.camera}, {*fine_, light.shown});
    picture.sampled = {light.mean.width, light.mean.height};
    picture.camera = light.shown;
    if (!keeps) detail_.observe(fineSize_, core::secondsSince(start));
}

std::shared_ptr<Picture> PictureWork::makeAhead(core::Renderer& renderer,
                                                const RenderRequest& request,
                                                const core::Camera& ahead)
{
    // Pictures with numbers beside them are those of whole samples.
    const bool numbers = request.wantAovs || request.wantMaps || request.wantVariance;
    if (!bridges() || numbers || ahead == light_->shown) return nullptr;
    auto picture = std::make_shared<Picture>();
    describe(*picture, renderer, request);
    addDetail(renderer, *picture, request, ahead);
    picture->guide = std::make_shared<const core::Image>(surfaceGuide(*fine_));
    picture->preview = true;
    picture->samples = 1;
    picture->seconds = seconds_;
    return picture;
}

void PictureWork::readEverything(core::Renderer& renderer)
{
    if (!estimate_) estimate_ = renderer.read(core::Reading::everything);
}

/// Pixels that have had no sample show the small picture that came before.
void PictureWork::fillFromBackdrop(core::Estimate& estimate) const
{
    if (!backdrop_ || backdrop_->width == 0 || backdrop_->height == 0) return;
    core::Image& mean = estimate.mean;
    for (uint32_t y = 0; y < mean.height; ++y) {
        const uint64_t v = uint64_t(y) * backdrop_->height / mean.height;
        for (uint32_t x = 0; x < mean.width; ++x) {
            if (*estimate.weight.at(x, y) > 0) continue;
            const uint64_t u = uint64_t(x) * backdrop_->width / mean.width;
            std::copy_n(backdrop_->at(uint32_t(u), uint32_t(v)), 3, mean.at(x, y));
        }
    }
}

bool PictureWork::limitReached(const RenderRequest& request) const
{
    const RenderParams& limits = request.params;
    if (limits.sppLimit > 0 && samples_ >= limits.sppLimit) return true;
    if (limits.secondsLimit > 0 && seconds_ >= limits.secondsLimit) return true;
    if (limits.errorLimit <= 0 || curve_.empty()) return false;
    const ErrorPoint& point = curve_.back();
    if (point.rmse > 0) return point.rmse <= limits.errorLimit;
    return point.samples >= core::kFewestForNoise && point.estimated <= limits.errorLimit;
}

void PictureWork::forgetReference()
{
    for (ErrorPoint& point : curve_) point.rmse = point.rmseSe = 0;
}

bool PictureWork::measureError(core::Renderer& renderer, const RenderRequest& request, bool force)
{
    if (coarse_ != Coarse::no || samples_ == 0 || fraction_ > 0) return false;
    const bool limit = limitReached(request);
    const bool known = !curve_.empty() && curve_.back().samples == samples_;
    const bool doubled = !curve_.empty() && samples_ >= 2 * curve_.back().samples;
    const bool grown = samples_ >= nextPoint_ && (doubled || pointSeconds_ <= kOverhead * seconds_);
    const bool measures = force || grown || (limit && !known);
    if (measures) {
        const auto start = Clock::now();
        readEverything(renderer);
        addPoint(curve_, errorPoint(*estimate_, seconds_, request.reference.get()));
        nextPoint_ =
            std::max(samples_ + 1,
                     static_cast<uint64_t>(std::ceil(kGrowthBetweenPoints * double(samples_))));
        pointSeconds_ += core::secondsSince(start);
    }
    finished_ = limitReached(request);
    return measures;
}

bool PictureWork::due() const
{
    if (!presentable() || publishedVersion_ == version_) return false;
    if (samples_ > published_ && (published_ == 0 || finished_)) return true;
    // Of slow samples each whole one is seen: only those can be saved, and none may be left out.
    if (samples_ > published_ && fraction_ == 0 && seconds_ > 0.3 * double(samples_)) return true;
    // An old picture changes little; a part of a sample changes a part of it.
    const double age = samples_ > published_ ? std::clamp(0.03 * seconds_, 1.0 / 30, 0.3) : 0.3;
    return core::secondsSince(publishedAt_) >= std::max(age, publishSeconds_ / kOverhead);
}

std::shared_ptr<Picture> PictureWork::make(core::Renderer& renderer, const RenderRequest& request,
                                           const core::Camera& ahead)
{
    const auto start = Clock::now();
    auto picture = std::make_shared<Picture>();
    const bool holes = samples_ == 0;
    if (request.wantVariance || holes) readEverything(renderer);
    const bool meanOnly = !estimate_;
    core::Estimate estimate = meanOnly ? renderer.read(core::Reading::mean) : *estimate_;
    if (holes) fillFromBackdrop(estimate);
    picture->mean = std::move(estimate.mean);
    picture->counters = estimate.counters;
    if (request.wantVariance)
        picture->variance = std::make_shared<core::Image>(std::move(estimate.variance));
    describe(*picture, renderer, request);
    if (coarse_ != Coarse::no) addPreview(renderer, *picture, request, ahead);
    if (coarse_ != Coarse::no && !shaded_ && !holes)
        backdrop_ = std::make_shared<core::Image>(picture->mean);
    if (request.wantAovs && !aovs_) aovs_ = std::make_shared<core::Aovs>(renderer.aovs());
    if (request.wantAovs) picture->aovs = fine_ ? fine_ : aovs_;
    if (request.wantMaps) {
        picture->maps = std::make_shared<const std::vector<core::Image>>(renderer.maps());
        picture->probe = renderer.probe();
    }
    picture->samples = samples_;
    picture->fraction = fraction_;
    picture->seconds = seconds_;
    picture->preview = coarse_ != Coarse::no || holes;
    picture->black = !picture->preview &&
                     std::ranges::none_of(picture->mean.pixels, [](float x) { return x > 0; });
    picture->finished = finished_;
    picture->curve = curve_;
    published_ = samples_;
    publishedVersion_ = version_;
    publishedAt_ = Clock::now();
    publishSeconds_ = core::secondsSince(start);
    return picture;
}

}  // namespace app

// Rules of a picture: the first sample is shown at once; then showing and judging may cost 15 % of
// the time each; the curve of errors gets a point each time the samples have grown by a fifth, or
// doubled where that would cost more; what points and pictures cost does not count as rendering.
#include "app/session/picture_work.h"

#include <algorithm>
#include <cmath>

#include "app/session/error_point.h"

namespace app {

namespace {

constexpr double kPieceStill = 0.02, kPieceMoving = 0.008;  // seconds of one dispatch
constexpr double kStepSeconds = 0.1;                        // of one call of the renderer
constexpr double kFirstLookSeconds = 0.05;                  // of the small sample that comes first
constexpr double kOverhead = 0.15;
constexpr double kGrowth = 1.2;
constexpr uint64_t kFewestForEstimate = 8;  // samples below which their own spread says too little

double since(PictureWork::Clock::time_point start)
{
    return std::chrono::duration<double>(PictureWork::Clock::now() - start).count();
}

RenderParams withoutLimits(RenderParams params)
{
    params.sppLimit = 0;
    params.secondsLimit = params.errorLimit = 0;
    return params;
}

}  // namespace

Change changeBetween(const RenderRequest& from, const RenderRequest& to)
{
    const RenderParams a = withoutLimits(from.params), b = withoutLimits(to.params);
    if (a.device != b.device || a.deviceIndex != b.deviceIndex || a.method != b.method ||
        from.validation != to.validation) {
        return Change::renderer;
    }
    if (from.world != to.world) return Change::world;
    const bool same =
        from.camera == to.camera && from.size == to.size && a == b && from.restarts == to.restarts;
    return same ? Change::nothing : Change::view;
}

void PictureWork::begin(core::Renderer& renderer, const RenderRequest& request, Coarse coarse,
                        ResolutionControl& control, double paceFactor)
{
    *this = {};
    coarse_ = coarse;
    core::PathParams params = request.params.path;
    size_ = request.size;
    if (coarse != Coarse::no) {
        if (coarse == Coarse::moving)
            params.maxDepth = std::min(params.maxDepth, request.movingDepth);
        const double target =
            coarse == Coarse::moving ? request.targetFrameSeconds : kFirstLookSeconds;
        const PreviewSize preview = control.choose(request.size, params.maxDepth, target);
        size_ = preview.size;
        scale_ = preview.scale;
        params.maxDepth = preview.depth;
    }
    depth_ = params.maxDepth;
    renderer.setPace(
        {.dispatchSeconds = (coarse == Coarse::no ? kPieceStill : kPieceMoving) * paceFactor,
         .discardOnStop = true});
    renderer.setView(request.camera, size_.x, size_.y, params);
    nextPoint_ = 2;
    begun_ = true;
}

uint32_t PictureWork::nextCount(const RenderRequest& request) const
{
    if (samples_ == 0 || coarse_ != Coarse::no) return 1;
    // The first sample may have warmed something up: it does not tell the rate once there are
    // others.
    const double each =
        samples_ == 1 ? seconds_ : (seconds_ - firstSeconds_) / double(samples_ - 1);
    double most = kStepSeconds / std::max(each, 1e-9);
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

bool PictureWork::advance(core::Renderer& renderer, const RenderRequest& request,
                          ResolutionControl& control, std::stop_token stop)
{
    film_.reset();
    const auto start = Clock::now();
    renderer.advance(nextCount(request), stop);
    const double seconds = since(start);
    const uint64_t now = renderer.samples();
    if (now <= samples_) {
        begun_ = now == samples_ && now > 0;  // a renderer may have kept what it had
        return begun_;
    }
    if (samples_ > 0 || coarse_ != Coarse::no) {
        control.observe(double(now - samples_) * size_.x * size_.y, depth_, seconds,
                        coarse_ != Coarse::no);
    }
    if (samples_ == 0) firstSeconds_ = seconds;
    samples_ = now;
    seconds_ += seconds;
    return true;
}

void PictureWork::readFilm(core::Renderer& renderer)
{
    if (film_) return;
    film_.emplace();
    renderer.readFilm(*film_);
    counters_ = film_->counters;
}

bool PictureWork::limitReached(const RenderRequest& request) const
{
    const RenderParams& limits = request.params;
    if (limits.sppLimit > 0 && samples_ >= limits.sppLimit) return true;
    if (limits.secondsLimit > 0 && seconds_ >= limits.secondsLimit) return true;
    if (limits.errorLimit <= 0 || curve_.empty()) return false;
    const ErrorPoint& point = curve_.back();
    if (point.rmse > 0) return point.rmse <= limits.errorLimit;
    return point.samples >= kFewestForEstimate && point.estimated <= limits.errorLimit;
}

void PictureWork::judge(core::Renderer& renderer, const RenderRequest& request, bool force)
{
    if (coarse_ != Coarse::no || samples_ == 0) return;
    const bool limit = limitReached(request);
    const bool known = !curve_.empty() && curve_.back().samples == samples_;
    const bool doubled = !curve_.empty() && samples_ >= 2 * curve_.back().samples;
    const bool grown = samples_ >= nextPoint_ && (doubled || pointSeconds_ <= kOverhead * seconds_);
    if (force || grown || (limit && !known)) {
        const auto start = Clock::now();
        readFilm(renderer);
        const core::Image mean = film_->mean(), variance = film_->varianceOfMean();
        addPoint(curve_, errorPoint(*film_, mean, variance, seconds_, request.reference.get()));
        nextPoint_ =
            std::max(samples_ + 1, static_cast<uint64_t>(std::ceil(kGrowth * double(samples_))));
        pointSeconds_ += since(start);
    }
    finished_ = limitReached(request);
}

bool PictureWork::due() const
{
    if (samples_ == 0 || published_ == samples_) return false;
    if (published_ == 0 || finished_) return true;
    const double age = std::clamp(0.03 * seconds_, 1.0 / 30, 0.3);  // an old picture changes little
    return since(publishedAt_) >= std::max(age, publishSeconds_ / kOverhead);
}

std::shared_ptr<Picture> PictureWork::make(core::Renderer& renderer, const RenderRequest& request)
{
    const auto start = Clock::now();
    auto picture = std::make_shared<Picture>();
    if (request.wantVariance) readFilm(renderer);
    if (film_) {
        picture->mean = film_->mean();
        if (request.wantVariance)
            picture->variance = std::make_shared<core::Image>(film_->varianceOfMean());
    } else {
        renderer.readMean(picture->mean);
    }
    if (request.wantAovs && !aovs_) aovs_ = std::make_shared<core::Aovs>(renderer.aovs());
    if (request.wantAovs) picture->aovs = aovs_;
    picture->camera = request.camera;
    picture->fullSize = request.size;
    picture->params = request.params;
    picture->samples = samples_;
    picture->seconds = seconds_;
    picture->preview = coarse_ != Coarse::no;
    picture->finished = finished_;
    picture->counters = counters_;
    picture->stats = renderer.stats();
    picture->curve = curve_;
    published_ = samples_;
    publishedAt_ = Clock::now();
    publishSeconds_ = since(start);
    return picture;
}

}  // namespace app

// Rendering with many lights on all cores, the sum on a device where there is one. A sample is a
// frame (core/many_lights/frame.h): a new set of virtual lights, seen from new points of the
// pixels. The first sample is the frame of the thesis; the mean over samples is what the path
// tracer finds, unless a parameter that is called biased says otherwise.
#include "core/methods/many_lights.h"

#include <algorithm>
#include <array>

#include "core/base/check.h"
#include "core/base/machine_memory.h"
#include "core/methods/many_lights_frame.h"
#include "core/methods/method.h"
#include "core/methods/path_aovs.h"
#include "core/trace/accel.h"

namespace core {

namespace {

using many_lights::CompletionMethod, many_lights::CompletionParams, many_lights::Frame,
    many_lights::FrameLights, many_lights::FrameSettings, many_lights::FrameStats,
    many_lights::SliceStats;

/// Sums over the frames of a picture.
struct Totals {
    FrameStats last;  // of the latest frame that has lit a slice, if any has
    SliceStats slices;
    uint64_t lightsDropped = 0, lightRays = 0, cameraRays = 0, techniqueRays = 0;
    double lightSeconds = 0, treeSeconds = 0, receiverSeconds = 0, techniqueSeconds = 0,
           deviceSeconds = 0;

    Totals& operator+=(const FrameStats& frame);
};

Totals& Totals::operator+=(const FrameStats& frame)
{
    if (frame.slices.slices > 0 || last.slices.slices == 0) last = frame;
    slices += frame.slices;
    lightsDropped += frame.lightsDropped;
    lightRays += frame.lightRays;
    cameraRays += frame.cameraRays;
    techniqueRays += frame.techniqueRays;
    lightSeconds += frame.lightSeconds;
    treeSeconds += frame.treeSeconds;
    receiverSeconds += frame.receiverSeconds;
    techniqueSeconds += frame.techniqueSeconds;
    deviceSeconds += frame.deviceSeconds;
    return *this;
}

/// The parameters that virtual lights depend on.
struct LightKey {
    uint32_t lights = 0, maxDepth = 0, seed = 0;
    SamplerKind sampler{};

    friend bool operator==(const LightKey&, const LightKey&) = default;
};

LightKey keyOf(const ManyLightsParams& params)
{
    return {params.lights, params.maxDepth, params.seed, params.sampler};
}

class ManyLights final : public Renderer {
public:
    explicit ManyLights(std::unique_ptr<ManyLightsDevice> device) : device_(std::move(device)) {}

    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override
    {
        frame_.reset();
        firstLights_.reset();
        plan_.reset();
        earlier_.clear();
        deviceWorld_ = nullptr;
        takeWorld(accel_, world, progress);
        world_ = std::move(world);
        if (size_.x > 0) {
            prepare(params_, progress);
            reset();
        }
    }

    /// Gives the device the world, where the technique's sums are the device's.
    void prepare(const AnyParams& params, const Progress& progress) override
    {
        if (!sumsOnDevice(params.as<ManyLightsParams>()) || deviceWorld_ == world_) return;
        deviceWorld_ = nullptr;
        device_->setWorld(world_, progress);
        deviceWorld_ = world_;
    }

    void setView(const View& view, Start) override
    {
        CHECK(view.size.x > 0 && view.size.y > 0);
        const auto& params = view.params.as<ManyLightsParams>();
        if (keyOf(params) != keyOf(params_)) {
            keepLights();
            findLights(keyOf(params));
        }
        params_ = params;
        camera_ = view.camera;
        size_ = view.size;
        reset();
        if (!sumsOnDevice(params)) return;
        prepare(params, {});
        device_->prepare({{}, many_lights::leavesNumbers(params.completion), params.lightShape});
    }

    /// Pieces are slices, which no pace makes smaller; submissions are a device's.
    void setPace(const Pace& pace) override
    {
        if (device_) device_->setPace(pace);
    }

    void advance(const Budget& budget, std::stop_token stop) override;
    RenderProgress progress() const override
    {
        return {version_, film_.samples, frame_ ? std::min(frame_->fraction(), 0.999) : 0};
    }
    Estimate read(Reading what) override { return film_.estimate(what == Reading::mean); }
    Aovs aovs() override { return surfaces(camera_, size_, Sight::first); }
    Aovs surfaces(const Camera& camera, glm::uvec2 size, Sight sight) override
    {
        CHECK(accel_ != nullptr);
        return traceAovs(*accel_, cameraData(camera, size.x, size.y), size.x, size.y, sight);
    }
    std::vector<Image> maps() override { return maps_; }
    RenderStats stats() const override;

private:
    /// What does not depend on the camera.
    struct Lights {
        LightKey key;
        many_lights::LightPlan plan;
        std::shared_ptr<const FrameLights> first;
    };

    /// Of the techniques, those whose slices have columns.
    bool sumsOnDevice(const ManyLightsParams& params) const
    {
        return device_ && many_lights::choosesColumns(params.technique);
    }
    void reset();
    void keepLights();
    void findLights(const LightKey& key);
    many_lights::LightPlan plan() const;
    FrameSettings settings() const;
    bool beginFrame(const std::stop_token& stop);
    void endFrame();
    FrameStats frameStats() const;
    void makeMaps();
    Frame::PixelDone addToFilm();

    std::unique_ptr<ManyLightsDevice> device_;  // null: the sums are the CPU's
    std::unique_ptr<Accel> accel_;
    std::shared_ptr<const World> world_, deviceWorld_;  // the latter: that the device has
    ManyLightsParams params_;
    Camera camera_;
    glm::uvec2 size_{0};
    std::optional<many_lights::LightPlan> plan_;      // with a clamp of 1
    std::shared_ptr<const FrameLights> firstLights_;  // of frame 0, which every view begins with
    bool lightsFromBefore_ = false;                   // they were made for a view before this one
    std::vector<Lights> earlier_;                     // of other keys, the latest last
    std::unique_ptr<Frame> frame_;
    Film film_;
    std::mutex countersMutex_;
    uint64_t version_ = 0;
    std::vector<Image> maps_;
    Totals totals_;
    double seconds_ = 0;
};

void ManyLights::reset()
{
    frame_.reset();
    film_.reset(size_.x, size_.y);
    maps_.clear();
    totals_ = {};
    seconds_ = 0;
    lightsFromBefore_ = firstLights_ != nullptr;
    ++version_;
}

/// Whether lights may be kept for later: there may be four sets of them, the frame's included.
bool isSmall(const many_lights::LightPlan& plan)
{
    return plan.bytes < machineMemory() / 8;
}

/// Parameters change in the panel, when the camera begins to move, and again when it rests.
void ManyLights::keepLights()
{
    constexpr size_t kMost = 2;
    if (!plan_ || !firstLights_) return;
    if (earlier_.size() == kMost) earlier_.erase(earlier_.begin());
    earlier_.push_back({keyOf(params_), *plan_, std::move(firstLights_)});
}

void ManyLights::findLights(const LightKey& key)
{
    plan_.reset();
    firstLights_.reset();
    const auto found = std::ranges::find(earlier_, key, &Lights::key);
    if (found == earlier_.end()) return;
    plan_ = found->plan;
    firstLights_ = std::move(found->first);
    earlier_.erase(found);
}

/// For the clamp of the parameters.
many_lights::LightPlan ManyLights::plan() const
{
    many_lights::LightPlan plan = plan_.value_or(many_lights::LightPlan{});
    plan.clampDistance *= params_.clamp;
    return plan;
}

FrameSettings ManyLights::settings() const
{
    return frameSettings(accel_->world(), {camera_, size_, params_}, film_.samples == 0);
}

Frame::PixelDone ManyLights::addToFilm()
{
    return [this, isSigned = params_.completion.method !=
                             CompletionMethod::full](size_t pixel, const glm::vec3& radiance) {
        FilmCounters dropped;
        if (isSigned && glm::all(glm::lessThan(glm::abs(radiance), glm::vec3(1e30f)))) {
            // Residuals and linear predictions may be negative: to leave that out would be a bias.
            const glm::dvec3 L(radiance);
            ++film_.weight[pixel];
            film_.sum[pixel] += L;
            film_.sumOfSquares[pixel] += L * L;
            return;
        }
        film_.add(pixel, radiance, dropped);
        if (dropped.clean()) return;
        const std::lock_guard lock(countersMutex_);
        film_.counters += dropped;
    };
}

/// Makes what comes before the slices; false when a stop came first, and then nothing is kept.
bool ManyLights::beginFrame(const std::stop_token& stop)
{
    const FrameSettings s = settings();
    if (!plan_) {
        FrameSettings ofOne = s;
        ofOne.clamp = 1;
        plan_ = many_lights::planLights(*accel_, ofOne);
    }
    const auto index = static_cast<uint32_t>(film_.samples);
    std::shared_ptr<const FrameLights> lights = index == 0 ? firstLights_ : nullptr;
    if (!lights) lights = many_lights::makeFrameLights(*accel_, s, plan(), index, stop);
    if (!lights) return false;
    if (index == 0 && isSmall(*plan_)) firstLights_ = lights;
    auto receivers = many_lights::makeFrameReceivers(*accel_, s, index, stop);
    if (!receivers) return false;
    frame_ = Frame::begin(*accel_, s, plan(), std::move(lights), std::move(receivers), index, stop,
                          addToFilm());
    return frame_ != nullptr;
}

/// Of the frame at work, without what its lights cost an earlier view.
FrameStats ManyLights::frameStats() const
{
    FrameStats stats = frame_->stats();
    if (film_.samples == 0 && lightsFromBefore_) {
        stats.lightRays = 0;
        stats.lightSeconds = stats.treeSeconds = 0;
    }
    return stats;
}

void ManyLights::endFrame()
{
    makeMaps();
    totals_ += frameStats();
    frame_.reset();
    ++film_.samples;
}

void ManyLights::advance(const Budget& budget, std::stop_token stop)
{
    CHECK(accel_ != nullptr && size_.x > 0);
    const Clock::time_point start = Clock::now();
    const uint64_t end = film_.samples + budget.samples;
    bool first = true;
    while ((frame_ || film_.samples < end) && !stop.stop_requested()) {
        if (!first && secondsSince(start) >= budget.seconds) break;
        first = false;
        if (!frame_ && !beginFrame(stop)) break;
        const size_t had = frame_->slicesDone();
        const bool whole = frame_->advance(start, budget.seconds, stop, addToFilm(), device_.get());
        if (whole || frame_->slicesDone() > had) ++version_;
        if (whole) endFrame();
    }
    seconds_ += secondsSince(start);
}

void ManyLights::makeMaps()
{
    const std::span<const SliceStats> slices = frame_->sliceStats();
    const auto map = [&](auto&& value) {
        std::vector<float> values;
        for (const SliceStats& s : slices) values.push_back(static_cast<float>(value(s)));
        Image image(size_.x, size_.y, 1);
        image.pixels = frame_->perPixel(values);
        maps_.push_back(std::move(image));
    };
    maps_.clear();
    map([](const SliceStats& s) { return s.completion.visibility(); });
    map([](const SliceStats& s) { return s.completion.meanRate(); });
    map([](const SliceStats& s) { return double(s.completion.basis); });
    map([](const SliceStats& s) { return double(s.rows); });
}

RenderStats ManyLights::stats() const
{
    RenderStats stats;
    stats.device = "cpu";
    stats.driver = "Embree";
    stats.buildSeconds = accel_ ? accel_->stats().buildSeconds : 0;
    stats.renderSeconds = seconds_;
    Totals t = totals_;
    if (frame_) t += frameStats();
    const SliceStats& s = t.slices;
    stats.rays = t.lightRays + t.cameraRays + t.techniqueRays + s.otherRays + s.completion.rays;
    stats.paths = s.rows;
    const double slices = std::max<double>(1, double(s.slices));
    stats.details = {{"lights", double(t.last.lights)},
                     {"lights_dropped", double(t.lightsDropped)},
                     {"slices", double(t.last.slices.slices)},
                     {"clusters", double(s.clusters) / slices},
                     {"receivers", double(t.last.slices.rows)},
                     {"clamp_distance", double(plan().clampDistance)},
                     {"visibility_rays", double(s.completion.rays)},
                     {"visibility_percent", 100 * s.completion.visibility()},
                     {"author_visibility_percent", 100 * s.completion.authorVisibility()},
                     {"basis_columns", double(s.completion.basis) / slices},
                     {"final_row_rate", s.completion.meanRate()},
                     {"verification_failures", double(s.completion.verificationFailures) / slices},
                     {"lost_light_rays", double(s.otherRays)},
                     {"seconds_lights", t.lightSeconds},
                     {"seconds_tree", t.treeSeconds},
                     {"seconds_receivers", t.receiverSeconds},
                     {"seconds_technique", t.techniqueSeconds},
                     {"light_rays", double(t.lightRays)},
                     {"camera_rays", double(t.cameraRays)},
                     {"technique_rays", double(t.techniqueRays)},
                     {"thread_seconds_cut", s.cutSeconds},
                     {"thread_seconds_order", s.orderSeconds},
                     {"thread_seconds_rays", s.completion.traceSeconds},
                     {"thread_seconds_matching", s.completion.seconds - s.completion.traceSeconds},
                     {"thread_seconds_shading", s.shadingSeconds},
                     {"thread_seconds_lost_light", s.lostSeconds},
                     {"device_seconds_shading", t.deviceSeconds}};
    if (sumsOnDevice(params_)) device_->addTo(stats);
    return stats;
}

}  // namespace

FrameSettings frameSettings(const World& world, const View& view, bool first)
{
    const auto& params = view.params.as<ManyLightsParams>();
    FrameSettings s;
    s.path = worldSettings(world);
    // Visibility between receivers and lights is a bit; behind panes lost light is found.
    s.path.passesPanes = shared::kPanesBlock;
    s.path.imageWidth = view.size.x;
    s.path.imageHeight = view.size.y;
    s.path.seed = params.seed;
    s.path.samplerKind = static_cast<uint32_t>(params.sampler);
    s.path.strategy = shared::kStrategyMis;
    s.path.maxDepth = params.maxDepth;
    s.path.rouletteDepth = 2;
    s.path.clampIndirect = 0;
    s.camera = cameraData(view.camera, view.size.x, view.size.y);
    s.lights = params.lights;
    s.technique = params.technique;
    s.clusters = params.clusters;
    s.error = params.error;
    while (s.side * s.side < params.receivers) ++s.side;
    s.sliceSize = params.sliceSize;
    s.clamp = params.clamp;
    s.centred =
        params.jitter == PixelJitter::never || (params.jitter == PixelJitter::settled && first);
    s.compensates = params.lost == LostLight::paths;
    s.shape = params.lightShape;
    s.completion = params.completion;
    return s;
}

std::unique_ptr<Renderer> makeManyLights()
{
    return makeManyLights(nullptr);
}

std::unique_ptr<Renderer> makeManyLights(std::unique_ptr<ManyLightsDevice> device)
{
    return std::make_unique<ManyLights>(std::move(device));
}

std::span<const MapInfo> manyLightsMaps()
{
    static const std::array kMaps{
        MapInfo{"traced", "share of the visibility of a pixel's slice that rays have found", 1},
        MapInfo{"rate", "row-rate at the end; rows-by-light samples more or fewer rows", 0.4f},
        MapInfo{"basis", "known columns of the slice, of all octants together"},
        MapInfo{"slice", "points in the slice that a pixel belongs to"},
    };
    return kMaps;
}

namespace {

/// A frame as large as those of the thesis's tables, nothing of it left out.
ManyLightsParams largeFrame()
{
    return {.lights = 100000, .clusters = 1000, .receivers = 4};
}

/// The frame of the thesis's tables.
ManyLightsParams thesisFrame(const CompletionParams& completion,
                             many_lights::LightShape shape = many_lights::LightShape::point)
{
    ManyLightsParams p = largeFrame();
    p.clamp = 1;
    p.lightShape = shape;
    p.lost = LostLight::dropped;
    p.completion = completion;
    return p;
}

ManyLightsParams completedFrame()
{
    ManyLightsParams p = largeFrame();
    p.sliceSize = 2000;
    p.completion = {};
    return p;
}

}  // namespace

/// No more of everything than the defaults have.
AnyParams quickerManyLights(const AnyParams& params)
{
    constexpr ManyLightsParams kQuick;
    auto p = params.as<ManyLightsParams>();
    p.lights = std::min(p.lights, kQuick.lights);
    p.clusters = std::min(p.clusters, kQuick.clusters);
    p.receivers = std::min(p.receivers, kQuick.receivers);
    return p;
}

std::span<const MethodPreset> manyLightsPresets()
{
    static const std::array kPresets{
        MethodPreset{"virtual lights", ManyLightsParams{},
                     "the defaults: unbiased, soon to be seen"},
        MethodPreset{"smooth frame", largeFrame(),
                     "many lights, nothing lost: one good sample instead of many"},
        MethodPreset{"completed frame", completedFrame(),
                     "as the smooth frame, but most of the visibility is guessed (biased)"},
        MethodPreset{"thesis frame", thesisFrame(CompletionParams::authorPreset()),
                     "the thesis's tables: its lights, clamp and completion (biased)"},
        MethodPreset{"thesis frame, discs",
                     thesisFrame(CompletionParams::authorPreset(), many_lights::LightShape::disc),
                     "the thesis's glossy scenes: discs for lights, which blur (biased)"},
        MethodPreset{"thesis frame, all traced", thesisFrame({.method = CompletionMethod::full}),
                     "what the thesis compares with: the same, all visibility traced (biased)"},
    };
    return kPresets;
}

}  // namespace core

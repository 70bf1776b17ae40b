// See many_lights_scene.h.
#include "app/bench/many_lights/many_lights_scene.h"

#include <limits>

#include "app/bench/bench_clock.h"
#include "core/base/check.h"
#include "core/base/time.h"
#include "core/methods/many_lights_frame.h"

namespace app::many_lights {

namespace {

using namespace core::many_lights;

constexpr double kForever = std::numeric_limits<double>::infinity();

void ignorePixel(size_t, const glm::vec3&) {}

}  // namespace

LitScene::LitScene(std::shared_ptr<const core::World> world, const core::Camera& camera,
                   glm::uvec2 size, const core::ManyLightsParams& common,
                   const core::Progress& progress, std::stop_token stop)
    : world_(std::move(world)), camera_(camera), size_(size), common_(common),
      stop_(std::move(stop))
{
    accel_ = std::make_unique<core::Accel>(world_, progress, stop_);
}

FrameSettings LitScene::settings(const core::ManyLightsParams& params) const
{
    return core::frameSettings(*world_, {camera_, size_, params}, true);
}

uint32_t LitScene::perPixel() const
{
    const uint32_t side = settings(common_).side;
    return side * side;
}

bool LitScene::findLights()
{
    const FrameSettings s = settings(common_);
    plan_ = planLights(*accel_, s);
    lights_ = makeFrameLights(*accel_, s, plan_, 0, stop_);
    if (!lights_ || !points(common_.sliceSize)) return false;
    const std::string file = world_->scene->file.string();
    if (lights_->set.lights.empty())
        throw core::Error(file + ": no light of this scene reaches anything, so that there are no "
                                 "virtual lights — give a scene with emitters");
    if (points(common_.sliceSize)->receivers.empty())
        throw core::Error(file + ": the camera sees no surface — give another --camera");
    return true;
}

std::shared_ptr<const FrameLights> LitScene::lightsOf(uint32_t repetition) const
{
    if (repetition == 0) return lights_;
    return withOtherTree(*accel_, *lights_, shared::hashUint(common_.seed ^ repetition), stop_);
}

std::shared_ptr<const FrameReceivers> LitScene::points(uint32_t sliceSize)
{
    auto& known = points_[sliceSize];
    if (!known) {
        FrameSettings s = settings(common_);
        s.sliceSize = sliceSize;
        known = makeFrameReceivers(*accel_, s, 0, stop_);
    }
    return known;
}

std::unique_ptr<Frame> LitScene::frame(const core::ManyLightsParams& params, bool packets,
                                       std::shared_ptr<const FrameLights> lights, uint32_t seed)
{
    FrameSettings s = settings(params);
    s.packets = packets;
    s.path.seed = seed;
    auto receivers = points(params.sliceSize);
    if (!receivers || !lights) return nullptr;
    return Frame::begin(*accel_, s, plan_, std::move(lights), std::move(receivers), 0, stop_,
                        ignorePixel);
}

std::optional<Lit> LitScene::light(const core::ManyLightsParams& params, bool packets,
                                   std::shared_ptr<const FrameLights> lights, const Subset& subset,
                                   uint32_t seed)
{
    if (!points(params.sliceSize)) return {};
    std::unique_ptr<Frame> frame;
    Lit lit;
    const double before =
        onHost([&] { frame = this->frame(params, packets, std::move(lights), seed); });
    if (!frame) return {};
    // Cuts through the tree need nothing beforehand; copying the frame's pixels is not their time.
    if (params.technique != core::many_lights::Technique::clusters) lit.beforeSeconds = before;
    lit.beforeRays = double(frame->stats().techniqueRays);
    frame->keepOnly(slicesOf(*points(params.sliceSize), subset));
    const core::Clock::time_point start = core::Clock::now();
    bool whole = false;
    lit.seconds = onHost([&] { whole = frame->advance(start, kForever, stop_, ignorePixel); });
    if (!whole) return {};
    lit.wallSeconds = core::secondsSince(start);
    lit.values = valuesOf(frame->radiance(), subset);
    lit.stats = frame->stats().slices;
    return lit;
}

}  // namespace app::many_lights

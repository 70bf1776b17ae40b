// See clamp_distance.h.
#include "core/many_lights/clamp_distance.h"

#include <algorithm>
#include <array>

#include "core/base/denormals.h"
#include "core/base/parallel.h"
#include "shared/sampler.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kMostLights = 512, kRays = 64;
constexpr double kFraction = 0.1;  // of the way from near to far

struct Reach {
    double near = 0, far = 0;
};

/// Nearest and farthest surface seen by one light, with the thesis's margins.
Reach reachOf(const Accel& accel, const VirtualLight& light, uint32_t index)
{
    std::array<Ray, kRays> rays;
    std::array<shared::Hit, kRays> hits;
    const glm::mat3 frame = shared::makeFrame(light.normal);
    const bool surface = light.kind == LightKind::surface;
    for (uint32_t i = 0; i < kRays; ++i) {
        const shared::SampleStream stream =
            shared::makeStream(shared::kSamplerSobol, 0, {index, 0}, i, shared::kPurposeOcclusion);
        const glm::vec2 u = shared::streamVec2(stream, shared::kDimensionPath);
        rays[i].direction = surface ? shared::toWorld(frame, shared::sampleCosineHemisphere(u))
                                    : shared::sampleSphere(u);
        rays[i].origin = surface ? shared::offsetRay(light.position, light.normal) : light.position;
    }
    accel.closest(rays, hits.data());
    float near = shared::kInfinity, far = 0;
    for (const shared::Hit& hit : hits) {
        if (hit.slot == shared::kNone) continue;
        near = std::min(near, hit.t);
        far = std::max(far, hit.t);
    }
    constexpr float kMargin = 1.5f, kNearest = 1e-5f;
    const float radius = accel.world().radius;
    if (!(far > 0)) return {double(kNearest * radius), double(kMargin * kMargin * radius)};
    return {double(std::max(near / kMargin, kNearest * far)), double(kMargin * far)};
}

}  // namespace

float clampDistance(const Accel& accel, const LightSet& lights)
{
    std::vector<uint32_t> positional;
    for (uint32_t i = 0; i < lights.lights.size(); ++i)
        if (lights.lights[i].kind != LightKind::directional) positional.push_back(i);
    if (positional.empty()) return 0;
    const size_t count = std::min<size_t>(positional.size(), kMostLights);
    std::vector<Reach> reaches(count);
    parallelFor(count, 16, [&](size_t begin, size_t end) {
        const FlushDenormals flush;
        for (size_t k = begin; k < end; ++k) {
            const uint32_t i = positional[k * positional.size() / count];
            reaches[k] = reachOf(accel, lights.lights[i], i & 0xffffu);
        }
    });
    Reach mean;
    for (const Reach& reach : reaches) {
        mean.near += reach.near / double(count);
        mean.far += reach.far / double(count);
    }
    return static_cast<float>(mean.near + kFraction * (mean.far - mean.near));
}

}  // namespace core::many_lights

// Means of pictures by many lights and by the path tracer, and whether they agree.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "core/methods/method.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace tests {

/// Means of a quarter of the picture each, over seeds: within a frame pixels share their lights, so
/// that only frames are independent.
struct Quarters {
    std::array<Moments, 4> means;

    void add(const core::Image& image)
    {
        for (uint32_t q = 0; q < 4; ++q) {
            double sum = 0;
            const uint32_t w = image.width / 2, h = image.height / 2;
            for (uint32_t y = 0; y < h; ++y)
                for (uint32_t x = 0; x < w; ++x) {
                    const float* p = image.at((q & 1) * w + x, (q >> 1) * h + y);
                    sum += double(shared::luminance({p[0], p[1], p[2]}));
                }
            means[q].add(sum / (double(w) * h));
        }
    }
};

inline Quarters manyLights(const std::shared_ptr<const core::World>& world,
                           core::ManyLightsParams params, uint32_t seeds, uint32_t samples)
{
    Quarters q;
    const auto renderer = core::makeRenderer("manylights");
    renderer->setWorld(world, {});
    for (uint32_t seed = 0; seed < seeds; ++seed) {
        params.seed = 1000 + seed;
        renderer->setView({world->cameras.at(0), {32, 32}, params}, core::Start::anew);
        renderer->advance({.samples = samples}, {});
        q.add(renderer->read(core::Reading::mean).mean);
        EXPECT_TRUE(renderer->read(core::Reading::everything).counters.clean());
    }
    return q;
}

/// The four means are equal; the relative bias that would have been seen is below `detects`, in the
/// calmest quarter where the others look at caustics.
inline void expectAgree(const Quarters& a, const Quarters& b, double detects, const char* name,
                        bool caustics = false)
{
    double best = 1e9;
    for (size_t i = 0; i < 4; ++i) {
        const Comparison c = welch(a.means[i], b.means[i]);
        EXPECT_GT(c.p, kLevel) << name << ", quarter " << i << ": " << a.means[i].mean() << " and "
                               << b.means[i].mean() << ", z " << c.z;
        EXPECT_LT(c.detectable, caustics ? 1e9 : detects)
            << name << ", quarter " << i << " is underpowered";
        best = std::min(best, c.detectable);
    }
    EXPECT_LT(best, detects) << name << " is underpowered";
}

inline core::ManyLightsParams fewClusters()
{
    // Receivers anywhere from the first sample on, so that few samples suffice.
    return {.lights = 4000, .clusters = 100, .sliceSize = 200, .jitter = core::PixelJitter::always};
}

/// Means of the path tracer at this depth.
inline Quarters pathsOf(const std::shared_ptr<const core::World>& world, uint32_t maxDepth,
                        uint32_t spp)
{
    Quarters q;
    for (uint32_t seed = 1; seed <= 16; ++seed) {
        core::PathParams params = independentParams(core::Strategy::mis, maxDepth);
        params.seed = seed;
        q.add(render(world, 32, 32, spp, params).mean);
    }
    return q;
}

}  // namespace tests

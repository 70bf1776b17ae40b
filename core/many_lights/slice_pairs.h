// Pairs of a node of receivers and a node of lights of one slice: what all passes through them
// share.
#pragma once

#include <span>
#include <vector>

#include "core/many_lights/light_tree.h"
#include "core/many_lights/pixel_tree.h"
#include "core/many_lights/slice_job.h"

namespace core::many_lights {

/// A node of receivers and a node of lights.
struct Pair {
    uint32_t pixels, lights;
    LightKind kind;
};

/// The slice at work; keeps its memory.
struct SlicePairs {
    const SliceJob* job = nullptr;
    const LightTree* tree = nullptr;
    PixelTree pixels;
    SliceRows rows;
    std::vector<float> weights;  // by row; what is at work decides what they mean
    std::vector<Pair> waiting;
    uint64_t rays = 0, entries = 0;

    /// Keeps job and tree by reference.
    void reset(const SliceJob& of, const LightTree& lights, std::span<const Receiver> receivers,
               std::span<const uint32_t> chosen);

    /// Makes `waiting` what every pass begins with.
    void pushRoots();
    void splitPixels(const Pair& pair)
    {
        waiting.push_back({pixels.nodes()[pair.pixels].right, pair.lights, pair.kind});
        waiting.push_back({pair.pixels + 1, pair.lights, pair.kind});
    }
    void splitLights(const Pair& pair)
    {
        waiting.push_back({pair.pixels, tree->nodes[pair.lights].right, pair.kind});
        waiting.push_back({pair.pixels, pair.lights + 1, pair.kind});
    }

    Column representative(const LightNode& node) const
    {
        const VirtualLight& light = job->lights->lights[node.representative];
        return columnOf(light, node.importance / light.importance, node.representative,
                        job->receivers.frame);
    }

    /// The most that the lights bring to any of the receivers if these were of albedo pi.
    float bound(const PixelNode& p, const Pair& pair) const;
    /// The largest BSDF of the receivers for light from there.
    float responseOf(const PixelNode& p, const Pair& pair) const;
};

}  // namespace core::many_lights

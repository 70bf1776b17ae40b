// Guided paths in the kernels of paths: the guide behind the fetch functions of shared/guide.h, and what recorded paths
// leave. A path's records are its own: their place follows from its lane.
#include "path.glsl"
#include "shared/guided_path.h"

layout(constant_id = kSpecializeGuided) const uint kGuided = 1u;
layout(constant_id = kSpecializeNee) const uint kNee = kNeeBsdf;

layout(set = kSetKernel, binding = kBindGuideNodes) uniform usamplerBuffer guideNodes;
layout(set = kSetKernel, binding = kBindGuideLeaves) uniform usamplerBuffer guideLeaves;
layout(set = kSetKernel, binding = kBindGuideDirections) uniform samplerBuffer guideDirections;
layout(set = kSetKernel, binding = kBindPixelEstimates) uniform samplerBuffer pixelEstimates;

layout(set = kSetKernel, binding = kBindGuideRecords, scalar) writeonly buffer RecordBlock
{
    GuideRecord guideRecords[];
};

layout(set = kSetKernel, binding = kBindPathEnds, scalar) writeonly buffer EndBlock
{
    GuidePathEnd pathEnds[];
};

uvec4 fetchGuideNode(GuideView view, uint i)
{
    return texelFetch(guideNodes, int(i));
}

uvec4 fetchGuideLeaf(GuideView view, uint leaf)
{
    return texelFetch(guideLeaves, int(leaf));
}

vec4 fetchGuideDirections(GuideView view, uint i)
{
    return texelFetch(guideDirections, int(i));
}

#define PathExtra GuidedState

PathExtra beginExtra(uint packedPixel)
{
    if (kGuided == 0u) return beginGuided(0.0);
    const uint index = pixelIndex(uvec2(packedPixel & 0xffffu, packedPixel >> 16u));
    return beginGuided(texelFetch(pixelEstimates, int(index >> 2u))[index & 3u]);
}

/// As extendPath, with the guide.
bool extendLane(uint lane, SampleStream stream, inout PathState path, inout PathExtra extra, inout vec3 L,
                inout uint shadowRays)
{
    if (kGuided == 0u) return extendPath(stream, path, L, shadowRays);
    const GuideView guide = GuideView(kGuided);
    PathSettings settings = frame.settings;
    settings.guidedRules = withNee(settings.guidedRules, kNee);
    const uint depth = path.depth;
    const uint stride = recordStride(settings);
    const bool records = isRecorded(lane % kGroupSize, stream.index, stride);
    uint count = depth;
    bool goesOn = false;
    Hit hit;
    if (traceClosest(Ray(path.origin, 0.0, path.direction, kInfinity), alphaSeed(stream, depth, 0u), hit)) {
        ShadowRay shadow;
        GuideRecord record;
        uint recorded = records && depth < kGuideVertices ? 1u : 0u;
        const VertexNumbers numbers = drawVertexNumbers(stream, depth);
        goesOn = shadeGuided(scene, guide, settings, followsGuide(settings, records), numbers, hit, path, extra,
                             shadow, record, recorded, L);
        addConnection(shadow, alphaSeed(stream, depth, 1u), L, shadowRays);
        if (recorded != 0u) {
            record.after = luminance(L);
            guideRecords[recordedSlot(lane, stride) * kGuideVertices + depth] = record;
            count = depth + 1u;
        }
    } else {
        L += shadeMiss(scene, frame.settings, path);
    }
    if (records && !goesOn) {
        pathEnds[recordedSlot(lane, stride)] = GuidePathEnd(min(count, kGuideVertices), luminance(L), extra.image);
    }
    return goesOn;
}

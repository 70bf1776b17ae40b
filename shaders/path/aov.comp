// First-hit data at pixel centres: word 0 depth and shading normal, word 1 albedo, word 2 triangle, material, emitter
// (as floats, -1 for none). The output begins at the pixel of index `batch.firstSample`.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "path_common.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = kBindOutput, scalar) writeonly buffer OutputBlock
{
    vec4 words[];
};

void main()
{
    const uint lane = gl_GlobalInvocationID.x;
    const uvec2 pixel = lanePixel(lane);
    if (lane >= laneCount() || !insideImage(pixel)) return;
    PathState path;
    cameraRay(frame.camera, vec2(pixel) + 0.5,
              vec2(frame.settings.imageWidth, frame.settings.imageHeight), vec2(0.5), path.origin, path.direction);
    const uint i = 3u * (pixel.y * frame.settings.imageWidth + pixel.x - batch.firstSample);
    Hit hit;
    if (!traceClosest(Ray(path.origin, 0.0, path.direction, kInfinity), 0u, hit)) {
        words[i] = vec4(0.0);
        words[i + 1u] = vec4(0.0);
        words[i + 2u] = vec4(-1.0);
        return;
    }
    SurfacePoint s = makeSurfacePoint(scene, hit, path.direction);
    const Shading shading = evaluateMaterial(scene, s, path.direction);
    const Bsdf bsdf = makeBsdf(shading.inputs);
    words[i] = vec4(hit.t, s.frame[2]);
    words[i + 1u] = vec4(albedoBsdf(bsdf, toLocal(s.frame, -path.direction)), 0.0);
    words[i + 2u] = vec4(float(s.triangle), float(s.material), s.emitter == kNone ? -1.0 : float(s.emitter), 0.0);
}

// First hits of the pixels of some tiles, and backprojection: which pixel of the frame before has the history of each.
// The pixel's last word holds that pixel (kNone: there is none) until reuse_old puts the history's length there.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_basic : require

#include "reuse.glsl"

layout(local_size_x = 64) in;

/// The first of nine pixels whose first hit belongs to the surface at s; kNone where there is none.
uint findSource(SurfacePoint s)
{
    const ivec2 size = ivec2(sizeBefore());
    vec2 film;
    if (!projectToFilm(push.cameraBefore, vec2(size), s.position, film)) return kNone;
    const float away = length(s.position - push.cameraBefore.position);
    const ivec2 middle = ivec2(floor(film));
    for (uint k = 0u; k < 9u; ++k) {
        const ivec2 at = middle + historyOffset(k);
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
        const uint source = uint(at.y * size.x + at.x);
        vec3 position;
        const ReusePixel before = unpackReusePixel(texelFetch(pixelsBefore, int(source)));
        if (historyFits(scene, before, s, away, position)) return source;
    }
    return kNone;
}

void main()
{
    uint lane;
    uvec2 pixel;
    const bool inside = lanesPixel(lane, pixel);
    if (inside) {
        const SampleStream stream = pixelStream(pixel);
        const PathState ray = pixelRay(frame.camera, frame.settings, push.settings, pixel, stream);
        const ReusePixel here = findFirstHit(scene, ray, stream);
        uint source = kNone;
        if (push.cameraBefore.tanHalfHeight > 0.0 && here.slot != kNone)
            source = findSource(makeSurfacePoint(scene, Hit(0.0, here.barycentrics, here.slot), ray.direction));
        uvec4 words = packReusePixel(here);
        words.w = source;
        pixelsNow[pixelIndex(pixel)] = words;
    }
    const uint rays = subgroupAdd(inside ? 1u : 0u);
    if (subgroupElect()) atomicAdd(counters.closestRays, rays);
}

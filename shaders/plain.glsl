// Plain paths in the kernels of paths: what they carry beside their state is nothing.
#include "path.glsl"

struct PathExtra {
    uint unused;  // a structure without members is not allowed
};

PathExtra beginExtra(uint packedPixel)
{
    return PathExtra(0u);
}

PathExtra loadExtra(uint lane)
{
    return PathExtra(0u);
}

void storeExtra(uint lane, PathExtra extra) {}

bool extendLane(uint lane, SampleStream stream, inout PathState path, inout PathExtra extra, inout vec3 L,
                inout uint shadowRays)
{
    return extendPath(stream, path, L, shadowRays);
}

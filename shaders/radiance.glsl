// What the paths of a batch have brought home, one word per lane: path kernels write it, accumulate reads it.
#include "shared/bindings.h"

layout(set = kSetKernel, binding = kBindRadiance, scalar) buffer RadianceBlock
{
    vec4 radiance[];
};

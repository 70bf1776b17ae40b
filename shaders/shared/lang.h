// The language bridge: lets one text compile as GLSL (Vulkan compute) and as C++ (GLM).
// Rules for every header of this folder: float suffixes on literals, no swizzles (use xyz()), no
// bool members, no recursion, no GLSL keyword as a name (sample, shared, buffer, input, output,
// half, ...). Scene data is reached only through the fetch functions of scene.h.
#ifndef REKINDLE_SHARED_LANG_H
#define REKINDLE_SHARED_LANG_H

#ifdef __cplusplus

#define GLM_FORCE_SILENT_WARNINGS
#include <glm/glm.hpp>

#define SHARED_BEGIN namespace shared {
#define SHARED_END }
#define SHARED_CONST inline constexpr
#define IN(T) const T&  // of what is too large to be copied
#define OUT(T) T&
#define INOUT(T) T&
#define PRECISE
#define ALIGNED(bytes) alignas(bytes)  // of a struct: one line of a processor's cache holds it

// A source file may define REKINDLE_FEATURES (kFeature bits) before it includes anything: the
// functions are then its own and hold code for these bits only, as a specialised pipeline does.
#ifdef REKINDLE_FEATURES
#define SHARED_FN static inline
#define FEATURE(bit) (((REKINDLE_FEATURES) & (bit)) != 0u)
#else
#define SHARED_FN inline
#define FEATURE(bit) true
#endif

// Before SHARED_FN: what is called is compiled into the function, and left out where its result is
// not used, as in every kernel.
#define SHARED_FLAT [[gnu::flatten]]

namespace shared {
using namespace glm;  // the mathematics below is written in GLSL's vocabulary
using glm::mat3;
using glm::uint;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline float uintAsFloat(uint x)
{
    return glm::uintBitsToFloat(x);
}

inline uint floatAsUint(float x)
{
    return glm::floatBitsToUint(x);
}
}  // namespace shared

#else

#define SHARED_BEGIN
#define SHARED_END
#define SHARED_FN
#define SHARED_FLAT
#define SHARED_CONST const
#define IN(T) T
#define OUT(T) out T
#define INOUT(T) inout T
#define PRECISE precise
#define ALIGNED(bytes)
#define uintAsFloat uintBitsToFloat
#define floatAsUint floatBitsToUint

// One word of feature bits (layout.h) selects at pipeline creation what is compiled in.
layout(constant_id = 0) const uint kFeatures = 0xffffffffu;
#define FEATURE(bit) ((kFeatures & (bit)) != 0u)

#endif

SHARED_BEGIN

SHARED_CONST float kPi = 3.14159265358979f;
SHARED_CONST float kInvPi = 0.318309886183791f;
// "no hit yet": finite, so that it survives fast arithmetic
SHARED_CONST float kInfinity = 3.0e38f;
SHARED_CONST float kOneMinusEpsilon = 0.99999994f;  // largest float below one

/// The first three components (swizzles do not compile as C++).
SHARED_FN vec3 xyz(vec4 v)
{
    return vec3(v.x, v.y, v.z);
}

SHARED_FN float maxComponent(vec3 v)
{
    return max(v.x, max(v.y, v.z));
}

/// Luminance of linear Rec.709.
SHARED_FN float luminance(vec3 c)
{
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

SHARED_END

#endif

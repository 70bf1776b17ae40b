// What host and device agree on: feature bits, flags, and the records of the scene, in scalar
// layout. Records are read on the device as 16-byte words of texel buffers (Mesa's fastest path for
// divergent reads), so every record is a whole number of words and names the words it is made of.
#ifndef REKINDLE_SHARED_LAYOUT_H
#define REKINDLE_SHARED_LAYOUT_H

#include "lang.h"

SHARED_BEGIN

// Features: what can occur in a scene. Bits that a scene does not need are not compiled into its
// kernels.
SHARED_CONST uint kFeatureShadingNormals = 1u << 0;  // vertex normals that differ from the face's
SHARED_CONST uint kFeatureTextures = 1u << 1;        // any texture at all
SHARED_CONST uint kFeatureNormalMaps = 1u << 2;
SHARED_CONST uint kFeatureVertexExtra = 1u << 3;  // vertex colours or a second set of coordinates
SHARED_CONST uint kFeatureAlpha = 1u << 4;        // alpha mask or blend: tested inside traversal
// Any glossy or mirror reflection (dielectric or metal)
SHARED_CONST uint kFeatureSpecular = 1u << 5;
SHARED_CONST uint kFeatureTransmission = 1u << 6;
SHARED_CONST uint kFeatureVolume = 1u << 7;  // absorption inside transmissive solids
SHARED_CONST uint kFeatureClearcoat = 1u << 8;
SHARED_CONST uint kFeatureEmissiveTriangles = 1u << 9;
SHARED_CONST uint kFeaturePunctualLights = 1u << 10;  // point, spot, directional
SHARED_CONST uint kFeatureEnvironment = 1u << 11;
SHARED_CONST uint kFeatureSun = 1u << 12;
SHARED_CONST uint kFeatureEmissiveTextures = 1u << 13;
SHARED_CONST uint kFeatureThinLens = 1u << 14;  // camera with an aperture
SHARED_CONST uint kFeatureDelta = 1u << 15;     // lobes without density (alpha below kDeltaAlpha)
SHARED_CONST uint kFeatureMetal = 1u << 16;  // metallic above zero: coloured conductor reflection
// More than one emitter: a choice has to be made
SHARED_CONST uint kFeatureManyEmitters = 1u << 17;
SHARED_CONST uint kFeatureEmitterTree = 1u << 18;  // so many that they are chosen by place, too
SHARED_CONST uint kFeaturePanes = 1u << 19;  // thin smooth walls that light goes straight through
SHARED_CONST uint kFeatureAsksVisibility = 1u << 20;  // sample reuse, of old samples
SHARED_CONST uint kFeatureGridChanges = 1u << 21;     // grids that are come to on the way down
SHARED_CONST uint kFeatureInstances = 1u << 22;       // meshes that are stored once, shown often
// An environment that most places see through openings
SHARED_CONST uint kFeatureSkyRegions = 1u << 23;
SHARED_CONST uint kFeatureMoves = 1u << 24;  // sample reuse, of a scene whose poses differ
// Of sample reuse, what its strategy keeps: samples, with what arrives at their places, or means.
SHARED_CONST uint kFeatureKeepsSamples = 1u << 25;
SHARED_CONST uint kFeatureKeepsPlaces = 1u << 26;
SHARED_CONST uint kFeatureKeepsMeans = 1u << 27;
SHARED_CONST uint kFeatureSurroundings = 1u << 28;  // rays begin on a finer grid: BvhEntry

SHARED_CONST uint kNone = 0xffffffffu;

// Material flags.
SHARED_CONST uint kMaterialDoubleSided = 1u << 0;  // emits on both faces
SHARED_CONST uint kMaterialAlphaMask = 1u << 1;
SHARED_CONST uint kMaterialAlphaBlend = 1u << 2;
SHARED_CONST uint kMaterialVolume = 1u << 3;  // transmission encloses a solid: refracts and absorbs
// KHR_materials_unlit: shows its colour as emission, reflects nothing
SHARED_CONST uint kMaterialUnlit = 1u << 4;

// Texture slots of a material.
SHARED_CONST uint kTextureBaseColor = 0u;
SHARED_CONST uint kTextureMetallicRoughness = 1u;
SHARED_CONST uint kTextureNormal = 2u;
SHARED_CONST uint kTextureEmissive = 3u;
SHARED_CONST uint kTextureTransmission = 4u;
SHARED_CONST uint kTextureSpecular = 5u;
SHARED_CONST uint kTextureSpecularColor = 6u;
SHARED_CONST uint kTextureClearcoat = 7u;
SHARED_CONST uint kTextureClearcoatRoughness = 8u;
SHARED_CONST uint kTextureSlotCount = 9u;

/// One material, seven 16-byte words. glTF metallic-roughness with the KHR extensions that
/// core/gltf/document.cpp lists. `emissive` is radiance (factor times strength). `absorption` is
/// sigma_a in 1/metre: -ln(colour)/distance. `textures` holds 1 + index into the texture references
/// per slot, two slots of 16 bits to a uint; 0 = none.
struct Material {
    vec3 baseColor;
    float alpha;
    vec3 emissive;
    float alphaCutoff;
    float metallic;
    float roughness;
    float ior;
    float transmission;
    vec3 specularColor;
    float specular;
    vec3 absorption;
    float normalScale;
    float clearcoat;
    float clearcoatRoughness;
    uint flags;
    uint textures0;
    uint textures1;
    uint textures2;
    uint textures3;
    uint textures4;
};
SHARED_CONST uint kMaterialWords = 7u;

// Texture reference flags.
SHARED_CONST uint kWrapRepeat = 0u;
SHARED_CONST uint kWrapClamp = 1u;
SHARED_CONST uint kWrapMirror = 2u;
SHARED_CONST uint kTextureWrapSShift = 0u;  // two bits
SHARED_CONST uint kTextureWrapTShift = 2u;  // two bits
SHARED_CONST uint kTextureNearest = 1u << 4;
SHARED_CONST uint kTextureTexCoord1 = 1u << 5;
SHARED_CONST uint kTextureTransformed = 1u << 6;

/// A use of a texture, three words: where its texels start in the pool, its size, sampler and
/// transform (KHR_texture_transform as the two rows of an affine map of the coordinates).
struct TextureReference {
    uint firstTexel;
    uint width;
    uint height;
    uint flags;
    vec3 row0;
    float padding0;
    vec3 row1;
    float padding1;
};
SHARED_CONST uint kTextureReferenceWords = 3u;

// Emitter kinds.
SHARED_CONST uint kEmitterTriangle = 0u;
SHARED_CONST uint kEmitterPoint = 1u;
SHARED_CONST uint kEmitterSpot = 2u;
SHARED_CONST uint kEmitterDirectional = 3u;
SHARED_CONST uint kEmitterEnvironment = 4u;
SHARED_CONST uint kEmitterSun = 5u;

/// One emitter, four words. Meaning by kind:
///   triangle     a, b, c its vertices; slot its triangle; radiance L of the front, of both sides
///                with kEmitterTwoSided; a textured one multiplies by the texture at the point
///   point        a position; radiance is intensity W/sr
///   spot         a position, b axis (unit, from the light); scale, offset of the angular fall-off
///                saturate(cos * scale + offset)^2; radiance is intensity W/sr
///   directional  b direction towards the light (unit); radiance is irradiance W/m^2 that arrives
///                head-on
///   environment  the whole map
///   sun          b direction towards the sun (unit); scale = 1 - cos(angular radius), which is
///                kept rather than the cosine so that half a degree does not drown in rounding;
///                radiance of the disk
struct ALIGNED(64) Emitter {
    vec3 a;
    uint kind;
    vec3 b;
    uint slot;
    vec3 c;
    float scale;
    vec3 radiance;
    float offset;
};
SHARED_CONST uint kEmitterWords = 4u;
SHARED_CONST uint kEmitterTwoSided = 0x100u;  // or-ed to kind
SHARED_CONST uint kEmitterTextured = 0x200u;
SHARED_CONST uint kEmitterCoated = 0x400u;  // radiance is that of the front below a clear coat
SHARED_CONST uint kEmitterAlpha = 0x800u;   // its material may have holes: surfaceAlpha

/// One flattened triangle: three vertices, its material.
struct WorldTriangle {
    uint v0;
    uint v1;
    uint v2;
    uint material;
};

/// Where an instance shows its prototype: rows of the matrix that takes points to the world, the
/// translation in w.
struct InstanceMatrix {
    vec4 row0;
    vec4 row1;
    vec4 row2;
};
SHARED_CONST uint kInstanceMatrixWords = 3u;

// Slots from here on belong to instances: instances.h. No world stores so many triangles that a
// hierarchy could hold them.
SHARED_CONST uint kFirstInstancedSlot = 1u << 27;

// The w component of a triangle's second vertex, as fetchTriangleVertex returns it, is its material
// with this bit set when a hit needs the alpha test.
SHARED_CONST uint kTriangleAlphaBit = 0x80000000u;

// VertexAttributes::normal of vertices that have none (packOct never makes it): flat shading.
SHARED_CONST uint kNoNormal = 0x80008000u;

/// Vertex attributes, one word: octahedral normal (2 x snorm16), texture coordinates, octahedral
/// tangent (15 + 16 bits; lowest bit = handedness).
struct VertexAttributes {
    uint normal;
    float u;
    float v;
    uint tangent;
};

/// Second word, only in scenes that need it: second texture coordinates, linear colour and alpha (4
/// x half).
struct VertexExtra {
    float u1;
    float v1;
    uint colorRg;
    uint colorBa;
};

/// A camera as rays are made from it. Directions are orthonormal; `tanHalfHeight` scales `up`,
/// aspect `right`. orthographic = 1: rays are parallel and tanHalfHeight is half the height in
/// metres.
struct CameraData {
    vec3 position;
    float tanHalfHeight;
    vec3 right;
    float aspect;
    vec3 up;
    float apertureRadius;
    vec3 forward;
    float focusDistance;
    uint orthographic;
    uint centred;  // 1: paths begin through the centres of pixels, wherever else in them they would
    uint reserved0;
    uint reserved1;
};

/// What every vertex of a path needs to know about the scene and the settings; push constants and
/// uniforms alike.
struct PathSettings {
    uint seed;
    uint samplerKind;    // kSamplerSobol, kSamplerIndependent (sampler.h)
    uint strategy;       // kStrategyMis, kStrategyBsdf, kStrategyLight
    uint maxDepth;       // scattering events: 0 = emission only, 1 = direct light
    uint rouletteDepth;  // first scattering event after which roulette may end a path
    uint emitterCount;
    uint environmentEmitter;  // index, or kNone
    uint sunEmitter;          // index, or kNone
    uint environmentWidth;
    uint environmentHeight;
    float environmentIntensity;
    float clampIndirect;  // 0 = off; otherwise biased
    float sceneRadius;
    uint imageWidth;
    uint imageHeight;
    uint guidedRules;   // of guided paths: packGuidedRules (guided_path.h)
    uint passesPanes;   // kPanesBlock, kPanesPass, kPanesPassPunctual
    uint treeEmitters;  // the first so many emitters are chosen by the emitter tree; 0: there is
                        // none
    uint skyRegions;    // 1: the environment is drawn as it is seen from a region
};

// What goes straight through panes (path.h): nothing; connections and unscattered paths, which are
// weighed against each other; or only connections with emitters that no path could meet.
SHARED_CONST uint kPanesBlock = 0u;
SHARED_CONST uint kPanesPass = 1u;
SHARED_CONST uint kPanesPassPunctual = 2u;

SHARED_CONST uint kStrategyMis = 0u;
SHARED_CONST uint kStrategyBsdf = 1u;
SHARED_CONST uint kStrategyLight = 2u;

#ifdef __cplusplus
static_assert(sizeof(Material) == 16 * kMaterialWords);
static_assert(sizeof(TextureReference) == 16 * kTextureReferenceWords);
static_assert(sizeof(Emitter) == 16 * kEmitterWords);
static_assert(sizeof(WorldTriangle) == 16 && sizeof(VertexAttributes) == 16 &&
              sizeof(VertexExtra) == 16);
static_assert(sizeof(CameraData) == 80);
static_assert(sizeof(PathSettings) == 76);
#endif

// A CDF of the environment is looked up by parts of [0,1): for each the interval in which it begins
// is stored (H.-C. Chen, Y. Asau, "On Generating Random Variates from an Empirical Distribution",
// 1974), so that a search reads one or two cache lines of a row and not one for each step.
SHARED_CONST uint kCdfParts = 128u;  // a power of two: parts of u are exact

/// Where the parts of the CDF over rows are; those of row y are the (y + 1)th behind them.
SHARED_FN uint firstCdfPart(uint width, uint height)
{
    return height + 1u + height * (width + 1u);
}

SHARED_END

#endif

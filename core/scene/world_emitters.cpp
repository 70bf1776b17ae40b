// The table of emitters: emissive triangles, punctual lights (KHR_lights_punctual), the
// environment, the sun; the CDF by which one is chosen, and the tree over those that have a place,
// which come first. The CDF goes by emitted power among those that have a place and by irradiance
// among those that are infinitely far away; where there are both, each kind has half, for what
// light from far away sends through the bounds of a scene says nothing of what it does in a room.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/check.h"
#include "core/scene/emitter_choice.h"
#include "core/scene/emitter_tree.h"
#include "core/scene/features.h"
#include "core/scene/light_table.h"
#include "core/scene/world_parts.h"
#include "shared/surface.h"

namespace core {

namespace {

using std::numbers::pi;

double asPower(const glm::vec3& c)
{
    return std::max(0.0, static_cast<double>(shared::luminance(c)));
}

/// Mean luminance of emissive textures, over whole textures and over the part that a triangle
/// shows.
class EmissiveTextures {
public:
    explicit EmissiveTextures(const World& world)
        : world_(world), means_(world.textureReferences.size(), -1.0)
    {}

    /// Over the texture of `reference`.
    double mean(uint32_t reference)
    {
        double& known = means_[reference];
        if (known >= 0) return known;
        const shared::TextureReference& r = world_.textureReferences[reference];
        known = 0;
        for (uint32_t y = 0; y < r.height; ++y) {
            for (uint32_t x = 0; x < r.width; ++x) known += texel(r, x, y);
        }
        known /= std::max(1.0, static_cast<double>(r.width) * r.height);
        return known;
    }

    /// Over the triangle with these coordinates (already transformed), from at most 64 x 64 texels
    /// of their bounds; a hundredth of the whole mean is added for what lies between.
    double meanOver(uint32_t reference, glm::dvec2 a, glm::dvec2 b, glm::dvec2 c)
    {
        const double floor = 0.01 * mean(reference);
        const shared::TextureReference& r = world_.textureReferences[reference];
        const glm::dvec2 size(r.width, r.height);
        const glm::dvec2 low = glm::min(a, glm::min(b, c)) * size - 0.5;
        const glm::dvec2 high = glm::max(a, glm::max(b, c)) * size + 0.5;
        if (!(std::abs(low.x) + std::abs(low.y) + std::abs(high.x) + std::abs(high.y) < 1e9)) {
            return mean(reference);
        }
        const glm::dvec2 step = glm::max((high - low) / 64.0, glm::dvec2(1));
        double sum = 0, count = 0;
        for (double y = std::floor(low.y) + 0.5; y < high.y + 0.5; y += step.y) {
            for (double x = std::floor(low.x) + 0.5; x < high.x + 0.5; x += step.x) {
                if (!nearTriangle({x, y}, a * size, b * size, c * size)) continue;
                sum += texel(r, foldTexel(x, r.width, r.flags >> shared::kTextureWrapSShift),
                             foldTexel(y, r.height, r.flags >> shared::kTextureWrapTShift));
                count += 1;
            }
        }
        return count > 0 ? sum / count + floor : mean(reference);
    }

private:
    double texel(const shared::TextureReference& r, uint32_t x, uint32_t y) const
    {
        const Texel& t = world_.texels[r.firstTexel + size_t(y) * r.width + x];
        return asPower(
            {shared::halfAsFloat(t.r), shared::halfAsFloat(t.g), shared::halfAsFloat(t.b)});
    }

    /// Index of the texel that a coordinate (in texels) falls on.
    static uint32_t foldTexel(double x, uint32_t size, uint32_t wrap)
    {
        const float u = shared::foldCoordinate(static_cast<float>(x / size), wrap & 3u);
        return std::min(static_cast<uint32_t>(u * static_cast<float>(size)), size - 1);
    }

    /// Inside the triangle, or within a texel of its edges.
    static bool nearTriangle(glm::dvec2 p, glm::dvec2 a, glm::dvec2 b, glm::dvec2 c)
    {
        const auto cross = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
        const double sign = cross(b - a, c - a) < 0 ? -1 : 1;
        const auto inside = [&](glm::dvec2 from, glm::dvec2 to) {
            return sign * cross(to - from, p - from) >= -glm::length(to - from);
        };
        return inside(a, b) && inside(b, c) && inside(c, a);
    }

    const World& world_;
    std::vector<double> means_;
};

/// Coordinates of a vertex as the reference reads them.
glm::dvec2 textureCoordinates(const World& world, const shared::TextureReference& r,
                              uint32_t vertex)
{
    glm::dvec2 uv(world.attributes[vertex].u, world.attributes[vertex].v);
    if ((r.flags & shared::kTextureTexCoord1) != 0 && !world.extra.empty()) {
        uv = {world.extra[vertex].u1, world.extra[vertex].v1};
    }
    if ((r.flags & shared::kTextureTransformed) == 0) return uv;
    const glm::dvec3 row0(r.row0), row1(r.row1), h(uv, 1);
    return {glm::dot(row0, h), glm::dot(row1, h)};
}

/// The triangles that emit. What their textures shine is looked up once for all poses.
std::vector<TriangleEmission> emissiveTriangles(const World& world)
{
    static_assert(shared::kTextureEmissive == 3u);
    EmissiveTextures textures(world);
    std::vector<TriangleEmission> emission;
    for (uint32_t i = 0; i < world.triangles.size(); ++i) {
        const WorldTriangle& t = world.triangles[i];
        const shared::Material& m = world.materials[t.material];
        const bool unlit = (m.flags & shared::kMaterialUnlit) != 0;  // shows its colour alone
        if (unlit || !(asPower(m.emissive) > 0)) continue;
        const uint32_t slot = m.textures1 >> 16;  // kTextureEmissive
        if (slot == 0) {
            emission.push_back({i, false, 1});
            continue;
        }
        const uint32_t reference = slot - 1;
        const shared::TextureReference& r = world.textureReferences[reference];
        if (!(textures.mean(reference) > 0)) continue;
        const double mean = textures.meanOver(reference, textureCoordinates(world, r, t.v0),
                                              textureCoordinates(world, r, t.v1),
                                              textureCoordinates(world, r, t.v2));
        emission.push_back({i, true, mean});
    }
    return emission;
}

/// Records being collected; those with a place first. `weights`: their power in watts; of those
/// infinitely far away, irradiance in W/m^2.
struct Collected {
    std::vector<shared::Emitter> emitters;
    std::vector<double> weights;
    std::vector<EmitterBounds> bounds;  // of those with a place

    void addNear(const shared::Emitter& emitter, double power, const EmitterBounds& where)
    {
        CHECK(bounds.size() == emitters.size());
        addFar(emitter, power);
        bounds.push_back(where);
    }

    void addFar(const shared::Emitter& emitter, double irradiance)
    {
        emitters.push_back(emitter);
        weights.push_back(irradiance);
    }

    size_t nearCount() const { return bounds.size(); }
};

void addTriangles(World& world, const std::vector<TriangleEmission>& emission, Collected& out)
{
    out.emitters.reserve(emission.size());
    out.weights.reserve(emission.size());
    out.bounds.reserve(emission.size());
    for (const TriangleEmission& emitting : emission) {
        const WorldTriangle& t = world.triangles[emitting.triangle];
        const shared::Material& m = world.materials[t.material];
        const glm::vec3 a = world.positions[t.v0], b = world.positions[t.v1],
                        c = world.positions[t.v2];
        const glm::dvec3 n =
            glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
        const bool twoSided = (m.flags & shared::kMaterialDoubleSided) != 0;
        // Where textures leave no coat anywhere kernels know nothing of coats.
        const bool coated = m.clearcoat > 0 && (world.features & shared::kFeatureClearcoat) != 0;
        shared::Emitter e{};
        e.kind = shared::kEmitterTriangle | (twoSided ? shared::kEmitterTwoSided : 0u) |
                 (emitting.textured ? shared::kEmitterTextured : 0u) |
                 (coated ? shared::kEmitterCoated : 0u) |
                 (hasAlphaTest(m) ? shared::kEmitterAlpha : 0u);
        e.a = a;
        e.b = b;
        e.c = c;
        e.slot = emitting.triangle;
        e.radiance = m.emissive;
        EmitterBounds where{glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
        if (glm::length(n) > 0) where.axis = glm::vec3(glm::normalize(n));
        where.bothFaces = twoSided;
        where.intensity = 0.5 * glm::length(n) * asPower(m.emissive) * emitting.mean;
        out.addNear(e, pi * where.intensity * (twoSided ? 2 : 1), where);
        world.features |= shared::kFeatureEmissiveTriangles;
        if (emitting.textured) world.features |= shared::kFeatureEmissiveTextures;
    }
}

/// Record of a punctual light at a node; its power, or irradiance if it is directional.
double makePunctual(const PunctualLight& light, const glm::dmat4x3& toFile, const World& world,
                    shared::Emitter& e, EmitterBounds& where)
{
    const double scale2 = world.placement.scale * world.placement.scale;
    const glm::vec3 strength = light.color * light.intensity;
    const double length = glm::length(glm::dvec3(toFile[2]));
    // A point light shines all around, also where its node's scale leaves no direction.
    const bool anyAxis = light.kind == shared::kEmitterPoint && !(length > 0);
    const glm::dvec3 axis = anyAxis ? glm::dvec3(0, 0, -1) : -glm::dvec3(toFile[2]) / length;
    e.kind = light.kind;
    e.a = glm::vec3(world.placement.toWorld(glm::dvec3(toFile[3])));
    if (light.kind == shared::kEmitterDirectional) {
        e.b = glm::vec3(-axis);
        e.radiance = strength;
        return asPower(strength);
    }
    e.radiance = strength * static_cast<float>(scale2);  // W/sr: distances change with the scale
    where = {e.a, e.a, glm::vec3(axis), -1, 0, false, asPower(e.radiance)};
    if (light.kind == shared::kEmitterPoint) return 4 * pi * asPower(e.radiance);
    const double inner = std::cos(static_cast<double>(light.innerCone));
    const double outer = std::cos(static_cast<double>(light.outerCone));
    const double slope = 1 / std::max(0.001, inner - outer);
    e.b = glm::vec3(axis);
    e.scale = static_cast<float>(slope);
    e.offset = static_cast<float>(-outer * slope);
    where.cosNormals = static_cast<float>(inner);
    where.cosEmission = static_cast<float>(
        std::cos(static_cast<double>(light.outerCone) - static_cast<double>(light.innerCone)));
    const double solidAngle = 2 * pi * ((1 - inner) + (inner - outer) / 3);
    return asPower(e.radiance) * std::max(solidAngle, 1e-6);
}

/// Lights with a place when `near`, those without when not.
void addPunctual(World& world, const Scene& scene, const Pose& pose, bool near, Collected& out)
{
    for (size_t n = 0; n < scene.nodes.size(); ++n) {
        const int index = scene.nodes[n].light;
        if (index < 0 || static_cast<size_t>(index) >= scene.lights.size()) continue;
        const PunctualLight& light = scene.lights[static_cast<size_t>(index)];
        if ((light.kind != shared::kEmitterDirectional) != near) continue;
        shared::Emitter e{};
        EmitterBounds where;
        const double power = makePunctual(light, pose.toFile[n], world, e, where);
        const double sum = static_cast<double>(glm::dot(e.a, e.a) + glm::dot(e.b, e.b)) + power;
        if (!std::isfinite(sum)) {
            world.warnings.add("LIGHT_NOT_FINITE", nodePointer(scene, n),
                               "position, direction or intensity is not finite — light dropped");
            continue;
        }
        if (light.range > 0) {
            world.warnings.add("LIGHT_RANGE_IGNORED", nodePointer(scene, n),
                               "range is a hint that ends light abruptly — ignored, light falls "
                               "off with the square "
                               "of the distance");
        }
        if (!(power > 0)) continue;
        near ? out.addNear(e, power, where) : out.addFar(e, power);
        world.features |= shared::kFeaturePunctualLights;
    }
}

void addEnvironment(World& world, double weight, Collected& out)
{
    const double irradiance = weight * static_cast<double>(world.environmentIntensity);
    if (world.environment.empty() || !(irradiance > 0)) return;
    world.environmentEmitter = static_cast<uint32_t>(out.emitters.size());
    shared::Emitter e{};
    e.kind = shared::kEmitterEnvironment;
    out.addFar(e, irradiance);
    world.features |= shared::kFeatureEnvironment;
}

void addSun(World& world, const Scene& scene, Collected& out)
{
    if (!scene.sun) return;
    const double half = std::sin(0.5 * static_cast<double>(scene.sun->angularRadius));
    const double oneMinusCos = 2 * half * half;
    const double irradiance = asPower(scene.sun->radiance) * 2 * pi * oneMinusCos;
    const glm::dvec3 towards(scene.sun->directionTowards);
    if (!(irradiance > 0) || !(glm::length(towards) > 0)) return;
    shared::Emitter e{};
    e.kind = shared::kEmitterSun;
    e.b = glm::vec3(glm::normalize(towards));
    e.scale = static_cast<float>(oneMinusCos);
    e.radiance = scene.sun->radiance;
    world.sunEmitter = static_cast<uint32_t>(out.emitters.size());
    out.addFar(e, irradiance);
    world.features |= shared::kFeatureSun;
}

/// Both kinds with half of the sum, where there are both.
void balanceKinds(std::vector<double>& weights, size_t nearCount)
{
    const auto middle = weights.begin() + static_cast<std::ptrdiff_t>(nearCount);
    const double near = std::accumulate(weights.begin(), middle, 0.0);
    const double far = std::accumulate(middle, weights.end(), 0.0);
    if (!(near > 0) || !(far > 0)) return;
    for (auto w = weights.begin(); w != weights.end(); ++w) *w /= w < middle ? near : far;
}

// Fewer emitters with a place than these are told apart well enough by their power.
constexpr size_t kFewEmitters = 8;

}  // namespace

void findEmission(World& world, Topology& topology, const Scene& scene)
{
    topology.emission = emissiveTriangles(world);
    if (!topology.emission.empty() ||
        (topology.forcedFeatures & shared::kFeatureEmissiveTriangles) != 0) {
        std::vector<uint32_t> emitterOf(world.triangles.size(), shared::kNone);
        for (size_t i = 0; i < topology.emission.size(); ++i)
            emitterOf[topology.emission[i].triangle] = static_cast<uint32_t>(i);
        world.triangleEmitter = std::move(emitterOf);
    }
    if (!scene.environment || scene.environment->texels.empty()) return;
    const Environment& environment = *scene.environment;
    const std::vector<double> weights =
        environmentWeights(environment.texels, environment.width, environment.height);
    topology.environmentWeight = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (!(topology.environmentWeight * static_cast<double>(environment.intensity) > 0)) return;
    world.environment = environment.texels;
    world.environmentWidth = environment.width;
    world.environmentHeight = environment.height;
    world.environmentIntensity = environment.intensity;
    world.environmentCdf = makeEnvironmentCdf(weights, environment.width, environment.height);
}

void collectEmitters(World& world, const Topology& topology, const Scene& scene, const Pose& pose)
{
    Collected all;
    // Where another pose has a tree it has decided: kernels stay what they are.
    const bool decided = !world.emitterTree.empty();
    world.environmentEmitter = world.sunEmitter = shared::kNone;
    addTriangles(world, topology.emission, all);
    addPunctual(world, scene, pose, true, all);
    addPunctual(world, scene, pose, false, all);
    addEnvironment(world, topology.environmentWeight, all);
    addSun(world, scene, all);
    const size_t count = all.emitters.size();
    if (count > kMaxCdfEntries) {
        throw Error(scene.file.string() + ": " + std::to_string(count) + " emitters, at most " +
                    std::to_string(kMaxCdfEntries) + " fit — let fewer triangles emit");
    }
    if (count > 1) world.features |= shared::kFeatureManyEmitters;
    balanceKinds(all.weights, all.nearCount());
    replaceIfChanged(world.emitterCdf, count == 0 ? std::vector<float>() : makeCdf(all.weights));
    const bool changed = replaceIfChanged(world.emitters, std::move(all.emitters));
    const bool many = all.nearCount() > kFewEmitters;
    if (changed || many == world.emitterTree.empty())
        world.emitterTree = many ? makeEmitterTree(all.bounds) : std::vector<glm::uvec4>();
    const bool pays =
        many && (decided ? world.treeEmitters > 0 : treeGain(world, all.bounds) >= kTreePays);
    world.treeEmitters = pays ? static_cast<uint32_t>(all.nearCount()) : 0;
    if (pays) world.features |= shared::kFeatureEmitterTree;
}

}  // namespace core

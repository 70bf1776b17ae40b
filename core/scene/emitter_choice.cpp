// See emitter_choice.h.
#include "core/scene/emitter_choice.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"
#include "core/base/pcg32.h"
#include "core/scene/emitter_tree.h"
#include "core/scene/world.h"
#include "shared/instances.h"
#include "shared/lights.h"

namespace core {

namespace {

constexpr int kPlaces = 512, kConnections = 16;  // of each way at a place
constexpr double kUnnoticed = 0.01;              // of the light: a deviation that small is none

struct Place {
    glm::vec3 position, normal;
};

float unit(Pcg32& random)
{
    return static_cast<float>(random.bits() >> 8) * 0x1p-24f;
}

bool isHeads(Pcg32& random)
{
    return (random.bits() >> 31) != 0;
}

/// Draws places of a world, on what is shown of it: half of them by area, half by triangles.
class Places {
public:
    explicit Places(const World& world) : world_(world), flat_(flatTriangles(world))
    {
        double sum = 0;
        areas_.reserve(world.triangles.size());
        for (size_t i = 0; i < world.triangles.size(); ++i) {
            if (!shines(i)) sum += glm::length(twiceArea(cornersOf(i, shared::kNone)));
            areas_.push_back(sum);
        }
        sum = flat_ > 0 ? areas_[flat_ - 1] : 0;
        instancesUpTo_.reserve(world.instances.size());
        for (const Prototype& prototype : world.prototypes) {
            const double own =
                areaBefore(prototype.triangles.end) - areaBefore(prototype.triangles.begin);
            for (uint32_t i = prototype.instances.begin; i < prototype.instances.end; ++i) {
                sum += own * areaScale(world.instances[i]);
                instancesUpTo_.push_back(sum);
            }
        }
        total_ = sum;
    }

    bool empty() const { return !(total_ > 0); }

    Place draw(Pcg32& random) const
    {
        const Shown shown = isHeads(random) ? byArea(random) : byCount(random);
        const Corners c = cornersOf(shown.triangle, shown.instance);
        const float root = std::sqrt(unit(random)), along = unit(random);
        Place place;
        place.position = (1 - root) * c.a + root * ((1 - along) * c.b + along * c.c);
        place.normal = glm::vec3(glm::normalize(twiceArea(c)));
        if (isHeads(random)) place.normal = -place.normal;
        return place;
    }

private:
    struct Corners {
        glm::vec3 a, b, c;
    };

    struct Shown {
        size_t triangle;
        uint32_t instance = shared::kNone;
    };

    bool shines(size_t triangle) const
    {
        return !world_.triangleEmitter.empty() && world_.triangleEmitter[triangle] != shared::kNone;
    }

    Corners cornersOf(size_t triangle, uint32_t instance) const
    {
        const WorldTriangle& t = world_.triangles[triangle];
        const auto vertex = [&](uint32_t i) {
            const glm::vec3& p = world_.positions[i];
            return instance == shared::kNone
                       ? p
                       : shared::transformPoint(world_.instances[instance], p);
        };
        return {vertex(t.v0), vertex(t.v1), vertex(t.v2)};
    }

    static glm::dvec3 twiceArea(const Corners& t)
    {
        const glm::dvec3 a(t.a), b(t.b), c(t.c);
        return glm::cross(b - a, c - a);
    }

    /// Of an instance to its prototype; exact where the matrix does not stretch.
    static double areaScale(const shared::InstanceMatrix& m)
    {
        const glm::dvec3 a(m.row0), b(m.row1), c(m.row2);
        return std::cbrt(std::pow(glm::dot(glm::cross(a, b), c), 2));
    }

    double areaBefore(size_t triangle) const { return triangle > 0 ? areas_[triangle - 1] : 0; }

    /// The first triangle from `begin` on up to which there is more than this area.
    size_t triangleAt(double area, size_t begin, size_t end) const
    {
        const auto first = areas_.begin();
        const auto found = std::upper_bound(first + static_cast<ptrdiff_t>(begin),
                                            first + static_cast<ptrdiff_t>(end), area);
        return std::min(static_cast<size_t>(found - first), end - 1);
    }

    const Prototype& prototypeOf(uint32_t instance) const
    {
        return *std::ranges::find_if(
            world_.prototypes, [&](const Prototype& p) { return instance < p.instances.end; });
    }

    Shown byArea(Pcg32& random) const
    {
        const double area = random() * total_;
        if (area < areaBefore(flat_)) return {triangleAt(area, 0, flat_)};
        const auto found = std::ranges::upper_bound(instancesUpTo_, area);
        const auto instance = static_cast<uint32_t>(std::min(
            static_cast<size_t>(found - instancesUpTo_.begin()), instancesUpTo_.size() - 1));
        const IndexRange& triangles = prototypeOf(instance).triangles;
        const double begin = areaBefore(triangles.begin);
        const double own = areaBefore(triangles.end) - begin;
        return {triangleAt(begin + random() * own, triangles.begin, triangles.end), instance};
    }

    Shown byCount(Pcg32& random) const
    {
        const auto shown = static_cast<double>(shownTriangles(world_));
        for (;;) {
            auto i = static_cast<uint64_t>(random() * shown);
            if (i < flat_) {
                if (shines(i)) continue;
                return {i};
            }
            i -= flat_;
            for (const Prototype& p : world_.prototypes) {
                const uint64_t own = uint64_t(p.triangles.size()) * p.instances.size();
                if (i < own)
                    return {p.triangles.begin + i % p.triangles.size(),
                            p.instances.begin + static_cast<uint32_t>(i / p.triangles.size())};
                i -= own;
            }
        }
    }

    const World& world_;
    size_t flat_;                        // triangles that stand for themselves
    std::vector<double> areas_;          // twice, of what is stored, up to and with each triangle
    std::vector<double> instancesUpTo_;  // of all up to and with each instance
    double total_ = 0;
};

/// What a connection brings from an emitter to a place, with probability `pmf` of that emitter;
/// textures as their mean.
double contribution(const shared::Emitter& e, const EmitterBounds& bounds, const Place& place,
                    double pmf, glm::vec2 u)
{
    shared::EmitterSample s;
    const bool isTriangle = (e.kind & 0xffu) == shared::kEmitterTriangle;
    const bool found = isTriangle ? shared::sampleTriangleEmitter(e, place.position, u, s)
                                  : shared::samplePunctual(e, place.position, s);
    const auto cosine = static_cast<double>(glm::dot(s.wi, place.normal));
    if (!found || !(cosine > 0)) return 0;
    if (!isTriangle) return cosine * static_cast<double>(shared::luminance(s.radiance)) / pmf;
    const double area = 0.5 * glm::length(glm::cross(glm::dvec3(e.b - e.a), glm::dvec3(e.c - e.a)));
    const double density = pmf * static_cast<double>(s.pdf), other = cosine / std::numbers::pi;
    const double weight = density * density / (density * density + other * other);
    return cosine * bounds.intensity / area * weight / density;
}

/// Sums over the connections of one way at one place.
struct Connections {
    double sum = 0, squares = 0;

    void add(double x)
    {
        sum += x;
        squares += x * x;
    }
    double mean() const { return sum / kConnections; }
    double deviation() const
    {
        return std::sqrt(std::max(0.0, squares / kConnections - mean() * mean()));
    }
};

}  // namespace

double treeGain(const World& world, std::span<const EmitterBounds> bounds)
{
    CHECK(!world.emitterTree.empty() && bounds.size() <= world.emitters.size());
    const Places places(world);
    if (places.empty()) return 1;
    shared::SceneView view{};
    view.emitterCdf = world.emitterCdf.data();
    view.emitterTree = world.emitterTree.data();
    shared::PathSettings settings[2]{};  // by power, by the tree
    for (shared::PathSettings& s : settings)
        s.emitterCount = static_cast<uint32_t>(world.emitters.size());
    settings[1].treeEmitters = static_cast<uint32_t>(bounds.size());

    Pcg32 random(0x7ee);
    double deviations[2] = {0, 0}, light = 0;
    for (int k = 0; k < kPlaces; ++k) {
        const Place place = places.draw(random);
        const uint32_t departure = shared::packReceiver(place.normal);
        for (size_t way = 0; way < 2; ++way) {
            Connections connections;
            for (int i = 0; i < kConnections; ++i) {
                const float u = (static_cast<float>(i) + unit(random)) / kConnections;
                const float x = unit(random), y = unit(random);
                float pmf;
                const uint32_t chosen =
                    shared::chooseEmitterFor(view, settings[way], place.position, departure,
                                             std::min(u, shared::kOneMinusEpsilon), pmf);
                if (!(pmf > 0) || chosen >= bounds.size()) continue;  // from afar: the same by both
                connections.add(contribution(world.emitters[chosen], bounds[chosen], place,
                                             static_cast<double>(pmf), {x, y}));
            }
            deviations[way] += connections.deviation();
            light += connections.mean() / 2;
        }
    }
    if (!(light > 0)) return 1;
    return (deviations[0] + kUnnoticed * light) / (deviations[1] + kUnnoticed * light);
}

static std::shared_ptr<const World> withTreeOf(const std::shared_ptr<const World>& world,
                                               uint32_t emitters)
{
    if (world->treeEmitters == emitters) return world;
    auto other = std::make_shared<World>(*world);
    other->treeEmitters = emitters;
    other->features = emitters > 0 ? world->features | shared::kFeatureEmitterTree
                                   : world->features & ~shared::kFeatureEmitterTree;
    return other;
}

std::shared_ptr<const World> chosenByPower(const std::shared_ptr<const World>& world)
{
    return withTreeOf(world, 0);
}

std::shared_ptr<const World> chosenByPlace(const std::shared_ptr<const World>& world)
{
    if (world->emitterTree.empty()) return world;
    const auto isNear = [](const shared::Emitter& e) {
        const uint32_t kind = e.kind & 0xffu;
        return kind == shared::kEmitterTriangle || kind == shared::kEmitterPoint ||
               kind == shared::kEmitterSpot;
    };
    return withTreeOf(world, static_cast<uint32_t>(std::ranges::count_if(world->emitters, isNear)));
}

}  // namespace core

// See emitter_choice.h.
#include "core/scene/emitter_choice.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/check.h"
#include "core/base/pcg32.h"
#include "core/scene/emitter_tree.h"
#include "core/scene/shown_places.h"
#include "core/scene/world.h"
#include "shared/lights.h"
#include "shared/rng.h"

namespace core {

namespace {

constexpr int kPlaces = 512, kConnections = 16;  // of each way at a place
constexpr double kUnnoticed = 0.01;              // of the light: a deviation that small is none

/// What a connection brings from an emitter to a place, with probability `pmf` of that emitter;
/// textures as their mean.
double contribution(const shared::Emitter& e, const EmitterBounds& bounds,
                    const ShownPlaces::Place& place, double pmf, glm::vec2 u)
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
    const ShownPlaces places(world);
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
        const ShownPlaces::Place place = places.draw(random);
        const uint32_t departure = shared::packReceiver(place.normal);
        for (size_t way = 0; way < 2; ++way) {
            Connections connections;
            for (int i = 0; i < kConnections; ++i) {
                const float u =
                    (static_cast<float>(i) + shared::unitFloat(random.bits())) / kConnections;
                const float x = shared::unitFloat(random.bits()),
                            y = shared::unitFloat(random.bits());
                const shared::EmitterChoice chosen = shared::finishChoice(
                    view, place.position, departure,
                    shared::beginChoiceFor(view, settings[way],
                                           std::min(u, shared::kOneMinusEpsilon)));
                // From afar: the same by both.
                if (!(chosen.pmf > 0) || chosen.emitter >= bounds.size()) continue;
                connections.add(contribution(world.emitters[chosen.emitter], bounds[chosen.emitter],
                                             place, static_cast<double>(chosen.pmf), {x, y}));
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

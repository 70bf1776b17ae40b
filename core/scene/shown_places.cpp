// See shown_places.h.
#include "core/scene/shown_places.h"

#include <algorithm>
#include <cmath>

#include "core/scene/world.h"
#include "shared/instances.h"
#include "shared/rng.h"

namespace core {

namespace {

bool isHeads(Pcg32& random)
{
    return (random.bits() >> 31) != 0;
}

glm::dvec3 twiceArea(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    return glm::cross(b - a, c - a);
}

/// Area of an instance over that of its prototype; exact where the matrix does not stretch.
double areaScale(const shared::InstanceMatrix& m)
{
    const glm::dvec3 a(m.row0), b(m.row1), c(m.row2);
    return std::cbrt(std::pow(glm::dot(glm::cross(a, b), c), 2));
}

}  // namespace

ShownPlaces::ShownPlaces(const World& world)
    : world_(world), flat_(flatTriangles(world)), shown_(shownTriangles(world))
{
    double sum = 0;
    areas_.reserve(world.triangles.size());
    for (uint32_t i = 0; i < world.triangles.size(); ++i) {
        if (!shines(i)) {
            const Corners t = cornersOf({i});
            sum += glm::length(twiceArea(t.a, t.b, t.c));
            if (i < flat_ && !world.triangleEmitter.empty()) dark_.push_back(i);
        }
        areas_.push_back(sum);
    }
    sum = areaBefore(flat_);
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

ShownPlaces::Place ShownPlaces::draw(Pcg32& random) const
{
    const Corners c = cornersOf(isHeads(random) ? byArea(random) : byCount(random));
    const float root = std::sqrt(shared::unitFloat(random.bits())),
                along = shared::unitFloat(random.bits());
    Place place;
    place.position = (1 - root) * c.a + root * ((1 - along) * c.b + along * c.c);
    place.normal = glm::vec3(glm::normalize(twiceArea(c.a, c.b, c.c)));
    if (isHeads(random)) place.normal = -place.normal;
    return place;
}

bool ShownPlaces::shines(uint64_t triangle) const
{
    return !world_.triangleEmitter.empty() && world_.triangleEmitter[triangle] != shared::kNone;
}

ShownPlaces::Corners ShownPlaces::cornersOf(const Shown& shown) const
{
    const WorldTriangle& t = world_.triangles[shown.triangle];
    const auto vertex = [&](uint32_t i) {
        const glm::vec3& p = world_.positions[i];
        return shown.instance == shared::kNone
                   ? p
                   : shared::transformPoint(world_.instances[shown.instance], p);
    };
    return {vertex(t.v0), vertex(t.v1), vertex(t.v2)};
}

/// The first triangle from `begin` on up to which there is more than this area.
uint64_t ShownPlaces::triangleAt(double area, uint64_t begin, uint64_t end) const
{
    const auto first = areas_.begin();
    const auto found = std::upper_bound(first + static_cast<std::ptrdiff_t>(begin),
                                        first + static_cast<std::ptrdiff_t>(end), area);
    return std::min(static_cast<uint64_t>(found - first), end - 1);
}

const Prototype& ShownPlaces::prototypeOf(uint32_t instance) const
{
    return *std::ranges::find_if(world_.prototypes,
                                 [&](const Prototype& p) { return instance < p.instances.end; });
}

ShownPlaces::Shown ShownPlaces::byArea(Pcg32& random) const
{
    const double area = random() * total_;
    if (area < areaBefore(flat_)) return {triangleAt(area, 0, flat_)};
    const auto found = std::ranges::upper_bound(instancesUpTo_, area);
    const auto instance = static_cast<uint32_t>(
        std::min(static_cast<size_t>(found - instancesUpTo_.begin()), instancesUpTo_.size() - 1));
    const IndexRange& triangles = prototypeOf(instance).triangles;
    const double begin = areaBefore(triangles.begin);
    const double own = areaBefore(triangles.end) - begin;
    return {triangleAt(begin + random() * own, triangles.begin, triangles.end), instance};
}

/// Where a good part does not shine, the first tries find it and need no list.
ShownPlaces::Shown ShownPlaces::byCount(Pcg32& random) const
{
    for (int k = 0; k < kTries; ++k) {
        const auto i = static_cast<uint64_t>(random() * static_cast<double>(shown_));
        if (i >= flat_) return instanced(i - flat_);
        if (!shines(i)) return {i};
    }
    const double left = static_cast<double>(dark_.size() + (shown_ - flat_));
    const auto i = static_cast<uint64_t>(random() * left);
    return i < dark_.size() ? Shown{dark_[i]} : instanced(i - dark_.size());
}

/// Of the triangles that instances show, prototype after prototype.
ShownPlaces::Shown ShownPlaces::instanced(uint64_t index) const
{
    for (const Prototype& p : world_.prototypes) {
        const uint64_t own = uint64_t(p.triangles.size()) * p.instances.size();
        if (index < own)
            return {p.triangles.begin + index % p.triangles.size(),
                    p.instances.begin + static_cast<uint32_t>(index / p.triangles.size())};
        index -= own;
    }
    return {};
}

}  // namespace core

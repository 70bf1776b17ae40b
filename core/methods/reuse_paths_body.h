// New paths of sample reuse (shaders/shared/reuse_new.h) that go on together on a CPU core: rays
// are traced in packets of 16, the rest is one path at a time. Included once by each variant.
#include <array>
#include <span>

#include "core/base/per_thread.h"
#include "core/methods/reuse_estimator.h"
#include "shared/reuse_new.h"

namespace core {

namespace {

/// A path from a first hit, or along a way that mirrors and glass have not taken.
struct NewPath {
    uint32_t pixel;                // whose it is
    const shared::ReuseVertex* v;  // nullptr: such a way
    shared::PathSettings settings;
    shared::SampleStream stream;
    shared::PathState ray;
    shared::ReuseTrail trail;
    float importance;
    glm::vec3 gathered;
    shared::ReuseNew result;
};

class NewPaths {
public:
    static constexpr size_t kMost = 256;

    NewPaths(const TracedScene& scene, const shared::ReuseSettings& settings,
             shared::ReuseTally& tally)
        : scene_(scene), settings_(settings), tally_(tally)
    {
        wave_.count = 0;
    }

    bool isFull() const { return wave_.count == kMost; }

    /// A path from the first hit `v`, which is not copied.
    void add(uint32_t pixel, const shared::ReuseVertex& v, const shared::PathSettings& settings,
             shared::SampleStream stream)
    {
        NewPath& p = addPath(pixel, settings, stream, shared::pathFromHere(v));
        p.v = &v;
    }

    /// The way not taken that `ray` goes (restOfChain).
    void addRest(uint32_t pixel, const shared::PathSettings& settings, shared::SampleStream stream,
                 const shared::PathState& ray)
    {
        addPath(pixel, settings, stream, ray).v = nullptr;
    }

    /// Takes all of them to their ends, and returns them in the order in which they were added,
    /// until the next is.
    std::span<const NewPath> trace()
    {
        begin();
        connect();
        while (wave_.activeCount > 0) {
            meet();
            extend();
            connect();
        }
        for (NewPath& p : paths())
            if (p.v && p.trail.mean > 0)
                shared::endNewPath(scene_, settings_, *p.v, p.gathered, p.stream, p.trail, p.result,
                                   tally_);
        const std::span<const NewPath> all = paths();
        wave_.count = 0;
        return all;
    }

private:
    struct Connection {
        uint32_t path, depth;
        shared::ShadowRay shadow;
    };

    struct Wave {
        std::array<NewPath, kMost> paths;
        std::array<uint32_t, kMost> active;
        std::array<Ray, kMost> rays;
        std::array<shared::Hit, kMost> hits;
        std::array<Connection, kMost> connections;
        std::array<uint8_t, kMost> blocked;
        size_t count, activeCount, connectionCount;
    };

    std::span<NewPath> paths() { return std::span(wave_.paths).first(wave_.count); }

    NewPath& addPath(uint32_t pixel, const shared::PathSettings& settings,
                     const shared::SampleStream& stream, const shared::PathState& ray)
    {
        NewPath& p = wave_.paths[wave_.count++];
        p.pixel = pixel;
        p.settings = settings;
        p.stream = stream;
        p.ray = ray;
        p.trail = shared::noReuseTrail();
        p.importance = 1;
        p.gathered = glm::vec3(0);
        p.result = shared::noReuseNew();
        return p;
    }

    static uint32_t seedOf(const NewPath& p, uint32_t depth, uint32_t shadow)
    {
        return FEATURE(shared::kFeatureAlpha) ? shared::alphaSeed(p.stream, depth, shadow) : 0u;
    }

    void propose(size_t i, uint32_t depth, const shared::ShadowRay& shadow)
    {
        if (shared::maxComponent(shadow.contribution) > 0)
            wave_.connections[wave_.connectionCount++] = {static_cast<uint32_t>(i), depth, shadow};
    }

    void begin()
    {
        wave_.activeCount = wave_.connectionCount = 0;
        for (size_t i = 0; i < wave_.count; ++i) {
            NewPath& p = wave_.paths[i];
            bool goes = true;
            if (p.v) {
                shared::ShadowRay shadow;
                goes = shared::beginNewPath(scene_, p.settings, settings_, *p.v, p.stream, p.ray,
                                            p.trail, p.result.light, shadow);
                p.importance = shared::maxComponent(p.trail.weight);
                propose(i, 0, shadow);
            }
            if (goes) wave_.active[wave_.activeCount++] = static_cast<uint32_t>(i);
        }
    }

    void meet()
    {
        for (size_t k = 0; k < wave_.activeCount; ++k) {
            const NewPath& p = wave_.paths[wave_.active[k]];
            wave_.rays[k] = {p.ray.origin, shared::kInfinity, p.ray.direction,
                             seedOf(p, p.ray.depth, 0)};
        }
        tally_.closestRays += static_cast<uint32_t>(wave_.activeCount);
        scene_.accel->closest({wave_.rays.data(), wave_.activeCount}, wave_.hits.data());
    }

    void extend()
    {
        size_t going = 0;
        wave_.connectionCount = 0;
        for (size_t k = 0; k < wave_.activeCount; ++k) {
            const uint32_t i = wave_.active[k];
            NewPath& p = wave_.paths[i];
            const uint32_t depth = p.ray.depth;
            shared::ShadowRay shadow;
            const bool goes = shared::extendNewPath(scene_, p.settings, settings_, p.importance,
                                                    p.stream, wave_.hits[k], p.ray, p.gathered,
                                                    p.trail, p.result.record, shadow);
            propose(i, depth, shadow);
            if (goes) wave_.active[going++] = i;
        }
        wave_.activeCount = going;
    }

    void connect()
    {
        const size_t count = wave_.connectionCount;
        for (size_t s = 0; s < count; ++s) {
            const Connection& c = wave_.connections[s];
            wave_.rays[s] = {c.shadow.origin, c.shadow.tMax, c.shadow.direction,
                             seedOf(wave_.paths[c.path], c.depth, 1)};
        }
        tally_.shadowRays += static_cast<uint32_t>(count);
        scene_.accel->occluded({wave_.rays.data(), count}, wave_.blocked.data());
        for (size_t s = 0; s < count; ++s) {
            Connection& c = wave_.connections[s];
            NewPath& p = wave_.paths[c.path];
            if (wave_.blocked[s] != 0 && !comesThrough(c.shadow, wave_.rays[s].seed)) continue;
            if (c.depth == 0) {
                shared::takeFirstConnection(scene_, p.settings, settings_, *p.v, c.shadow, p.stream,
                                            p.result, tally_);
            } else {
                shared::takeConnection(c.shadow, c.depth, p.stream, p.gathered, p.trail,
                                       p.result.record);
            }
        }
    }

    bool comesThrough(shared::ShadowRay& shadow, uint32_t seed)
    {
        return FEATURE(shared::kFeaturePanes) && shadow.passes > 0 &&
               comesThroughPanes(scene_, shadow, seed, tally_);
    }

    Wave& wave_ = perThread<Wave>();
    const TracedScene& scene_;
    const shared::ReuseSettings& settings_;
    shared::ReuseTally& tally_;
};

}  // namespace

}  // namespace core

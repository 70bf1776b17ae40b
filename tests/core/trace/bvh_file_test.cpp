// Hierarchies in files (N25): what is read equals what was built in every bit; bytes that are
// damaged, cut off, of other triangles or put together in malice are refused, or are as good as the
// built ones; keys tell everything apart that the builder sees. The last test knows what the
// builder makes, so that nobody changes it without another kBvhFileVersion.
#include <array>
#include <gtest/gtest.h>

#include <random>

#include "core/base/content_hash.h"
#include "core/trace/bvh_check.h"
#include "core/trace/bvh_file.h"
#include "core/trace/world_bvh.h"
#include "tests/support/scenes/animated_scenes.h"
#include "tests/support/scenes/instanced_scenes.h"
#include "tests/support/scenes/meshes.h"

namespace {

using core::Bvh;
using core::BvhOptions;
using core::WorldTriangle;
using glm::vec3;
using shared::uvec4;
using tests::Mesh;
using Bytes = std::vector<std::byte>;

/// What a hierarchy is built of.
struct Input {
    const char* name;
    std::vector<vec3> positions;
    std::vector<WorldTriangle> triangles;
    BvhOptions options;
    std::shared_ptr<const core::World> world;  // keeps what `options` look at

    Bvh build() const { return core::buildBvh(positions, triangles, options); }
    std::optional<Bvh> read(std::span<const std::byte> bytes) const
    {
        return core::bvhFromBytes(bytes, positions, triangles, options);
    }
    bool isSound(const Bvh& bvh) const { return core::isSound(bvh, positions, triangles, options); }
    core::BvhKey key() const { return core::bvhKey(positions, triangles, options); }
};

Input of(const char* name, const Mesh& mesh, const BvhOptions& options = {})
{
    return {name, mesh.positions, mesh.triangles, options, nullptr};
}

Input of(const char* name, std::shared_ptr<const core::World> world)
{
    Input input{name, world->positions.toVector(), world->triangles.toVector(), {}, world};
    input.options.moving = world->movingTriangles;
    input.options.prototypes = {world->prototypes.data(), world->prototypes.size()};
    input.options.instances = {world->instances.data(), world->instances.size()};
    if (!input.options.moving.empty()) {
        input.options.reachLow = world->reachLow;
        input.options.reachHigh = world->reachHigh;
    }
    return input;
}

/// A room of which the end moves, with or without the rest.
Input moving(bool alone)
{
    Input input = of(alone ? "all moves" : "a part moves", tests::roomMesh(3));
    const auto count = static_cast<uint32_t>(input.triangles.size());
    input.options.moving = {alone ? 0 : count / 2, count};
    input.options.reachLow = vec3(-9);
    input.options.reachHigh = vec3(9);
    return input;
}

std::vector<Input> inputs()
{
    std::vector<Input> all;
    all.push_back(of("room", tests::roomMesh(1)));
    all.push_back(of("one triangle", tests::identicalMesh(1)));
    all.push_back(of("soup", tests::soupMesh(3000, 0.2f, 4)));
    all.push_back(of("hair", tests::hairMesh(40, 2)));
    all.push_back(of("no cuts", tests::soupMesh(700, 0.3f, 5), {.duplicateBudget = 0}));
    for (const tests::FarScene& far : tests::farScenes()) all.push_back(of(far.name, far.mesh));
    all.push_back(moving(false));
    all.push_back(moving(true));
    all.push_back(of("thicket", worldOf(tests::thicket(40), core::Instancing::kept)));
    all.push_back(of("moving room", tests::movingRoom().world()));
    return all;
}

template <class T> void expectSameBits(const T& a, const T& b, const char* what)
{
    EXPECT_EQ(std::memcmp(&a, &b, sizeof(T)), 0) << what;
}

void expectSamePart(const core::BvhPart& a, const core::BvhPart& b)
{
    EXPECT_EQ(a.nodes, b.nodes);
    EXPECT_EQ(a.slots, b.slots);
    expectSameBits(a.low, b.low, "low");
    expectSameBits(a.high, b.high, "high");
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.gridChanges, b.gridChanges);
    expectSameBits(a.cost, b.cost, "cost");
}

void expectSame(const Bvh& a, const Bvh& b)
{
    expectSamePart(a.moving, b.moving);
    expectSamePart(a.still, b.still);
    expectSameBits(a.gridLow, b.gridLow, "gridLow");
    expectSameBits(a.gridScale, b.gridScale, "gridScale");
    EXPECT_EQ(a.depth, b.depth);
    expectSameBits(a.cost, b.cost, "cost");
    expectSameBits(a.triangleCost, b.triangleCost, "triangleCost");
    EXPECT_EQ(a.movingNodes, b.movingNodes);
    expectSameBits(a.movingLeast, b.movingLeast, "movingLeast");
    expectSameBits(a.movingRatio, b.movingRatio, "movingRatio");
    EXPECT_EQ(a.prototypeSlots, b.prototypeSlots);
}

/// Both find the same distances, to the bit. Of instances only that rays come to an end.
void expectSameHits(const Input& input, const Bvh& a, const Bvh& b, int rays)
{
    std::mt19937 engine(9);
    const auto random = [&] {
        const auto one = [&] { return static_cast<float>(engine() >> 8) * 0x1p-23f - 1; };
        return vec3(one(), one(), one());
    };
    for (int i = 0; i < rays; ++i) {
        const vec3 target = input.positions[engine() % input.positions.size()];
        const vec3 origin = target + 3.0f * random(),
                   direction = target - origin + 0.01f * random();
        core::BvhHit x, y;
        core::traceClosest(a, input.positions, input.triangles, origin, direction, 0,
                           shared::kInfinity, x);
        core::traceClosest(b, input.positions, input.triangles, origin, direction, 0,
                           shared::kInfinity, y);
        EXPECT_EQ(x.t, y.t) << "ray " << i;
    }
}

TEST(BvhFile, WhatIsReadIsWhatWasBuilt)
{
    for (const Input& input : inputs()) {
        SCOPED_TRACE(input.name);
        const Bvh built = input.build();
        EXPECT_TRUE(input.isSound(built));
        const Bytes bytes = core::bvhBytes(built);
        const std::optional<Bvh> read = input.read(bytes);
        ASSERT_TRUE(read.has_value());
        expectSame(*read, built);
        EXPECT_EQ(core::bvhBytes(*read), bytes);
    }
}

TEST(BvhFile, ItIsRefittedAsTheBuiltOneIs)
{
    const Input input = moving(false);
    const Bvh built = input.build();
    const std::optional<Bvh> read = input.read(core::bvhBytes(built));
    ASSERT_TRUE(read.has_value());
    std::vector<vec3> moved = input.positions;
    for (uint32_t t = input.options.moving.begin; t < input.options.moving.end; ++t) {
        const uint32_t v = input.triangles[t].v0;
        moved[v] = input.positions[v] + vec3(0.1f, 0.2f, 0.3f);
    }
    const auto a = core::refitBvh(built, moved, input.triangles);
    const auto b = core::refitBvh(*read, moved, input.triangles);
    ASSERT_TRUE(a.has_value() && b.has_value());
    expectSame(*a, *b);
    const auto c = core::rebuildMoving(*a, moved, input.triangles, input.options);
    const auto d = core::rebuildMoving(*b, moved, input.triangles, input.options);
    ASSERT_TRUE(c.has_value() && d.has_value());
    expectSame(*c, *d);
}

TEST(BvhFile, WhatIsCutOffOrTooLongIsRefused)
{
    const Input input = moving(false);
    const Bytes bytes = core::bvhBytes(input.build());
    for (size_t cut = 0; cut < bytes.size(); cut += cut < 400 ? 1 : 97)
        EXPECT_FALSE(input.read(std::span(bytes).first(cut)).has_value()) << cut;
    Bytes longer = bytes;
    longer.push_back(std::byte{0});
    EXPECT_FALSE(input.read(longer).has_value());
}

/// Any byte changed to anything: refused, or as good as before. Nothing of the file's checksum is
/// in the way here.
void expectHarmless(const Input& input, size_t step, int rays)
{
    SCOPED_TRACE(input.name);
    const Bvh built = input.build();
    const Bytes bytes = core::bvhBytes(built);
    std::mt19937 engine(3);
    size_t refused = 0, tried = 0;
    for (size_t i = 0; i < bytes.size(); i += 1 + engine() % step, ++tried) {
        Bytes damaged = bytes;
        damaged[i] ^=
            static_cast<std::byte>(engine() % 2 == 0 ? 1u << engine() % 8 : 1 + engine() % 255);
        const std::optional<Bvh> read = input.read(damaged);
        refused += !read;
        if (!read) continue;
        EXPECT_LE(read->depth, shared::kBvhMaxDepth);
        expectSameHits(input, built, *read, rays);
        core::refitBvh(*read, input.positions, input.triangles);
        if (testing::Test::HasFailure()) FAIL() << "byte " << i;
    }
    EXPECT_GT(refused, tried / 2);
}

TEST(BvhFile, NoByteCanDoHarm)
{
    expectHarmless(of("no cuts", tests::soupMesh(300, 0.3f, 5), {.duplicateBudget = 0}), 60, 10);
    Input part = moving(false);
    part.options.duplicateBudget = 0;
    expectHarmless(part, 2000, 10);
    Input far = of("far", tests::farScenes()[0].mesh);
    far.options.duplicateBudget = 0;
    expectHarmless(far, 4000, 10);
    // Rays come to an end; that they find the same is not asked of what has been cut.
    expectHarmless(of("thicket", worldOf(tests::thicket(20), core::Instancing::kept)), 600, 0);
}

/// A change of one word that no checksum hides.
void expectRefused(const Input& input, const Bvh& built, size_t word, uvec4 value, const char* what)
{
    Bvh bvh = built;
    std::vector<uvec4> nodes = bvh.still.nodes.toVector();
    ASSERT_NE(nodes[word], value);
    nodes[word] = value;
    bvh.still.nodes = std::move(nodes);
    EXPECT_FALSE(input.isSound(bvh)) << what;
}

TEST(BvhFile, TreesMadeInMaliceAreRefused)
{
    const Input input = of("soup", tests::soupMesh(500, 0.2f, 4), {.duplicateBudget = 0});
    const Bvh built = input.build();
    const uvec4 first = built.still.nodes[0], second = built.still.nodes[1];
    ASSERT_EQ(first.w & shared::kBvhLeaf, 0u);
    const auto leading = [](uvec4 record, uint32_t reference) {
        record.w = reference;
        return record;
    };
    expectRefused(input, built, 0, leading(first, 0), "a loop");
    expectRefused(input, built, 0, leading(first, second.w), "two ways to a node: 2^depth steps");
    expectRefused(input, built, 0, leading(first, shared::kBvhDone), "an end in the midst");
    expectRefused(input, built, 0, leading(first, 0x07ffffff), "a node that does not exist");
    expectRefused(input, built, 0, leading(first, shared::kBvhChange | first.w), "no change");
    expectRefused(input, built, 0, leading(first, shared::kBvhLeaf | 1u << shared::kBvhCountShift),
                  "a leaf in place of a tree");
    expectRefused(input, built, 0, leading(first, 0xf7ffffff), "slots that do not exist");
    expectRefused(input, built, 0, leading(first, first.w | 0x40000000), "a number with more bits");
    expectRefused(input, built, 0, uvec4(0, 0, 0, first.w), "a box that holds nothing");

    Bvh bvh = built;
    std::vector<uint32_t> slots = bvh.still.slots.toVector();
    std::swap(slots.front(), slots.back());
    bvh.still.slots = slots;
    EXPECT_FALSE(input.isSound(bvh)) << "triangles in each other's boxes";
    slots.front() = static_cast<uint32_t>(input.triangles.size());
    bvh.still.slots = slots;
    EXPECT_FALSE(input.isSound(bvh)) << "a triangle that does not exist";
    bvh = built;
    bvh.gridScale.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(input.isSound(bvh));
    bvh = built;
    bvh.still.gridChanges = 1;  // kernels are compiled without what is not there, and with what is
    EXPECT_FALSE(input.isSound(bvh));
    bvh = built;
    bvh.movingNodes = 1;
    EXPECT_FALSE(input.isSound(bvh));
    EXPECT_TRUE(input.isSound(built));
}

/// Deeper than the stack of a traversal, and right in everything else.
TEST(BvhFile, ATreeThatIsTooDeepIsRefused)
{
    const Mesh mesh = tests::identicalMesh(90);
    const Input input = of("a list", mesh);
    Bvh bvh = input.build();
    std::vector<uvec4> nodes;
    std::vector<uint32_t> slots;
    const uint32_t all = 0xffff0000u, leaf = shared::kBvhLeaf | 1u << shared::kBvhCountShift;
    const auto size = static_cast<uint32_t>(mesh.triangles.size());
    const auto chain = [&](uint32_t length) {
        nodes.clear();
        slots.clear();
        for (uint32_t i = 0; i < length; ++i) {
            const bool last = i + 1 == length;
            const uint32_t rest = size - i;  // triangles
            nodes.emplace_back(all, all, all, leaf | i);
            nodes.emplace_back(all, all, all, last ? leaf | (i + 1) : i + 1);
            slots.push_back(i);
            if (last) slots.push_back(i + 1);
            if (rest < 2) break;
        }
        bvh.still.nodes = nodes;
        bvh.still.slots = slots;
    };
    for (const uint32_t length : {20u, shared::kBvhMaxDepth, shared::kBvhMaxDepth + 1, 80u}) {
        chain(length);
        Input list = input;
        list.triangles.resize(length + 1);
        EXPECT_EQ(list.isSound(bvh), length <= shared::kBvhMaxDepth) << length;
    }
}

TEST(BvhFile, AnotherScenesTreeIsRefused)
{
    const Input a = of("a", tests::soupMesh(500, 0.2f, 4)),
                b = of("b", tests::soupMesh(500, 0.2f, 6));
    EXPECT_FALSE(b.read(core::bvhBytes(a.build())).has_value());
    EXPECT_FALSE(moving(false).read(core::bvhBytes(moving(true).build())).has_value());
    Input instances = of("thicket", worldOf(tests::thicket(20), core::Instancing::kept));
    const Bytes bytes = core::bvhBytes(instances.build());
    ASSERT_TRUE(instances.read(bytes).has_value());
    std::vector<shared::InstanceMatrix> moved(instances.options.instances.begin(),
                                              instances.options.instances.end());
    moved[7].row1.w += 1e-3f;
    instances.options.instances = moved;
    EXPECT_FALSE(instances.read(bytes).has_value());
}

TEST(BvhFile, KeysTellApartWhatIsBuiltFrom)
{
    const auto bytesOf = [](const core::BvhKey& key) {
        const auto bytes = std::as_bytes(std::span(&key, 1));
        return Bytes(bytes.begin(), bytes.end());
    };
    const Input base = of("room", tests::roomMesh(1));
    EXPECT_EQ(bytesOf(base.key()), bytesOf(of("again", tests::roomMesh(1)).key()));
    const auto expectOther = [&](const char* what, auto change) {
        Input other = base;
        change(other);
        EXPECT_NE(bytesOf(other.key()), bytesOf(base.key())) << what;
    };
    expectOther("a vertex",
                [](Input& i) { i.positions[5].y = std::nextafter(i.positions[5].y, 9.0f); });
    expectOther("an index", [](Input& i) { std::swap(i.triangles[3].v0, i.triangles[3].v1); });
    expectOther("one less", [](Input& i) { i.triangles.pop_back(); });
    expectOther("leafSize", [](Input& i) { i.options.leafSize = 4; });
    expectOther("duplicateBudget", [](Input& i) { i.options.duplicateBudget = 0; });
    expectOther("triangleCost", [](Input& i) { i.options.triangleCost = 2; });
    expectOther("moving", [](Input& i) { i.options.moving = {0, 3}; });
    expectOther("reachLow", [](Input& i) { i.options.reachLow = vec3(-1); });
    expectOther("reachHigh", [](Input& i) { i.options.reachHigh = vec3(2); });
    expectOther("maxDepth", [](Input& i) { i.options.maxDepth = 50; });
    const std::vector<core::Prototype> prototypes{{{0, 2}, 2, {0, 1}}};
    expectOther("prototypes", [&](Input& i) { i.options.prototypes = prototypes; });
    const std::vector<shared::InstanceMatrix> instances(1);
    expectOther("instances", [&](Input& i) { i.options.instances = instances; });
    core::BvhKey newer = base.key();
    ++newer.version;
    EXPECT_NE(bytesOf(newer), bytesOf(base.key()));
}

/// Triangles whose vertices are whole numbers: sums and products of them are exact in any order.
Mesh latticeMesh()
{
    Mesh mesh;
    std::mt19937 engine(1);
    const auto vertex = [&](vec3 near) {
        const auto one = [&] { return static_cast<float>(engine() % 9) - 4; };
        return near + vec3{one(), one(), one()};  // in the order of braces, which all agree on
    };
    for (int i = 0; i < 3000; ++i) {
        const auto one = [&] { return static_cast<float>(engine() % 256); };
        const vec3 place{one(), one(), one()};
        const std::array corners{vertex(place), vertex(place), vertex(place)};
        mesh.add(corners[0], corners[1], corners[2]);
    }
    return mesh;
}

/// A change of what the builder makes, or of how it is written, makes files of older programs
/// wrong: raise kBvhFileVersion, then put the numbers found here.
TEST(BvhFile, ItsVersionGrowsWithTheBuilder)
{
    const auto hashOf = [](const Input& input) {
        core::ContentHash hash;
        hash.add(core::bvhBytes(input.build()));
        return hash.value();
    };
    Input input = of("lattice", latticeMesh());
    const uint64_t still = hashOf(input);
    input.options.moving = {1000, 2000};
    const uint64_t moving = hashOf(input);
    input.options.moving = {};
    const std::vector<core::Prototype> prototypes{{{2000, 3000}, 3000, {0, 2}}};
    const std::vector<shared::InstanceMatrix> instances{
        {{1, 0, 0, 40}, {0, 1, 0, 50}, {0, 0, 1, 60}},
        {{2, 0, 0, 10}, {0, 2, 0, 0}, {0, 0, 2, -9}}};
    input.options.prototypes = prototypes;
    input.options.instances = instances;
    const uint64_t instanced = hashOf(input);
    EXPECT_EQ(core::kBvhFileVersion, 1u);
    EXPECT_EQ(still, 14256608179417166873u);
    EXPECT_EQ(moving, 1707478643988831586u);
    EXPECT_EQ(instanced, 12181118052861647277u);
}

}  // namespace

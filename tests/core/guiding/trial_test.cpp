// What paths tell of the way that they were not sampled in: variance and cost of both ways, in a
// small world of two vertices with two directions each, against sums over everything that can
// happen there.
#include "core/guiding/trial.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "core/base/pcg32.h"
#include "core/guiding/guide.h"
#include "core/guiding/lesson.h"

namespace {

using core::Pcg32;
using core::guiding::GuideTables;
using core::guiding::Lesson;
using core::guiding::PathCosts;
using core::guiding::PathRecords;
using core::guiding::Trial;
using core::guiding::TrialRules;
using core::guiding::WayFigures;

constexpr size_t kVertices = 2;
constexpr float kImage = 0.4f;
constexpr uint32_t kRouletteDepth = 1;
// As recorded: with ten bits.
constexpr std::array<double, kVertices> kAlbedos{511.0 / 1023, 306.0 / 1023};
constexpr std::array<std::array<double, 2>, kVertices> kBsdf{{{0.75, 0.25}, {0.5, 0.5}}};
constexpr std::array<std::array<double, 2>, kVertices> kGuide{{{0.125, 0.875}, {0.9, 0.1}}};
constexpr std::array<double, kVertices> kShare{0.4, 0.6}, kReflected{0.8, 0.5};
// Light of a connection at each vertex, and of what the ray in each direction meets.
constexpr std::array<double, kVertices> kConnected{0.2, 0.35};
constexpr std::array<std::array<double, 2>, kVertices> kMet{{{0.05, 1.5}, {2.0, 0.0}}};

/// f |cos| of a direction: what the guide knows is not all.
double fOf(size_t vertex, size_t way)
{
    return kAlbedos[vertex] * (way == 0 ? 0.55 : 0.45);
}

double densityOf(bool guided, size_t vertex, size_t way)
{
    const double share = guided ? kShare[vertex] : 1;
    return share * kBsdf[vertex][way] + (1 - share) * kGuide[vertex][way];
}

/// A path under way: of which density it is one, and what it has.
struct State {
    double probability = 1, beta = 1, albedo = 1, L = 0, survival = 1;
    double squares = 0, arrivals = 0, connections = 0;
};

/// How paths are sampled: with the guide or without, and by which roulette with it.
struct Sampling {
    bool guided = false;
    uint32_t roulette = shared::kRouletteBoth;
};

double survivalAt(const Sampling& by, size_t depth, const State& s)
{
    if (depth < kRouletteDepth || (by.guided && by.roulette == shared::kRouletteNone)) return 1;
    if (!by.guided) return std::min(std::sqrt(s.albedo), 1.0);
    return double(shared::guidedSurvival(by.roulette, float(s.albedo),
                                         float(s.beta * kReflected[depth]), kImage));
}

/// Sums over all that can happen from the vertex on; `whole` gets L^2 and the costs.
void enumerate(const Sampling& by, size_t vertex, State s, State& whole)
{
    const auto ends = [&whole](const State& e) { whole.squares += e.probability * e.L * e.L; };
    const double survival = survivalAt(by, vertex, s);
    if (by.guided) {  // the plain path has had its roulette before it came
        State dead = s;
        dead.probability *= 1 - survival;
        ends(dead);
        s.probability *= survival;
        s.beta /= survival;
        s.albedo /= survival;
    }
    whole.connections += s.probability;
    s.albedo *= kAlbedos[vertex];
    s.L += s.beta * kConnected[vertex];
    for (size_t way = 0; way < 2; ++way) {
        State next = s;
        const double density = densityOf(by.guided, vertex, way);
        next.probability *= density;
        next.beta *= fOf(vertex, way) / density;
        if (!by.guided) {
            const double leaves = survivalAt(by, vertex + 1, next);
            State dead = next;
            dead.probability *= 1 - leaves;
            ends(dead);
            next.probability *= leaves;
            next.beta /= leaves;
            next.albedo /= leaves;
        }
        whole.arrivals += next.probability;
        next.L += next.beta * kMet[vertex][way];
        if (vertex + 1 < kVertices)
            enumerate(by, vertex + 1, next, whole);
        else
            ends(next);
    }
}

State expected(const Sampling& by)
{
    State whole;
    whole.arrivals = 1;
    enumerate(by, 0, {}, whole);
    return whole;
}

/// A guide whose leaves are the vertices.
GuideTables tablesOf()
{
    GuideTables tables;
    for (size_t k = 0; k < kVertices; ++k) {
        tables.leaves.emplace_back(0u, shared::floatAsUint(float(kShare[k])),
                                   shared::floatAsUint(float(kReflected[k])), 0u);
    }
    return tables;
}

struct Recorded {
    std::vector<PathRecords> parts{3};
    std::vector<Lesson> lessons;
};

/// Draws paths in one of the ways, and records them as devices do.
Recorded sampled(const Sampling& by, size_t count)
{
    Recorded out;
    Pcg32 random(by.guided ? 5 : 6);
    for (size_t i = 0; i < count; ++i) {
        PathRecords& part = out.parts[i * 3 / count];
        State s;
        uint32_t made = 0;
        for (size_t vertex = 0; vertex < kVertices; ++vertex) {
            if (by.guided) {
                s.survival = survivalAt(by, vertex, s);
                if (!(random() < s.survival)) break;
                s.beta /= s.survival;
                s.albedo /= s.survival;
            }
            shared::GuideRecord r{};
            r.beta = float(s.beta);
            r.place = shared::packGuidePlace(0, 0, float(kAlbedos[vertex]), float(s.survival));
            r.before = float(s.L);
            s.L += s.beta * kConnected[vertex];
            r.after = float(s.L);
            s.albedo *= kAlbedos[vertex];
            const size_t way = random() < densityOf(by.guided, vertex, 0) ? 0 : 1;
            const double density = densityOf(by.guided, vertex, way);
            s.beta *= fOf(vertex, way) / density;
            bool goesOn = true;
            if (!by.guided) {
                s.survival = survivalAt(by, vertex + 1, s);
                goesOn = random() < s.survival;
                s.beta /= s.survival;
                s.albedo /= s.survival;
            }
            Lesson lesson;
            lesson.leaf = uint32_t(vertex);
            lesson.pdf = goesOn ? float(density) : 0;
            lesson.bsdfPdf = float(kBsdf[vertex][way]);
            lesson.guidePdf = float(kGuide[vertex][way]);
            r.direction = goesOn ? 1 : 0;
            part.records.push_back(r);
            out.lessons.push_back(lesson);
            ++made;
            if (!goesOn) break;
            s.L += s.beta * kMet[vertex][way];
        }
        part.ends.push_back({made, float(s.L), kImage});
    }
    return out;
}

class GuideTrial : public testing::TestWithParam<Sampling> {};

TEST_P(GuideTrial, KnowsBothWaysFromThePathsOfOne)
{
    const Recorded paths = sampled(GetParam(), 400000);
    const TrialRules rules{kRouletteDepth, GetParam().roulette, !GetParam().guided, 0.01};
    Trial trial;
    trial.add(paths.parts, paths.lessons, tablesOf(), rules, 0);
    EXPECT_EQ(trial.paths(), 400000);
    double mean = 0;
    for (const PathRecords& part : paths.parts)
        for (const shared::GuidePathEnd& end : part.ends) mean += double(end.final) / 400000;
    const double weight = 1 / (double(kImage) * double(kImage) + rules.errorFloor);
    for (const bool guided : {false, true}) {
        const State want = expected({guided, GetParam().roulette});
        const WayFigures got = guided ? trial.guided() : trial.plain();
        EXPECT_NEAR(got.variance / weight, want.squares - mean * double(kImage),
                    0.01 * want.squares)
            << guided;
        EXPECT_NEAR(got.arrivals, want.arrivals, 0.01 * want.arrivals) << guided;
        EXPECT_NEAR(got.connections, want.connections, 0.01 * want.connections) << guided;
        EXPECT_NEAR(got.choices, guided ? want.connections : 0, 0.01 * want.connections) << guided;
    }
    const PathCosts free, dear{.connection = 1, .look = 10, .choice = 10};
    EXPECT_GT(trial.gain(free), 1.2);
    EXPECT_LT(trial.gain(dear), 0.5 * trial.gain(free));
}

std::string nameOfSampling(const testing::TestParamInfo<Sampling>& one)
{
    constexpr std::array kinds{"Both", "Albedo", "Light", "None"};
    return std::string(one.param.guided ? "guided" : "plain") + kinds.at(one.param.roulette);
}

INSTANTIATE_TEST_SUITE_P(
    Sampled, GuideTrial,
    testing::Values(Sampling{false, shared::kRouletteBoth}, Sampling{true, shared::kRouletteBoth},
                    Sampling{false, shared::kRouletteAlbedo},
                    Sampling{true, shared::kRouletteAlbedo},
                    Sampling{false, shared::kRouletteLight}, Sampling{true, shared::kRouletteLight},
                    Sampling{false, shared::kRouletteNone}, Sampling{true, shared::kRouletteNone}),
    nameOfSampling);

TEST(GuideTrial, TakesPixelsOfWhichNothingIsKnownAsBrightAsAll)
{
    constexpr size_t kPaths = 20000;
    Recorded paths = sampled({.guided = true}, kPaths);
    const TrialRules rules{kRouletteDepth, shared::kRouletteAlbedo, false, 0.01};
    const auto withImage = [&](float image) {
        for (PathRecords& part : paths.parts)
            for (shared::GuidePathEnd& end : part.ends) end.image = image;
        Trial trial;
        trial.add(paths.parts, paths.lessons, tablesOf(), rules, 0);
        EXPECT_EQ(trial.paths(), kPaths);
        return trial;
    };
    double mean = 0;
    for (const PathRecords& part : paths.parts)
        for (const shared::GuidePathEnd& end : part.ends) mean += double(end.final) / kPaths;
    const Trial known = withImage(float(mean)), unknown = withImage(0);
    EXPECT_NEAR(unknown.gain({}), known.gain({}), 1e-4 * known.gain({}));
    EXPECT_EQ(unknown.plain().arrivals, known.plain().arrivals);

    for (PathRecords& part : paths.parts) {
        for (shared::GuidePathEnd& end : part.ends) end.final = 0;
        for (shared::GuideRecord& r : part.records) r.before = r.after = 0;
    }
    Trial black;
    black.add(paths.parts, paths.lessons, tablesOf(), rules, 0);
    EXPECT_EQ(black.paths(), 0);
    EXPECT_EQ(black.gain({}), 1);
}

}  // namespace

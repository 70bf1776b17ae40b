// What `rekindle bench manylights` is made of, on values that are known: errors, subsets, spreads,
// equal error, the verdicts on claims, and the table of cases.
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "app/bench/many_lights/many_lights_cases.h"
#include "app/bench/many_lights/many_lights_claims.h"
#include "app/bench/many_lights/many_lights_error.h"
#include "app/bench/many_lights/many_lights_scene.h"
#include "app/bench/many_lights/many_lights_subset.h"
#include "app/bench/many_lights/many_lights_thesis.h"
#include "core/base/check.h"
#include "core/gltf/load.h"

namespace app::many_lights {
namespace {

using glm::vec3;

TEST(ManyLightsErrors, HaveTheirKnownValues)
{
    const std::vector<vec3> grey(50, vec3(0.2f));
    EXPECT_EQ(errorsOf(grey, grey, 0).rmse8, 0);
    // One grey level of sRGB, wherever it is, is about 1/255 on the display's scale.
    const auto level = [](int i) {
        const double s = i / 255.0;
        return vec3(float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4)));
    };
    for (const int i : {60, 128, 250}) {
        const LightErrors e = errorsOf(std::vector(9, level(i + 1)), std::vector(9, level(i)), 0);
        EXPECT_NEAR(e.rmse8, 1 / 255.0, 4e-4) << i;
        EXPECT_NEAR(e.rmse, double(level(i + 1).x - level(i).x), 1e-7) << i;
    }
    // Within one level, and above what a display shows, nothing is seen.
    EXPECT_EQ(errorsOf(std::vector(4, vec3(5)), std::vector(4, vec3(7)), 0).rmse8, 0);
    EXPECT_GT(errorsOf(std::vector(4, vec3(5)), std::vector(4, vec3(7)), -4).rmse8, 0.01);
    EXPECT_NEAR(clippedShare(std::vector{vec3(0.5f, 2, 3), vec3(0)}, 0), 2 / 6.0, 1e-12);
    EXPECT_EQ(clippedShare(std::vector{vec3(0.5f, 2, 3), vec3(0)}, -2), 0);
    // Differences in linear radiance, half of the values.
    const std::vector<vec3> a{vec3(1), vec3(3)}, b{vec3(1), vec3(2)};
    EXPECT_NEAR(errorsOf(a, b, 0).rmse, std::sqrt(0.5), 1e-6);
    EXPECT_NEAR(errorsOf(a, b, 0).relMse, 0.5 * 1 / 4.01, 1e-6);
}

TEST(ManyLightsSpread, IsMedianAndExtremes)
{
    const Spread s = spreadOf({3, kUnknown, 1, 2, 10});
    EXPECT_EQ(s.count, 4u);
    EXPECT_EQ(s.low, 1);
    EXPECT_EQ(s.median, 2.5);
    EXPECT_EQ(s.high, 10);
    EXPECT_EQ(spreadOf({}).count, 0u);
    EXPECT_TRUE(std::isnan(spreadOf({kUnknown}).median));
}

/// Slices of `sizes` receivers, four places to a pixel; the last pixel has no receiver.
core::many_lights::FrameReceivers points(const std::vector<uint32_t>& sizes)
{
    core::many_lights::FrameReceivers p;
    uint32_t place = 0;
    for (const uint32_t size : sizes) {
        const uint32_t begin = place;
        for (uint32_t i = 0; i < size; ++i, ++place) {
            p.receivers.emplace_back();
            p.receivers.back().place = place;
            p.slices.order.push_back(place);
        }
        p.slices.ranges.push_back({begin, place});
    }
    p.direct.assign((place + 3) / 4 * 4 + 4, vec3(0));
    return p;
}

TEST(ManyLightsSubset, HoldsWholeSlicesAndTheirPixels)
{
    const auto p = points({10, 6, 8, 12});  // 36 receivers in nine pixels, and one without
    std::set<size_t> seen;
    for (uint32_t seed = 1; seed < 40; ++seed) {
        const Subset s = randomSubset(p, 4, {0.5, 0}, seed);
        EXPECT_EQ(s.slices, 2u);
        EXPECT_EQ(size_t(std::ranges::count(s.places, uint8_t(1))), s.receivers);
        seen.insert(s.receivers);
        const auto marks = slicesOf(p, s);
        EXPECT_EQ(std::ranges::count(marks, uint8_t(1)), 2);
        EXPECT_EQ(randomSubset(p, 4, {0.5, 0}, seed).places, s.places);
    }
    EXPECT_GE(seen.size(), 4u);  // 14, 16, 18, 20, 22 receivers
    EXPECT_EQ(randomSubset(p, 4, {1e-6, 0}, 1).slices, 1u);
    EXPECT_GE(randomSubset(p, 4, {{}, 15}, 1).receivers, 15u);
    const Subset all = randomSubset(p, 4, {1.0, 0}, 1);
    EXPECT_EQ(all.receivers, 36u);
    EXPECT_EQ(all.pixels.size(), 10u);  // that without receivers is part of the whole picture

    // A pixel that lies in two slices has the mean of the receivers that are there.
    Subset first;
    first.perPixel = 4;
    first.places.assign(p.direct.size(), 0);
    std::fill_n(first.places.begin(), 10, uint8_t(1));
    first.pixels = {0, 1, 2};
    std::vector<vec3> radiance(p.direct.size());
    for (size_t i = 0; i < radiance.size(); ++i) radiance[i] = vec3(float(i));
    const std::vector<vec3> values = valuesOf(radiance, first);
    ASSERT_EQ(values.size(), 3u);
    EXPECT_EQ(values[0].x, 1.5f);
    EXPECT_EQ(values[1].x, 5.5f);
    EXPECT_EQ(values[2].x, 8.5f);
    // Slices of twice the size that hold any of its places are lit, too.
    EXPECT_EQ(slicesOf(points({16, 20}), first), (std::vector<uint8_t>{1, 0}));

    const Subset window = subsetAround(p, 4, 5, {2, 0}, {1, 1});  // pixel 2: places 8 to 11
    EXPECT_EQ(window.slices, 2u);
    EXPECT_EQ(window.receivers, 16u);
}

/// The box with few lights.
LitScene litBox()
{
    auto world = core::makeWorld(
        core::loadGltf(std::string(REKINDLE_SOURCE_DIR "/assets/cornell-diffuse.gltf")));
    const core::Camera camera = world->cameras.front();
    core::ManyLightsParams common;
    common.lights = 200;
    common.clusters = 20;
    common.receivers = 4;
    common.sliceSize = 100;
    common.lost = core::LostLight::dropped;
    common.jitter = core::PixelJitter::never;
    return {std::move(world), camera, {24, 18}, common, {}, {}};
}

TEST(ManyLightsScene, APartIsLitAsTheWhole)
{
    LitScene scene = litBox();
    ASSERT_TRUE(scene.findLights());
    const auto slices = scene.points(scene.common().sliceSize);
    const Subset all = randomSubset(*slices, 4, {1.0, 0}, 1),
                 part = randomSubset(*slices, 4, {0.4, 0}, 1);
    ASSERT_LT(part.slices, slices->slices.ranges.size());
    const auto light = [&](const Subset& subset, bool packets) {
        return *scene.light(scene.common(), packets, scene.lights(), subset, 1);
    };
    const Lit whole = light(all, true), some = light(part, true), single = light(part, false);
    EXPECT_EQ(some.stats.rows, part.receivers);
    EXPECT_EQ(some.stats.slices, part.slices);
    size_t compared = 0;
    for (size_t i = 0; i < part.pixels.size(); ++i) {
        EXPECT_EQ(some.values[i], single.values[i]) << part.pixels[i];
        // Pixels at the border of the part have a mean of their own.
        const auto first = part.places.begin() + 4 * part.pixels[i];
        if (std::count(first, first + 4, uint8_t(1)) < 4) continue;
        const auto at = std::ranges::find(all.pixels, part.pixels[i]) - all.pixels.begin();
        EXPECT_EQ(some.values[i], whole.values[size_t(at)]) << part.pixels[i];
        ++compared;
    }
    EXPECT_GT(compared, 20u);
}

TEST(ManyLightsScene, RepetitionsHaveTreesOfTheirOwn)
{
    LitScene scene = litBox();
    ASSERT_TRUE(scene.findLights());
    const auto slices = scene.points(scene.common().sliceSize);
    const Subset all = randomSubset(*slices, 4, {1.0, 0}, 1);
    const auto errorOf = [&](uint32_t repetition, uint32_t clusters) {
        core::ManyLightsParams params = scene.common();
        params.clusters = clusters;
        const auto a = scene.light(params, true, scene.lightsOf(0), all, 1),
                   b = scene.light(params, true, scene.lightsOf(repetition), all, 1);
        return errorsOf(b->values, a->values, 0).rmse;
    };
    EXPECT_EQ(errorOf(0, 20), 0);
    EXPECT_GT(errorOf(1, 20), 1e-4);
    // Of as many clusters as lights the tree is no matter, but for rounding.
    EXPECT_LT(errorOf(1, 100000), 1e-5);
}

TEST(ManyLightsClaims, EqualErrorIsReadAlongThePowerLaw)
{
    const std::vector<Reached> curve{{1, 0.08}, {4, 0.04}, {16, 0.02}, {64, 0.03}};
    EXPECT_NEAR(secondsToReach(curve, 0.04), 4, 1e-12);
    EXPECT_NEAR(secondsToReach(curve, 0.08 / std::sqrt(2)), 2, 1e-9);
    EXPECT_NEAR(secondsToReach(curve, 0.025), 4 * std::pow(4, std::log2(1.6)), 1e-9);
    EXPECT_EQ(secondsToReach(curve, 0.5), 1);
    EXPECT_TRUE(std::isinf(secondsToReach(curve, 0.01)));
    EXPECT_TRUE(std::isinf(secondsToReach({}, 0.01)));
    EXPECT_EQ(secondsToReach({{1, 0.1}, {2, 0}}, 0), 2);
}

TEST(ManyLightsClaims, VerdictsFollowTheNumbers)
{
    const auto finding = [](double low, double median, double high, size_t count = 3) {
        return Finding{"room", "ratio", {median, low, high, count}, 0.9, 1.2};
    };
    const Finding yes = finding(0.95, 1, 1.1), no = finding(1.3, 1.4, 1.5),
                  low = finding(0.1, 0.2, 0.8), maybe = finding(1.1, 1.15, 1.3),
                  once = finding(1, 1, 1, 1);
    EXPECT_EQ(verdictOf(yes), Verdict::reproduced);
    EXPECT_EQ(verdictOf(no), Verdict::refuted);
    EXPECT_EQ(verdictOf(low), Verdict::refuted);
    EXPECT_EQ(verdictOf(maybe), Verdict::undecided);
    EXPECT_EQ(verdictOf(once), Verdict::undecided);
    const auto claim = [](bool most, std::vector<Finding> findings) {
        return verdictOf(Claim{"c", "c", most, std::move(findings)});
    };
    EXPECT_EQ(claim(false, {}), Verdict::undecided);
    EXPECT_EQ(claim(false, {yes, yes}), Verdict::reproduced);
    EXPECT_EQ(claim(false, {yes, yes, no}), Verdict::refuted);
    EXPECT_EQ(claim(false, {yes, maybe}), Verdict::reproduced);
    EXPECT_EQ(claim(false, {yes, maybe, maybe}), Verdict::undecided);
    EXPECT_EQ(claim(true, {yes, yes, no}), Verdict::reproduced);
    EXPECT_EQ(claim(true, {yes, no}), Verdict::refuted);
    EXPECT_EQ(claim(true, {maybe, maybe}), Verdict::undecided);
}

/// A row whose repetitions are made up.
Row row(const std::string& method, uint32_t clusters, std::vector<double> seconds, double rmse,
        double rate = kUnknown)
{
    Row r;
    r.method = method;
    r.clusters = clusters;
    r.rowRate = rate;
    for (const double s : seconds) {
        Sample sample;
        sample.seconds = s;
        sample.rmse8 = rmse;
        sample.authorVisibility = 0.1;
        r.samples.push_back(sample);
    }
    return r;
}

const Claim& named(const std::vector<Claim>& claims, std::string_view name)
{
    return *std::ranges::find(claims, name, &Claim::name);
}

TEST(ManyLightsClaims, ReadTheRowsThatTheySpeakOf)
{
    Results r;
    r.clusters = {1000};
    r.mainClusters = 1000;
    r.quick = true;
    SceneResult scene;
    scene.name = "room";
    scene.rates.ratio = 0.9;
    // Slower machine in the second repetition: ratios stay.
    scene.rows = {row("full", 1000, {4, 8}, 0.01),
                  row("thesis", 1000, {1, 2}, 0.01),
                  row("thesis-full-single", 1000, {10, 20}, 0.01),
                  row("thesis-single", 1000, {2, 4}, 0.01),
                  row("fixed-matching", 1000, {1, 2}, 0.02, 0.1),
                  row("fixed-matching", 1000, {1, 2}, 0.02, 0.2),
                  row("fixed-amc", 1000, {2, 4}, 0.02, 0.1),
                  row("fixed-amc", 1000, {0.5, 1.5}, 0.02, 0.2)};
    r.scenes = {scene};
    std::vector<Claim> claims = claimsOf(r);
    const Claim& saves = named(claims, "BAMC saves time");
    ASSERT_EQ(saves.findings.size(), 2u);
    EXPECT_EQ(saves.findings[1].value.median, 0.2);
    EXPECT_EQ(verdictOf(saves), Verdict::reproduced);
    const Claim& amc = named(claims, "AMC is slower");
    ASSERT_EQ(amc.findings.size(), 2u);
    EXPECT_EQ(amc.findings[0].value.low, 2);
    EXPECT_EQ(amc.findings[0].value.high, 2);
    EXPECT_EQ(verdictOf(amc), Verdict::refuted);
    EXPECT_EQ(verdictOf(named(claims, "AMC falls behind")), Verdict::refuted);
    EXPECT_EQ(verdictOf(named(claims, "Nothing is lost")), Verdict::reproduced);
    EXPECT_TRUE(named(claims, "GE is slower").findings.empty());
    EXPECT_EQ(verdictOf(named(claims, "Goal: lean full sampling")), Verdict::reproduced);
    const Claim& others = named(claims, "Others need more");
    ASSERT_EQ(others.findings.size(), 1u);
    EXPECT_EQ(others.findings[0].value.median, 4);
    r.scenes[0].rows[1] = row("thesis", 1000, {1, 2}, 0.02);
    claims = claimsOf(r);
    EXPECT_EQ(verdictOf(named(claims, "Nothing is lost")), Verdict::refuted);
}

app::ManyLightsBenchOptions options(bool quick)
{
    app::ManyLightsBenchOptions o;
    o.clusters = {250, 1000};
    o.mainClusters = 1000;
    o.errors = {0.02f, 0.1f};
    o.mainError = 0.02f;
    o.quick = quick;
    return o;
}

TEST(ManyLightsCases, AreOneOfEachKind)
{
    for (const bool quick : {false, true}) {
        std::set<std::string> places;
        for (const Case& c : casesOf(options(quick))) {
            std::string place = std::string(c.method->name) + ' ' + std::to_string(c.clusters) +
                                ' ' + std::to_string(c.rowRate);
            if (c.method->sweep == Sweep::errors)
                place += ' ' + std::to_string(c.params.error);
            else
                EXPECT_EQ(c.params.clusters, c.clusters);
            EXPECT_TRUE(places.insert(place).second) << place;
            if (!std::isnan(c.rowRate)) {
                EXPECT_FLOAT_EQ(c.params.completion.rowRate, float(c.rowRate));
                EXPECT_EQ(c.params.completion.verificationRate, 0);
            }
        }
        for (const double rate : fixedRates(quick))
            EXPECT_TRUE(places.contains("fixed-amc 1000 " + std::to_string(rate)));
        EXPECT_TRUE(places.contains("full 250 nan"));
        EXPECT_TRUE(places.contains("lightslice 1000 nan"));
        EXPECT_TRUE(places.contains("lightcuts 1000 nan 0.020000"));
        EXPECT_TRUE(places.contains("illumination-cut 0 nan 0.100000"));
        EXPECT_TRUE(places.contains("high-matching 1000 0.400000"));
    }
    app::ManyLightsBenchOptions o = options(true);
    o.methods = {"matching"};
    for (const Case& c : casesOf(o))
        EXPECT_TRUE(std::string(c.method->name) == "full" ||
                    std::string(c.method->name) == "matching");
    EXPECT_NO_THROW(requireMethods({"full", "matching-whole"}));
    try {
        requireMethods({"fool"});
        FAIL();
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find("did you mean full?"), std::string::npos);
    }
}

TEST(ManyLightsThesis, ScenesAreFoundByTheirFiles)
{
    EXPECT_STREQ(thesisScene("cornell-diffuse")->name, "Cornell");
    EXPECT_STREQ(thesisScene("staircase-diffuse")->name, "Staircase");
    EXPECT_EQ(thesisScene("glass"), nullptr);
    EXPECT_TRUE(std::isnan(thesisScene("kitchen")->matSep));
    for (const ThesisRates& rates : thesisRates())
        for (size_t i = 1; i < rates.amc.size(); ++i) EXPECT_GT(rates.amc[i], rates.amc[i - 1]);
}

}  // namespace
}  // namespace app::many_lights

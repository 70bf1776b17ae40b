// `rekindle bench guiding`: the table of variants, ratios, goals, bias and references on values
// that are known; then as a person or a script meets it: what it refuses, what it writes, what it
// keeps.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <random>
#include <set>

#include "app/bench/bench_scenes.h"
#include "app/bench/guiding/guiding_cases.h"
#include "app/bench/guiding/guiding_claims.h"
#include "app/bench/guiding/guiding_files.h"
#include "app/bench/guiding/guiding_goals.h"
#include "app/bench/guiding/guiding_measure.h"
#include "app/bench/guiding/guiding_page.h"
#include "app/bench/kept_reference.h"
#include "app/files/params_json.h"
#include "core/base/check.h"
#include "tests/support/files/markup.h"
#include "tests/support/process/program.h"

namespace app::guiding {
namespace {

using namespace tests;

TEST(GuidingVariants, ChangeOneThingEach)
{
    const core::GuidedParams common{.training = 24, .maxDepth = 5, .rouletteDepth = 3};
    std::set<std::string> names;
    for (const Variant& variant : variantTable()) {
        EXPECT_TRUE(names.insert(variant.name).second) << variant.name;
        EXPECT_FALSE(std::string(variant.help).empty());
        const core::AnyParams params = paramsOf(variant, common, 7, 64);
        if (variant.change == nullptr) {
            const auto& path = params.as<core::PathParams>();
            EXPECT_EQ(path.maxDepth, 5u);
            EXPECT_EQ(path.rouletteDepth, 3u);
            EXPECT_EQ(path.seed, 7u);
            continue;
        }
        const auto& guided = params.as<core::GuidedParams>();
        const bool halves = guided.schedule == core::GuideSchedule::doubling;
        EXPECT_EQ(guided.training, halves ? 32u : 24u) << variant.name;
        EXPECT_EQ(guided.seed, 7u);
        EXPECT_EQ(guided.maxDepth, 5u);
        core::GuidedParams same = guided;
        same.seed = common.seed;
        EXPECT_EQ(same == common, std::string(variant.name) == "guided") << variant.name;
    }
    app::GuidingBenchOptions options;
    const auto isSwitch = [](const Variant& v) { return v.family == Family::switches; };
    EXPECT_EQ(variantsOf(options).size(), size_t(std::ranges::count_if(variantTable(), isSwitch)));
    options.quick = true;
    EXPECT_EQ(variantsOf(options).size(), 2u);
    options.variants = {"no-gate"};
    ASSERT_EQ(variantsOf(options).size(), 2u);
    EXPECT_EQ(variantsOf(options)[0]->name, std::string("path"));
    EXPECT_EQ(variantsOf(options)[1]->name, std::string("no-gate"));
    options.variants = {"combinations"};
    EXPECT_EQ(variantsOf(options).size(), 11u);
    EXPECT_THROW(requireVariants({"no-gat"}), core::Error);
    requireVariants({"path", "guided", "papers"});
}

/// A ratio is fair when what both methods have is the same in both, whatever parameters these are.
TEST(GuidingVariants, HaveWhatThePathTracerHas)
{
    const core::PathParams path;
    core::GuidedParams common;
    std::set<std::string> shared;
    core::PathParams::visit(path, [&](const core::Field& field, const auto& value) {
        using Member = std::remove_cvref_t<decltype(value)>;
        if (auto* member = core::findParam<Member>(common, field.name)) {
            shared.insert(field.name);
            *member = Member(uint32_t(*member) + 1);  // not the default
        }
    });
    EXPECT_TRUE(shared.contains("max-depth") && shared.contains("sky"));
    const auto expected = app::paramsJson(common);
    for (const Variant& variant : variantTable()) {
        const auto params = app::paramsJson(paramsOf(variant, common, common.seed, 64));
        for (const std::string& name : shared)
            EXPECT_EQ(params.at(name), expected.at(name)) << variant.name << ' ' << name;
    }
}

TEST(SceneNames, AreThoseOfFilesAndFoldersAndDiffer)
{
    EXPECT_EQ(sceneName("scenes/room.glb", {}), "room");
    EXPECT_EQ(sceneName("scenes/room/", {}), "room");
    EXPECT_EQ(sceneName("room//", {"room"}), "room-2");
}

TEST(GuidingSize, FollowsTheCamera)
{
    core::Camera camera;
    camera.aspect = 1;
    EXPECT_EQ(usualSize(camera), glm::uvec2(256, 256));
    camera.aspect = 16.0 / 9;
    EXPECT_EQ(usualSize(camera), glm::uvec2(192, 108));
    camera.aspect = 9.0 / 16;
    EXPECT_EQ(usualSize(camera), glm::uvec2(108, 192));
}

/// A row whose picture of each seed takes `seconds` and has one of the `errors`.
Row rowOf(const std::string& variant, uint32_t spp, double seconds, std::vector<double> errors)
{
    Row row;
    row.variant = variant;
    row.device = "cpu";
    row.spp = spp;
    double sum = 0;
    for (const double e : errors) {
        row.samples.push_back({.cpuSeconds = seconds, .renderSeconds = 1, .rays = 9, .relMse = e});
        sum += e;
    }
    row.relMse = {sum / double(errors.size()), 0.1};
    row.mean = 0.5;
    return row;
}

Results resultsOf(const std::string& scene, double gain)
{
    Results r;
    r.version = "1";
    r.machine = "<machine>";
    r.devices = {{"cpu", "a & b", true}};
    r.samples = r.sweep = {16, 64};
    r.seeds = 2;
    SceneResult s;
    s.name = scene;
    s.size = {8, 8};
    for (const uint32_t spp : r.samples) {
        s.rows.push_back(rowOf("path", spp, 2, {4 * gain, 8 * gain}));
        s.rows.push_back(rowOf("guided", spp, 4, {2, 4}));
        s.rows.back().difference = {0.05, 0.01};
        s.rows.back().mean = 0.55;
    }
    r.scenes.push_back(s);
    return r;
}

TEST(GuidingRatios, AreOfTheMeansAndSpanTheSeeds)
{
    const Row plain = rowOf("path", 64, 2, {6, 10}), guided = rowOf("guided", 64, 5, {3, 1});
    const Ratio variance = varianceRatio(plain, guided);
    EXPECT_NEAR(variance.value, 4, 1e-12);
    EXPECT_NEAR(variance.low, 2, 1e-12);
    EXPECT_NEAR(variance.high, 10, 1e-12);
    EXPECT_NEAR(efficiency({"cpu", "", true}, plain, guided).value, 1.6, 1e-12);
    // By the device's own clock both take one second.
    EXPECT_NEAR(efficiency({"vulkan", "", false}, plain, guided).value, 4, 1e-12);
    EXPECT_NEAR(varianceRatio(plain, plain).value, 1, 1e-12);
    const Results r = resultsOf("x", 4);
    EXPECT_NEAR(biasScore(r.scenes[0].rows[1]), 5, 1e-9);
    EXPECT_NEAR(relativeBias(r.scenes[0].rows[1]), 0.1, 1e-9);
}

TEST(GuidingGoals, AreMetMissedOrNotMeasured)
{
    const auto verdict = [](const Results& r, const std::string& goal) {
        for (const Goal& g : goalsOf(r))
            if (g.text == goal) return std::string(verdictName(g.verdict));
        return std::string("none");
    };
    const std::string box = "cbox-up on cpu, 64 spp", all = "every scene on every device, 16 spp";
    EXPECT_EQ(verdict(resultsOf("cbox-up", 2.7), box), "met");
    EXPECT_EQ(verdict(resultsOf("cbox-up", 2.5), box), "missed");
    EXPECT_EQ(verdict(resultsOf("other", 2.5), box), "not measured");
    EXPECT_EQ(verdict(resultsOf("other", 0.96), all), "met");
    EXPECT_EQ(verdict(resultsOf("other", 0.94), all), "missed");
    EXPECT_EQ(verdict(resultsOf("cbox-up", 9), "cbox-up on vulkan, 64 spp"), "not measured");
    // The worst scene decides.
    Results two = resultsOf("good", 3);
    two.scenes.push_back(resultsOf("bad", 0.5).scenes[0]);
    EXPECT_EQ(verdict(two, all), "missed");
    EXPECT_EQ(goalsOf(two).back().where, "bad, cpu");

    // After a move errors alone count: of the means over the seeds.
    const std::string first =
        "every scene on every device, the first sample after 25 degrees, less variance";
    EXPECT_EQ(verdict(two, first), "not measured");
    two.scenes[0].arrivals = {{"cpu", 25, 64, {8, 6}, {1, 1}}};
    EXPECT_EQ(verdict(two, first), "met");
    two.scenes[1].arrivals = {{"cpu", 25, 64, {2, 5}, {1, 1.1}}};
    EXPECT_EQ(verdict(two, first), "missed");
    two.scenes[1].arrivals.push_back({"cpu", 25, 64, {3, 3}, {1, 1}, true});
    EXPECT_EQ(goalsOf(two).front().where, "bad, cpu, in the window");
    two.scenes[1].arrivals.pop_back();
    EXPECT_NEAR(varianceRatio(two.scenes[1].arrivals[0]).value, 3.5 / 1.05, 1e-12);
    // What was measured over a smaller angle decides nothing.
    two.scenes[1].arrivals = {{"cpu", 6.25, 64, {2, 5}, {1, 1.1}},
                              {"vulkan", 6.25, 64, {2, 5}, {1, 1}}};
    EXPECT_EQ(verdict(two, first + "; undecided: bad (6.25 degrees)"), "met");
    two.scenes[0].arrivals.clear();
    EXPECT_EQ(verdict(two, first + "; undecided: bad (6.25 degrees)"), "not measured");
    two.scenes[0].arrivals = {{"cpu", 25, 64, {8, 6}, {1, 1}}};

    EXPECT_TRUE(
        arrivalText(two.scenes[0].arrivals[0])
            .starts_with("first sample after 25 degrees, cpu: 7.00 (6.00–8.00) times less"));
}

/// The errors that JSON has of arrivals are those whose ratio it has.
TEST(GuidingJson, ErrorsOfArrivalsAreMeans)
{
    Results r = resultsOf("x", 4);
    r.scenes[0].arrivals = {{"cpu", 25, 64, {1, 2, 9}, {1, 1, 4}}};
    const Json arrival = Json::parse(resultsJson(r)).at("scenes")[0].at("arrivals")[0];
    EXPECT_EQ(arrival.at("relmse_path"), 4);
    EXPECT_EQ(arrival.at("relmse_guided"), 2);
    EXPECT_EQ(arrival.at("variance_ratio"), 2);
    EXPECT_EQ(arrival.at("relmse_path_median"), 2);
    EXPECT_EQ(arrival.at("relmse_guided_median"), 1);
}

TEST(GuidingPage, ShowsAnyNumbers)
{
    for (const double odd : {kUnknown, double(INFINITY), 0.0, -1.0, 1e300}) {
        Results r = resultsOf("a<b", odd);
        r.interrupted = r.quick = true;
        r.scenes[0].rows[3].samples[0].leaves = odd;
        r.scenes[0].rows[3].relMse = {odd, odd};
        r.scenes[0].shots = {{"guided", odd, odd, "none.png"}};
        const std::string page = resultsPage(r, "/nowhere");
        EXPECT_EQ(readMarkup(page).problem, "") << odd;
        EXPECT_FALSE(contains(withoutPictures(page), "nan"));
        EXPECT_TRUE(contains(page, "Interrupted"));
        EXPECT_EQ(Json::parse(resultsJson(r)).at("rows").size(), 4u);
        EXPECT_TRUE(contains(resultsTable(r), "a<b"));
    }
}

/// Rows of two families with errors that are known: what is said of them follows.
TEST(GuidingClaims, FollowFromTheRows)
{
    const auto saying = [](std::vector<std::pair<std::string, double>> errors) {
        Results r = resultsOf("x", 4);
        r.samples = r.sweep = {64};
        std::vector<Row>& rows = r.scenes[0].rows;
        for (const auto& [name, error] : errors) rows.push_back(rowOf(name, 64, 2, {error}));
        std::string all;
        for (const Claim& claim : claimsOf(r, r.scenes[0])) all += claim.sentence;
        EXPECT_TRUE(contains(resultsJson(r), all.substr(0, 20)));
        return all;
    };
    const auto training = [&](double balance, double residual) {
        return saying({{"memory-reset", 2},
                       {"memory-keep", 1.9},
                       {"memory-balance", balance},
                       {"memory-residual", residual}});
    };
    EXPECT_TRUE(contains(training(1.5, 3), "It pays."));
    EXPECT_TRUE(contains(training(2.5, 2.2), "It does not pay."));
    EXPECT_TRUE(contains(training(1.88, 3), "It makes no difference."));
    EXPECT_TRUE(contains(training(1.5, 3), "−25 % (balance heuristic) and +50 % (residual)"));
    const std::string best = saying({{"combine-samples", 2},
                                     {"combine-last", 4},
                                     {"combine-variance", 1},
                                     {"combine-ess", 1.5}});
    EXPECT_TRUE(contains(best, "The least variance: combine-variance"));
    EXPECT_TRUE(contains(best, "−50 % against weights by samples and −75 %"));
    EXPECT_TRUE(contains(best, "(combine-ess) has +50 %"));
    const std::string inverse = saying({{"combine-samples", 2},
                                        {"combine-last", 4},
                                        {"combine-variance", 1},
                                        {"combine-mean-inverse", 0.75},
                                        {"combine-ess", 1.5}});
    EXPECT_TRUE(contains(inverse, "(combine-ess) has +100 % variance against the best of inverse "
                                  "variance (combine-mean-inverse)"));
    EXPECT_EQ(saying({{"combine-ess", 2}}), "");
    EXPECT_TRUE(contains(saying({{"depth-3", 2}, {"depth-3-balance", 1}, {"depth-6", 1}}),
                         "depth-6 has the least variance. Old records pay at 1 of 1 depths."));
}

/// Pictures that share most of their noise: the mean of their differences is known far better than
/// either mean, and a bias of a thousandth is seen.
TEST(GuidingBias, IsSeenBetweenPairsOfPictures)
{
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    double squares = 0, biased = 0;
    constexpr int kTrials = 300;
    for (int t = 0; t < kTrials; ++t) {
        TileSums fair, wrong;
        for (int seed = 0; seed < 3; ++seed) {
            core::Image a(32, 24, 3), b(32, 24, 3), c(32, 24, 3);
            for (size_t i = 0; i < a.pixels.size(); ++i) {
                const float shared = 1 + normal(random);
                a.pixels[i] = shared;
                b.pixels[i] = shared + 0.02f * normal(random);
                c.pixels[i] = b.pixels[i] + 0.01f;
            }
            fair.add(app::tileDifferences(b, a));
            wrong.add(app::tileDifferences(c, a));
        }
        squares += std::pow(fair.mean().value / fair.mean().error, 2) / kTrials;
        biased += wrong.mean().value / wrong.mean().error / kTrials;
        EXPECT_NEAR(wrong.mean().value, 0.01, 0.002);
    }
    EXPECT_NEAR(squares, 1, 0.3);
    EXPECT_GT(biased, 20);
}

TEST(GuidingReferences, AreBlurredWithinTheirBorders)
{
    core::Image image(3, 2, 3);
    image.at(0, 0)[1] = 12;
    const core::Image result = blurred(image);
    EXPECT_FLOAT_EQ(result.at(0, 0)[1], 3);
    EXPECT_FLOAT_EQ(result.at(1, 1)[1], 2);
    EXPECT_FLOAT_EQ(result.at(2, 0)[1], 0);
    EXPECT_FLOAT_EQ(result.at(0, 0)[0], 0);
}

/// What another commit has rendered is not what this one would.
TEST(KeptReferences, AreOfOneProgram)
{
    const nlohmann::ordered_json shown{{"scene", "x"}};
    const ReferenceMaker here = thisProgram();
    EXPECT_EQ(referenceKey(shown), referenceKey(shown, {here.version, here.commit}));
    EXPECT_NE(referenceKey(shown), referenceKey(shown, {here.version, here.commit + "0"}));
    EXPECT_NE(referenceKey(shown), referenceKey(shown, {here.version + "0", here.commit}));
    EXPECT_NE(referenceKey(shown), referenceKey({{"scene", "y"}}));
}

const Strings kBench{"bench", "guiding"};

/// Small enough for a test.
const Strings kTiny{"--size", "24x16",           "--samples", "2,4",      "--seeds",
                    "2",      "--reference-spp", "32",        "--device", "cpu"};

class GuidingCommand : public Cli {
protected:
    Json results(const std::string& folder) const
    {
        return Json::parse(readAll(work(folder + "/guiding.json")));
    }
};

TEST_F(GuidingCommand, NonsenseIsRefused)
{
    expectRefused(kBench, 2, "scene is missing");
    expectRefused(kBench + Strings{kScene}, 2, "-o DIR");
    const Strings bench = kBench + Strings{kScene, "-o", "x"};
    expectRefused(bench + Strings{"--samples", "16,many"}, 2, "'many'");
    expectRefused(bench + Strings{"--samples", ","}, 2, "empty");
    expectRefused(bench + Strings{"--seeds", "0"}, 2, "--seeds");
    expectRefused(bench + Strings{"--device", "gpu"}, 2, "both, cpu, vulkan");
    expectRefused(bench + Strings{"--device", "cpu", "--device-index", "0"}, 2, "--device-index");
    expectRefused(bench + Strings{"--variants", "no-gat"}, 2, "did you mean no-gate?");
    expectRefused(bench + Strings{"--training", "9999"}, 2, "--training");
    expectRefused(bench + Strings{"--sampels", "9"}, 2, "did you mean --samples?");
    expectRefused(kBench + Strings{kScene, "none.gltf", "-o", "x"}, 3, "none.gltf");
    expectRefused(bench + kTiny + Strings{"--camera", "nobody"}, 2, "nobody");
    EXPECT_FALSE(fs::exists(work("x")));
    writeFile("file", "mine");
    expectRefused(kBench + Strings{kScene, "-o", "file"}, 3, "file: is a file");
}

TEST_F(GuidingCommand, WritesAPageAndItsNumbers)
{
    const Result result = finish(start(kBench + kTiny + Strings{kScene, "-o", "new/guiding"}), 180);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "new/guiding/guiding.html"));
    const Json json = results("new/guiding");
    EXPECT_EQ(json.at("command"), "bench guiding");
    EXPECT_EQ(json.at("interrupted"), false);
    EXPECT_EQ(json.at("devices").size(), 1u);
    EXPECT_EQ(json.at("rows").size(), 2 * variantsOf({}).size());
    for (const Json& row : json.at("rows")) {
        for (const char* key : {"spp", "cpu_seconds", "render_seconds", "rays", "relmse",
                                "variance_ratio", "variance_ratio_low", "eff", "eff_high"}) {
            ASSERT_TRUE(row.at(key).is_number()) << key << ": " << row.dump();
            EXPECT_GT(row.at(key).get<double>(), 0) << key << ": " << row.dump();
        }
        EXPECT_EQ(row.at("scene"), "cornell-diffuse");
        EXPECT_EQ(row.at("seeds"), 2);
        const bool isPlain = row.at("variant") == "path";
        for (const char* key : {"guided_share", "guide_leaves", "guide_bytes", "guide_seconds"})
            EXPECT_EQ(row.at(key).is_null(), isPlain) << key;
        if (isPlain) {
            EXPECT_EQ(row.at("eff"), 1);
            EXPECT_EQ(row.at("variance_ratio"), 1);
        }
    }
    EXPECT_EQ(json.at("goals").back().at("verdict"), "not measured");
    const Json& arrivals = json.at("scenes")[0].at("arrivals");
    ASSERT_EQ(arrivals.size(), 1u);
    EXPECT_EQ(arrivals[0].at("degrees"), 25);
    EXPECT_GT(arrivals[0].at("relmse_path").get<double>(), 0);
    EXPECT_GT(arrivals[0].at("variance_ratio").get<double>(), 0);
    EXPECT_TRUE(contains(result.out, "first sample after 25 degrees, cpu"));

    const std::string page = readAll(work("new/guiding/guiding.html")),
                      csv = readAll(work("new/guiding/guiding.csv"));
    EXPECT_EQ(readMarkup(page).problem, "");
    EXPECT_FALSE(contains(page, "http://") || contains(page, "https://"));
    EXPECT_FALSE(contains(withoutPictures(page), "nan"));
    EXPECT_TRUE(csv.starts_with("scene,variant,device,spp,"));
    EXPECT_EQ(size_t(std::ranges::count(csv, '\n')), 1 + json.at("rows").size());
    const Json& pictures = json.at("scenes")[0].at("pictures");
    ASSERT_EQ(pictures.size(), 3u);
    for (const Json& picture : pictures)
        EXPECT_TRUE(fs::exists(work("new/guiding/" + picture.at("file").get<std::string>())));
    EXPECT_TRUE(contains(result.out, "cornell-diffuse, 24x16"));
}

TEST_F(GuidingCommand, ArrivesInTheWindowsLoop)
{
    const Result result = finish(
        start(kBench + kTiny + Strings{kScene, "-o", "window", "--window", "--variants", "guided"}),
        180);
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = results("window");
    const Json& arrivals = json.at("scenes")[0].at("arrivals");
    ASSERT_EQ(arrivals.size(), 2u);
    EXPECT_EQ(arrivals[0].at("window"), false);
    EXPECT_EQ(arrivals[1].at("window"), true);
    EXPECT_EQ(arrivals[1].at("device"), arrivals[0].at("device"));
    EXPECT_GT(arrivals[1].at("relmse_path").get<double>(), 0);
    EXPECT_GT(arrivals[1].at("variance_ratio").get<double>(), 0);
    EXPECT_TRUE(contains(result.out, "first sample after 25 degrees, cpu, in the window: "));
    const std::string page = readAll(work("window/guiding.html"));
    EXPECT_TRUE(contains(page, "orbits for a second and rests again"));
    EXPECT_EQ(readMarkup(page).problem, "");
}

TEST_F(GuidingCommand, ReferencesAreMadeOnceAndErrorsRepeat)
{
    const Strings bench = kBench + kTiny + Strings{kScene, "-o", "x", "--quick", "-q"};
    const auto scene = [&](const Strings& more) {
        const Result result = run(bench + more);
        EXPECT_EQ(result.code, 0) << result.err;
        return results("x");
    };
    const Json first = scene({}), again = scene({});
    EXPECT_EQ(first.at("scenes")[0].at("reference_kept"), false);
    EXPECT_EQ(again.at("scenes")[0].at("reference_kept"), true);
    ASSERT_EQ(first.at("rows").size(), 4u);
    for (size_t i = 0; i < 4; ++i)
        for (const char* key : {"relmse", "rays", "mean_ratio"})
            EXPECT_EQ(first.at("rows")[i].at(key), again.at("rows")[i].at(key)) << i << key;
    // Without learning a guided picture is the plain one to the bit.
    const Json untrained = scene({"--training", "0"});
    EXPECT_EQ(untrained.at("scenes")[0].at("reference_kept"), true);
    for (const Json& row : untrained.at("rows")) EXPECT_EQ(row.at("variance_ratio"), 1);
    EXPECT_EQ(scene({"--max-depth", "2"}).at("scenes")[0].at("reference_kept"), false);
}

/// What is measured may be biased, and the reference is kept for runs that are not.
TEST_F(GuidingCommand, ReferencesDoNotDependOnWhatIsMeasured)
{
    const std::string file = "cornell-diffuse-24x16-32spp.exr";
    const auto reference = [&](const std::string& folder, const Strings& more) {
        const Result result =
            run(kBench + kTiny + Strings{kScene, "-o", folder, "--quick", "-q"} + more);
        EXPECT_EQ(result.code, 0) << result.err;
        return exr(folder + "/references/" + file);
    };
    const core::ImageFile usual = reference("a", {}),
                          biased =
                              reference("b", {"--combine", "inverse-variance", "--combine-over",
                                              "pixel", "--sampler", "independent"});
    for (const char* layer : {"", "variance"})
        EXPECT_EQ(biased.layer(layer).pixels, usual.layer(layer).pixels) << layer;
    EXPECT_TRUE(contains(usual.metadata.at("rekindle:reference"), thisProgram().commit));
}

TEST_F(GuidingCommand, CtrlCKeepsWhatIsThere)
{
    const Strings bench = kBench + kTiny + Strings{kScene, "-o", "new/guiding", "--quick"};
    pid_t pid = start(bench + Strings{"--reference-spp", "10000000"});
    waitForError("reference");
    kill(pid, SIGINT);
    Result result = finish(pid, 60);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "nothing measured"));
    EXPECT_FALSE(fs::exists(work("new")));

    // So many seeds that only a signal ends them.
    pid = start(bench + Strings{"--seeds", "1000", "--size", "96x64"});
    waitForError("seed 2");  // or any from 20 to 29
    kill(pid, SIGINT);
    result = finish(pid, 60);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "what was measured so far is written"));
    const Json json = results("new/guiding");
    EXPECT_EQ(json.at("interrupted"), true);
    ASSERT_FALSE(json.at("rows").empty());
    EXPECT_GE(json.at("rows")[0].at("seeds"), 1);
    EXPECT_TRUE(contains(readAll(work("new/guiding/guiding.html")), "Interrupted"));
}

}  // namespace
}  // namespace app::guiding

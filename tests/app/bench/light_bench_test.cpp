// T30: `rekindle bench light`: errors of pairs against what is known of them, ratios, the table of
// strategies; then as a person or a script meets it: what it refuses, what it writes, what it
// keeps.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <random>
#include <set>

#include "app/bench/light/light_cases.h"
#include "app/bench/light/light_files.h"
#include "app/bench/light/light_page.h"
#include "app/bench/pair_error.h"
#include "core/base/check.h"
#include "tests/support/files/markup.h"
#include "tests/support/process/program.h"
#include "tests/support/scenes/test_scenes.h"

namespace app::light {
namespace {

using namespace tests;

core::Image constantImage(float value)
{
    core::Image image(64, 48, 3);
    std::ranges::fill(image.pixels, value);
    return image;
}

/// Half of the squared difference is the variance of one picture, relative to the level.
TEST(PairErrors, AreTheVarianceOfOnePicture)
{
    const core::Image level = constantImage(2);
    std::mt19937 random(5);
    std::normal_distribution<float> normal(2, 0.3f);
    double sum = 0, trimmed = 0;
    constexpr int kTrials = 40;
    for (int t = 0; t < kTrials; ++t) {
        core::Image a = level, b = level;
        for (float& x : a.pixels) x = normal(random);
        for (float& x : b.pixels) x = normal(random);
        const PairError e = pairError(a, b, level);
        EXPECT_LT(e.trimmed, e.all);
        EXPECT_GT(e.trimmed, 0.9 * e.all);  // no pixel stands out
        sum += e.all / kTrials;
        trimmed += e.trimmed / kTrials;
    }
    // 40 x 9216 values: a relative deviation of 0.0023
    EXPECT_NEAR(sum, 0.09 / 4.01, 5 * 0.0023 * 0.09 / 4.01);
    EXPECT_LT(trimmed, sum);
}

/// One pixel of a hundred differs: it is all of the error, and none of it without the hundredth.
TEST(PairErrors, TrimmedHasNoFireflies)
{
    const core::Image level = constantImage(1), a = level;
    core::Image b = level;
    for (uint32_t i = 0; i < 64 * 48 / 100; ++i) b.pixels[3 * (100 * i) + 1] = 101;
    const PairError e = pairError(a, b, level);
    EXPECT_NEAR(e.all, (64 * 48 / 100) * 5000 / 1.01 / (64 * 48 * 3), 1e-9 * e.all);
    EXPECT_EQ(e.trimmed, 0);
    EXPECT_EQ(pairError(b, b, level).all, 0);
}

TEST(LightStrategies, AreThoseThatTheSceneHas)
{
    std::set<std::string> names;
    const core::PathParams common{
        .maxDepth = 5, .rouletteDepth = 3, .seed = 7, .sky = core::SkySampling::regions};
    for (const Strategy& s : strategyTable()) {
        EXPECT_TRUE(names.insert(s.name).second) << s.name;
        EXPECT_FALSE(std::string(s.help).empty());
        const core::AnyParams params = s.params(common);
        if (std::string(s.name) == "guided") {
            EXPECT_EQ(params.as<core::GuidedParams>().maxDepth, 5u);
            EXPECT_EQ(params.as<core::GuidedParams>().seed, 7u);
            EXPECT_EQ(params.as<core::GuidedParams>().sky, core::SkySampling::regions);
            continue;
        }
        EXPECT_EQ(params.as<core::PathParams>().maxDepth, 5u);
        EXPECT_EQ(params.as<core::PathParams>().rouletteDepth, 3u);
        EXPECT_EQ(params.as<core::PathParams>().seed, 7u);
        EXPECT_EQ(params.as<core::PathParams>().sky, core::SkySampling::regions);
    }
    core::World few, many;
    many.emitterTree = std::vector<glm::uvec4>(20);
    app::LightBenchOptions options;
    const auto list = [&](const core::World& world) {
        std::string text;
        for (const Strategy* s : strategiesOf(options, world)) text += std::string(s->name) + ' ';
        return text;
    };
    EXPECT_EQ(list(few), "power guided ");
    EXPECT_EQ(list(many), "power tree guided ");
    options.quick = true;
    EXPECT_EQ(list(few), "power ");
    EXPECT_EQ(list(many), "power tree ");
    options.strategies = {"light", "tree"};
    EXPECT_EQ(list(few), "power light ");
    EXPECT_EQ(list(many), "power tree light ");
    EXPECT_THROW(requireStrategies({"tre"}), core::Error);
    requireStrategies({"power", "bsdf"});
}

/// `power` and `tree` are measured in the same scene, whichever it would choose.
TEST(LightStrategies, DifferInTheChoiceAlone)
{
    SceneBuilder b;
    const int lamp = b.material(emitter(glm::vec3(1)));
    for (int i = 0; i < 6; ++i)
        b.quad({static_cast<float>(i), 3, 0}, {0.5f, 0, 0}, {0, 0, 0.5f}, lamp);
    const auto world = b.world();
    for (const Strategy& s : strategyTable()) {
        const auto used = worldOf(s, world);
        EXPECT_TRUE(used->emitters.sharesWith(world->emitters));
        const std::string name = s.name;
        EXPECT_EQ(used->treeEmitters, name == "power"  ? 0u
                                      : name == "tree" ? 12u
                                                       : world->treeEmitters);
    }
}

/// A row whose pairs take `seconds` and have these `errors`, half of which is left when trimmed.
Row rowOf(const std::string& strategy, double seconds, std::vector<double> errors)
{
    Row row;
    row.strategy = strategy;
    row.device = "cpu";
    row.spp = 16;
    for (const double e : errors)
        row.samples.push_back(
            {.cpuSeconds = seconds, .renderSeconds = 1, .rays = 10, .relMse = e, .trimmed = e / 2});
    row.mean = 1.1;
    if (strategy != "power") row.difference = {0.1, 0.02};
    return row;
}

Results resultsOf(const std::string& scene, double gain)
{
    Results r;
    r.devices = {{"cpu", "Embree", true}};
    r.samples = {16};
    r.pairs = 2;
    SceneResult s;
    s.name = scene;
    s.emitters = 12;
    s.hasTree = s.choosesByTree = true;
    s.rows = {rowOf("power", 2, {6, 10}), rowOf("tree", 4, {3 / gain, 1 / gain})};
    r.scenes.push_back(s);
    return r;
}

TEST(LightRatios, AreErrorTimesSeconds)
{
    const Results r = resultsOf("x", 1);
    const Row &plain = r.scenes[0].rows[0], &tree = r.scenes[0].rows[1];
    EXPECT_EQ(plainOf(r.scenes[0], tree), &plain);
    EXPECT_NEAR(errorRatio(plain, tree, &Sample::relMse).value, 4, 1e-12);
    EXPECT_NEAR(timeRatio(r.devices[0], plain, tree).value, 2, 1e-12);
    const app::Ratio gain = efficiency(r.devices[0], plain, tree, &Sample::trimmed);
    EXPECT_NEAR(gain.value, 2, 1e-12);
    EXPECT_NEAR(gain.low, 1, 1e-12);
    EXPECT_NEAR(gain.high, 5, 1e-12);
    // By the device's own clock both take one second.
    EXPECT_NEAR(efficiency({"vulkan", "", false}, plain, tree, &Sample::relMse).value, 4, 1e-12);
    EXPECT_NEAR(biasScore(tree), 5, 1e-9);
    EXPECT_NEAR(relativeBias(tree), 0.1, 1e-9);
}

TEST(LightPage, ShowsAnyNumbers)
{
    for (const double odd : {kUnknown, double(INFINITY), 0.0, -1.0, 1e300}) {
        Results r = resultsOf("a<b", odd);
        r.interrupted = r.quick = true;
        r.scenes[0].rows[1].samples[0].rays = odd;
        r.scenes[0].rows[1].difference = {odd, odd};
        const std::string page = resultsPage(r);
        EXPECT_EQ(readMarkup(page).problem, "") << odd;
        EXPECT_FALSE(contains(withoutPictures(page), "nan"));
        EXPECT_TRUE(contains(page, "Interrupted"));
        EXPECT_EQ(Json::parse(resultsJson(r)).at("rows").size(), 2u);
        EXPECT_TRUE(contains(resultsTable(r), "a<b"));
    }
}

const Strings kBench{"bench", "light"};
const std::string kHall = (kAssets / "hall.gltf").string();  // a thousand lamps

/// Small enough for a test.
const Strings kTiny{"--size", "24x16", "--samples", "2,4", "--pairs", "2", "--device", "cpu"};

class LightCommand : public Cli {
protected:
    Json results(const std::string& folder) const
    {
        return Json::parse(readAll(work(folder + "/light.json")));
    }
};

TEST_F(LightCommand, NonsenseIsRefused)
{
    expectRefused(kBench, 2, "scene is missing");
    expectRefused(kBench + Strings{kScene}, 2, "-o DIR");
    const Strings bench = kBench + Strings{kScene, "-o", "x"};
    expectRefused(bench + Strings{"--samples", "16,many"}, 2, "'many'");
    expectRefused(bench + Strings{"--samples", ","}, 2, "empty");
    expectRefused(bench + Strings{"--pairs", "0"}, 2, "--pairs");
    expectRefused(bench + Strings{"--device", "gpu"}, 2, "both, cpu, vulkan");
    expectRefused(bench + Strings{"--device", "cpu", "--device-index", "0"}, 2, "--device-index");
    expectRefused(bench + Strings{"--strategies", "guidde"}, 2, "did you mean guided?");
    expectRefused(bench + Strings{"--strategy", "bsdf"}, 2, "did you mean --strategies?");
    expectRefused(bench + Strings{"--max-depth", "9999"}, 2, "--max-depth");
    expectRefused(kBench + Strings{kScene, "none.gltf", "-o", "x"}, 3, "none.gltf");
    expectRefused(bench + kTiny + Strings{"--camera", "nobody"}, 2, "nobody");
    EXPECT_FALSE(fs::exists(work("x")));
    writeFile("file", "mine");
    expectRefused(kBench + Strings{kScene, "-o", "file"}, 3, "file: is a file");
}

TEST_F(LightCommand, WritesAPageAndItsNumbers)
{
    const Result result =
        finish(start(kBench + kTiny + Strings{kScene, kHall, "-o", "new/light"}), 180);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_TRUE(contains(result.err, "new/light/light.html"));
    const Json json = results("new/light");
    EXPECT_EQ(json.at("command"), "bench light");
    EXPECT_EQ(json.at("interrupted"), false);
    EXPECT_EQ(json.at("devices").size(), 1u);
    EXPECT_EQ(json.at("scenes").at(0).at("has_tree"), false);
    EXPECT_EQ(json.at("scenes").at(1).at("has_tree"), true);
    EXPECT_EQ(json.at("scenes").at(1).at("chooses_by_tree"), true);
    // Two numbers of samples each of power and guided, and of the tree where there is one.
    std::map<std::string, int> rows;
    for (const Json& row : json.at("rows")) {
        for (const char* key : {"spp", "cpu_seconds", "render_seconds", "rays", "relmse",
                                "relmse_trimmed", "time_ratio", "eff", "eff_low", "eff_trimmed"}) {
            ASSERT_TRUE(row.at(key).is_number()) << key << ": " << row.dump();
            EXPECT_GT(row.at(key).get<double>(), 0) << key << ": " << row.dump();
        }
        EXPECT_LE(row.at("relmse_trimmed").get<double>(), row.at("relmse").get<double>());
        EXPECT_LE(row.at("relmse_low").get<double>(), row.at("relmse").get<double>());
        EXPECT_EQ(row.at("pairs"), 2);
        const bool isPlain = row.at("strategy") == "power";
        if (isPlain || row.at("strategy") == "tree") {
            EXPECT_EQ(row.at("mean_z").is_null(), isPlain) << row.dump();
        }
        EXPECT_EQ(row.at("eff") == 1, isPlain);
        ++rows[row.at("scene").get<std::string>() + ' ' + row.at("strategy").get<std::string>()];
    }
    EXPECT_EQ(rows, (std::map<std::string, int>{{"cornell-diffuse power", 2},
                                                {"cornell-diffuse guided", 2},
                                                {"hall power", 2},
                                                {"hall tree", 2},
                                                {"hall guided", 2}}));

    const std::string page = readAll(work("new/light/light.html")),
                      csv = readAll(work("new/light/light.csv"));
    EXPECT_EQ(readMarkup(page).problem, "");
    EXPECT_FALSE(contains(page, "http://") || contains(page, "https://"));
    EXPECT_FALSE(contains(withoutPictures(page), "nan"));
    EXPECT_TRUE(csv.starts_with("scene,strategy,device,spp,"));
    EXPECT_EQ(size_t(std::ranges::count(csv, '\n')), 1 + json.at("rows").size());
    EXPECT_TRUE(contains(result.out, "cornell-diffuse, 24x16"));
}

/// The same seeds give the same errors, and strategies that differ in name alone the same pictures:
/// in a scene with one lamp connections by whatever choice are the same.
TEST_F(LightCommand, ErrorsRepeat)
{
    const Strings bench = kBench + kTiny + Strings{kScene, "-o", "x", "-q", "--quick"};
    const auto errors = [&](const Strings& more) {
        const Result result = run(bench + more);
        EXPECT_EQ(result.code, 0) << result.err;
        std::vector<double> values;
        const Json json = results("x");
        for (const Json& row : json.at("rows"))
            for (const char* key : {"relmse", "relmse_trimmed", "rays"})
                values.push_back(row.at(key).get<double>());
        return values;
    };
    const std::vector<double> first = errors({});
    ASSERT_EQ(first.size(), 6u);
    EXPECT_EQ(errors({}), first);
    EXPECT_NE(errors({"--seed", "77"}), first);
    // Four times the samples: about a quarter of the error, from independent samples.
    const std::vector<double> more =
        errors({"--sampler", "independent", "--samples", "4,64", "--pairs", "4"});
    EXPECT_NEAR(std::log2(more[0] / more[3]), 4, 1);
}

TEST_F(LightCommand, CtrlCKeepsWhatIsThere)
{
    // So many pairs that only a signal ends them.
    const pid_t pid =
        start(kBench + kTiny +
              Strings{kScene, "-o", "new/light", "--quick", "--pairs", "1000", "--size", "96x64"});
    waitForError("pair 2");  // or any from 20 to 29
    kill(pid, SIGINT);
    const Result result = finish(pid, 60);
    EXPECT_EQ(result.code, 130) << result.err;
    EXPECT_TRUE(contains(result.err, "what was measured so far is written"));
    const Json json = results("new/light");
    EXPECT_EQ(json.at("interrupted"), true);
    ASSERT_FALSE(json.at("rows").empty());
    EXPECT_GE(json.at("rows")[0].at("pairs"), 1);
    EXPECT_TRUE(contains(readAll(work("new/light/light.html")), "Interrupted"));
}

}  // namespace
}  // namespace app::light

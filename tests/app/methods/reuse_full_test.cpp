// The ceiling of sample reuse, on every device: as many fresh paths as a history stands for, and
// nothing is kept but how many these are.
#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

class ReuseFull : public ReuseFlights {};

/// N of the history and n new ones; N grows with every view up to its cap, which is kept. The paths
/// of a pixel may be many times those that a device has room for.
TEST_P(ReuseFull, TakesAsManyPathsAsTheHistoryStandsFor)
{
    begin("cornell-diffuse", {16, 12});
    struct Case {
        float rays, cap;
        uint32_t views;
    };
    for (const auto [rays, cap, views] :
         {Case{1, 5, 8}, Case{4, 64, 20}, Case{2.5f, 1023, 4}, Case{0.25f, 10, 20}}) {
        ReuseParams params = with(ReuseStrategy::full, 3, rays);
        params.cap = cap;
        float nominal = 0;
        for (uint32_t view = 0; view < views; ++view) {
            SCOPED_TRACE("rays " + std::to_string(rays) + ", view " + std::to_string(view));
            look(swung(*world_, 0), params, view == 0 ? core::Start::anew : core::Start::moved);
            const bool few = rays < 1 && nominal >= 8;  // those below take turns
            const float due = nominal + (few ? rays : std::max(rays, 1.0f));
            nominal = std::min(due, cap);
            const std::vector<core::Image> maps = renderer_->maps();
            double taken = 0, scatter = 0;
            for (size_t i = 0; i < maps[0].pixels.size(); ++i) {
                if (maps[0].pixels[i] == 0) continue;  // nothing is hit
                ++scatter;
                taken += double(maps[5].pixels[i]);
                ASSERT_NEAR(maps[0].pixels[i], nominal, 0.07f * static_cast<float>(view + 1));
                ASSERT_LT(std::abs(maps[5].pixels[i] - due), 1.6f);
                ASSERT_EQ(maps[1].pixels[i], 0) << "nothing old answers for anything";
            }
            ASSERT_GT(scatter, 0);
            EXPECT_NEAR(taken / scatter, due, 0.2);
            EXPECT_EQ(detail("history"), 0);
            EXPECT_EQ(detail("c"), 0);
            EXPECT_NEAR(detail("weights"), 1, 0.03);
        }
        EXPECT_LE(detail("n"), double(cap + rays + 1));
    }
}

/// What so many paths promise: the variance of 12 is a third of that of 4. One path more or less
/// would be seen.
TEST_P(ReuseFull, VarianceIsThatOfSoManyPaths)
{
    constexpr uint32_t kSeeds = 96;
    begin("cornell-diffuse", {20, 20});
    std::vector<tests::Moments> few(400), many(400);
    const auto add = [&](std::vector<tests::Moments>& to) {
        const core::Image found = renderer_->read(core::Reading::mean).mean;
        for (size_t i = 0; i < to.size(); ++i)
            to[i].add(double(found.pixels[3 * i] + found.pixels[3 * i + 1]));
    };
    for (uint32_t seed = 0; seed < kSeeds; ++seed) {
        look(swung(*world_, 0), with(ReuseStrategy::discard, 7000 + seed, 4), core::Start::anew);
        add(few);
        ReuseParams params = with(ReuseStrategy::full, 8000 + seed, 4);
        params.cap = 8;
        fly(params, 3, 0);
        add(many);
    }
    tests::Moments difference, expected;
    for (size_t i = 0; i < few.size(); ++i) {
        difference.add(3 * many[i].variance() - few[i].variance());
        expected.add(few[i].variance());
    }
    const double error = std::sqrt(difference.varianceOfMean());
    EXPECT_LT(std::abs(difference.mean()), tests::kScore * error);
    EXPECT_LT((tests::kScore + 2.33) * error, 0.15 * expected.mean()) << "underpowered";
}

TEST_P(ReuseFull, AMoveLeavesTheMeanAsItIs)
{
    constexpr uint32_t kFlights = 24;
    begin("cornell-diffuse", {24, 24});
    const double expected = meanOf(reference(2048).mean);
    tests::Moments means;
    for (uint32_t flight = 0; flight < kFlights; ++flight) {
        const core::Estimate e = fly(with(ReuseStrategy::full, 900 + flight, 2), 5, 3);
        EXPECT_TRUE(e.counters.clean());
        means.add(meanOf(e.mean));
    }
    const double error = std::sqrt(means.varianceOfMean());
    EXPECT_LT(std::abs(means.mean() - expected), tests::kScore * error + 0.001 * expected);
    EXPECT_LT((tests::kScore + 2.33) * error, 0.02 * expected) << "underpowered";
}

/// Without a history it is Discard, to the bit: in the first view, and where nothing of the view
/// before can be seen.
TEST_P(ReuseFull, ATeleportIsDiscard)
{
    begin("cornell-glossy", {32, 24});
    const core::Camera here = swung(*world_, 0);
    core::Camera behind = here;
    behind.forward = -here.forward;
    behind.position = {0, 0, -0.5};
    for (const core::SamplerKind sampler :
         {core::SamplerKind::independent, core::SamplerKind::sobol}) {
        const auto views = [&](ReuseStrategy strategy) {
            ReuseParams params = with(strategy, 4, 2);
            params.sampler = sampler;
            std::vector<core::Estimate> found;
            look(here, params, core::Start::anew);
            found.push_back(renderer_->read(core::Reading::everything));
            look(behind, params, core::Start::moved);
            found.push_back(renderer_->read(core::Reading::everything));
            return found;
        };
        const std::vector<core::Estimate> discarded = views(ReuseStrategy::discard),
                                          full = views(ReuseStrategy::full);
        EXPECT_EQ(full[0].mean.pixels, discarded[0].mean.pixels);
        size_t alone = 0;
        for (size_t i = 0; i < full[1].weight.pixels.size(); ++i) {
            if (full[1].weight.pixels[i] != 2) continue;
            ++alone;
            for (size_t c = 0; c < 3; ++c)
                ASSERT_EQ(full[1].mean.pixels[3 * i + c], discarded[1].mean.pixels[3 * i + c]) << i;
        }
        EXPECT_GT(alone, full[1].weight.pixels.size() / 2);
    }
}

TEST_P(ReuseFull, ItIsWhatTheCpuFinds)
{
    core::Estimate found[2];
    for (const bool cpu : {false, true}) {
        renderer_ = &sharedRenderer("reuse", cpu ? app::DeviceKind::cpu : GetParam());
        begin("cornell-moderate", {40, 30});
        found[cpu] = fly(with(ReuseStrategy::full, 12), 6, 0.25);
    }
    size_t off = 0;
    for (size_t i = 0; i < found[0].mean.pixels.size(); ++i) {
        const float here = found[0].mean.pixels[i], there = found[1].mean.pixels[i];
        off += std::abs(here - there) > 2e-3f * (there + 0.01f);
    }
    // Rays that graze an edge may fall to either side of it, and here there are many to a pixel.
    EXPECT_LT(off, found[0].mean.pixels.size() / 20);
    EXPECT_NEAR(meanOf(found[0].mean), meanOf(found[1].mean), 1e-2 * meanOf(found[1].mean));
    EXPECT_NEAR(meanOf(found[0].variance), meanOf(found[1].variance),
                0.1 * meanOf(found[1].variance));
}

/// What some flights have found of one view: its mean, and each pixel's.
struct Found {
    tests::Moments mean;
    std::vector<tests::Moments> pixels;

    void add(const core::Image& image)
    {
        mean.add(meanOf(image));
        pixels.resize(image.pixels.size() / 3);
        for (size_t i = 0; i < pixels.size(); ++i) {
            const float* p = &image.pixels[3 * i];
            pixels[i].add(double(p[0] + p[1] + p[2]) / 3);
        }
    }
};

/// Where two devices differ: the scores of the pixels that show each material.
std::string scoresByMaterial(const Found (&found)[2], const core::Image& ids,
                             const core::Scene& scene)
{
    std::map<std::string, std::pair<double, double>> differences;  // sums, and of their variances
    for (size_t i = 0; i < found[0].pixels.size(); ++i) {
        const auto material = static_cast<int>(ids.pixels[3 * i + 1]);
        const std::string name = material < 0 ? "nothing" : scene.materials[size_t(material)].name;
        auto& [sum, variance] = differences[name];
        sum += found[0].pixels[i].mean() - found[1].pixels[i].mean();
        variance += found[0].pixels[i].varianceOfMean() + found[1].pixels[i].varianceOfMean();
    }
    std::string text;
    for (const auto& [name, d] : differences)
        text += "\n" + name + ": " + std::to_string(d.first / std::sqrt(d.second + 1e-30));
    return text;
}

/// Through glass, where a grain of rounding becomes another path: by Welch's test, from other
/// seeds. So are the paths of one view alone, which tells a fault of this strategy from others.
TEST_P(ReuseFull, BehindGlassItIsWhatTheCpuFinds)
{
    for (const ReuseStrategy strategy : {ReuseStrategy::discard, ReuseStrategy::full}) {
        Found found[2];
        for (const bool cpu : {false, true}) {
            renderer_ = &sharedRenderer("reuse", cpu ? app::DeviceKind::cpu : GetParam());
            begin("glass", {32, 24});
            for (uint32_t flight = 0; flight < 16; ++flight) {
                const core::Estimate e = fly(with(strategy, 50 + (cpu ? 20 : 0) + flight), 5, 0.5);
                EXPECT_TRUE(e.counters.clean()) << core::enumName(strategy);
                found[cpu].add(e.mean);
            }
        }
        const tests::Comparison c = tests::welch(found[0].mean, found[1].mean);
        const auto shown = [](const tests::Moments& m) {
            return std::to_string(m.mean()) + " +- " +
                   std::to_string(std::sqrt(m.varianceOfMean()));
        };
        EXPECT_LT(std::abs(c.z), tests::kScore)
            << core::enumName(strategy) << ": " << shown(found[0].mean) << ", CPU "
            << shown(found[1].mean)
            << scoresByMaterial(found, renderer_->aovs().ids, *world_->scene);
        EXPECT_LT(c.detectable, 0.2);
    }
}

/// No lane may trace so many rays in a row that a software device cuts them short (traverse.glsl).
TEST_P(ReuseFull, LongHistoriesOfDeepPathsKeepTheirLight)
{
    double weights[2], rays[2];
    core::Estimate found[2];
    for (const bool cpu : {false, true}) {
        renderer_ = &sharedRenderer("reuse", cpu ? app::DeviceKind::cpu : GetParam());
        begin("hall", {8, 8});
        ReuseParams params = with(ReuseStrategy::full, 3);
        params.maxDepth = params.rouletteDepth = 32;
        look(swung(*world_, 0), params, core::Start::anew, 32);
        look(swung(*world_, 0), params, core::Start::moved);
        found[cpu] = renderer_->read(core::Reading::everything);
        weights[cpu] = detail("weights");
        rays[cpu] = double(renderer_->stats().rays);
        EXPECT_NEAR(detail("n"), 33, 1);
    }
    EXPECT_NEAR(weights[0], 1, 0.05);
    EXPECT_NEAR(weights[0], weights[1], 0.01);
    EXPECT_NEAR(rays[0], rays[1], 0.01 * rays[1]);
    EXPECT_NEAR(meanOf(found[0].mean), meanOf(found[1].mean), 0.02 * meanOf(found[1].mean));
    EXPECT_TRUE(found[0].counters.clean());
}

/// Not those that were due to pixels that scatter nothing.
TEST_P(ReuseFull, PathsAreCountedThatWereTaken)
{
    SceneBuilder b;  // half of the picture shows its colour alone
    core::Material unlit = lambert(glm::vec3(1));
    unlit.data.flags |= shared::kMaterialUnlit;
    b.quad({0, -9, 0}, {9, 0, 0}, {0, 18, 0}, b.material(unlit));
    b.quad({-9, -9, 0}, {9, 0, 0}, {0, 18, 0}, b.material(lambert(glm::vec3(0.5f))));
    b.camera({0, 0, 4}, {0, 0, 0}, 0.6);
    uint64_t paths[2];
    for (const ReuseStrategy strategy : {ReuseStrategy::full, ReuseStrategy::ra}) {
        for (const bool cpu : {false, true}) {
            renderer_ = &sharedRenderer("reuse", cpu ? app::DeviceKind::cpu : GetParam());
            world_ = b.world();
            size_ = {32, 32};
            renderer_->setWorld(world_, {});
            for (const core::Start start : {core::Start::anew, core::Start::moved})
                look(world_->cameras.at(0), with(strategy, 3, 4), start);
            paths[cpu] = renderer_->stats().paths;
        }
        EXPECT_NEAR(double(paths[0]), double(paths[1]), 16) << core::enumName(strategy);
    }
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseFull,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace

// Path tracing that keeps its samples while the scene moves, on every device: what rests keeps its
// samples and what moves takes them along; where a ball or a lamp may have changed the light old
// samples do not count, so that no shadow stays behind.
#include <algorithm>
#include <cmath>

#include "core/trace/world_bvh.h"
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/animated_scenes.h"

namespace {

using namespace tests;

using Path = core::AnimationChannel::Path;

/// What of the room moves.
struct Moves {
    bool ball = false, lamp = false;
    uint32_t pebbles = 0;  // that fly apart
};

/// A closed room in which a ball rolls along, a second lamp swings and pebbles fly, over a second.
std::shared_ptr<const core::World> roomWith(Moves moves)
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), glossy(glm::vec3(0.8f), 0, 0.5f));
    const auto lastNode = [&] {
        const int node = static_cast<int>(b.scene.nodes.size()) - 1;
        b.scene.nodes[static_cast<size_t>(node)].local = core::Transform();
        return node;
    };
    const int green = b.material(lambert(glm::vec3(0.4f, 0.6f, 0.2f)));
    b.sphere({0, 0, 0}, 0.25f, 3, green, false, true);
    const int ball = lastNode();
    b.quad({-0.1f, 0, 0.1f}, {0.2f, 0, 0}, {0, 0, -0.2f},
           b.material(emitter(glm::vec3(20), glm::vec3(0.3f), true)));
    const int lamp = lastNode();
    const glm::vec4 upright(0, 0, 0, 1), quarter(0, 0, -0.7071068f, 0.7071068f);
    const glm::vec4 left(-0.5f, -0.75f, 0.6f, 0), right(0.3f, -0.75f, 0.6f, 0);
    const glm::vec4 low(0.5f, 0.2f, 0, 0), high(0.2f, 0.5f, 0.3f, 0);
    animate(b.scene, {channelOf(ball, Path::translation, {left, moves.ball ? right : left}),
                      channelOf(ball, Path::rotation, {upright, moves.ball ? quarter : upright}),
                      channelOf(lamp, Path::translation, {low, moves.lamp ? high : low})});
    for (uint32_t i = 0; i < moves.pebbles; ++i) {
        b.sphere({0, 0, 0}, 0.03f, 1, green, false, true);
        const float angle = 2.4f * float(i);
        const glm::vec4 there(0.8f * std::cos(angle), 0.6f, 0.8f * std::sin(angle), 0);
        animate(b.scene, {channelOf(lastNode(), Path::translation,
                                    {glm::vec4(0.3f, 0.1f, 0.3f, 0) + 0.05f * there, there})});
    }
    return b.world();
}

/// The room with a point light that swings over a second; no mesh can move.
std::shared_ptr<const core::World> roomWithPointLight()
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), glossy(glm::vec3(0.8f), 0, 0.5f));
    core::PunctualLight light;
    light.intensity = 0.5f;
    b.light(light, glm::dmat4(1));
    const int node = static_cast<int>(b.scene.nodes.size()) - 1;
    b.scene.nodes[static_cast<size_t>(node)].local = core::Transform();
    animate(b.scene,
            {channelOf(node, Path::translation, {{0.5f, 0.3f, 0.3f, 0}, {0, 0.5f, 0.3f, 0}})});
    return b.world();
}

/// What many pictures of one view make together: the mean square of their error, and the mean of
/// blocks of 8 x 8 pixels with its deviation from the truth in standard errors.
class Pictures {
public:
    explicit Pictures(const core::Image& truth)
        : truth_(truth), blocks_(size_t(truth.width / 8) * (truth.height / 8))
    {
        for (size_t i = 0; i < truth.pixels.size(); ++i)
            blocks_[blockOf(i)].truth += double(truth.pixels[i]);
    }

    void add(const core::Image& picture)
    {
        std::vector<double> sums(blocks_.size());
        double whole = 0;
        for (size_t i = 0; i < picture.pixels.size(); ++i) {
            const double d = double(picture.pixels[i]) - double(truth_.pixels[i]);
            squares_ += d * d;
            whole += d;
            sums[blockOf(i)] += d;
        }
        for (size_t i = 0; i < blocks_.size(); ++i) blocks_[i].add(sums[i]);
        whole_.add(whole);
        ++count_;
    }

    double meanSquare() const { return squares_ / (count_ * double(truth_.pixels.size())); }
    /// Of the whole picture, relative; and its standard error.
    double signedError() const { return whole_.mean(count_) / truthSum(); }
    double deviation() const { return whole_.deviation(count_) / truthSum(); }
    /// The largest deviation of a block's mean, in its standard errors.
    double worstScore() const
    {
        double worst = 0;
        for (const Sum& block : blocks_)
            worst = std::max(worst, std::abs(block.mean(count_)) / block.deviation(count_));
        return worst;
    }
    /// And relative to what the block should be.
    double worstError() const
    {
        double worst = 0;
        for (const Sum& block : blocks_)
            worst = std::max(worst, std::abs(block.mean(count_) / block.truth));
        return worst;
    }

private:
    struct Sum {
        double sum = 0, squares = 0, truth = 0;

        void add(double d)
        {
            sum += d;
            squares += d * d;
        }
        double mean(double count) const { return sum / count; }
        double deviation(double count) const
        {
            return std::sqrt(std::max(squares / count - mean(count) * mean(count), 0.0) /
                             (count - 1));
        }
    };

    size_t blockOf(size_t i) const
    {
        const size_t x = i / 3 % truth_.width, y = i / 3 / truth_.width;
        return y / 8 * (truth_.width / 8) + x / 8;
    }
    double truthSum() const
    {
        double sum = 0;
        for (const float x : truth_.pixels) sum += double(x);
        return sum;
    }

    core::Image truth_;
    std::vector<Sum> blocks_;
    Sum whole_;
    double squares_ = 0, count_ = 0;
};

constexpr uint32_t kMovingFrames = 16;

class ReuseMotion : public ReuseFlights {
protected:
    void start(Moves moves, uint32_t maxDepth) { start(roomWith(moves), maxDepth); }

    void start(std::shared_ptr<const core::World> world, uint32_t maxDepth)
    {
        world_ = std::move(world);
        size_ = {32, 32};
        maxDepth_ = maxDepth;
    }

    void pose(double time)
    {
        world_ = core::poseWorld(world_, time);
        renderer_->setWorld(world_, {});
    }

    /// What is said of the bias.
    std::string bias() const
    {
        for (const core::StatsDetail& d : renderer_->stats().details)
            if (d.name == "bias") return std::get<std::string>(d.value);
        return {};
    }

    ReuseParams paramsOf(ReuseStrategy strategy, uint32_t seed) const
    {
        ReuseParams params = with(strategy, seed);
        params.maxDepth = maxDepth_;
        return params;
    }

    /// The last of some frames, of 1/32 s, that end at one second; the camera rests or swings by
    /// `step` degrees a frame.
    core::Image play(const ReuseParams& params, double step = 0)
    {
        for (uint32_t i = 0; i < kMovingFrames; ++i) {
            pose(1 - double(kMovingFrames - 1 - i) / 32);
            look(swung(*world_, -step * (kMovingFrames - 1 - i)), params,
                 i == 0 ? core::Start::anew : core::Start::moved);
        }
        return renderer_->read(core::Reading::mean).mean;
    }

    /// The last frame alone: nothing of those before it is left to Discard.
    core::Image fresh(uint32_t seed)
    {
        pose(1);
        look(swung(*world_, 0), paramsOf(ReuseStrategy::discard, seed), core::Start::anew);
        return renderer_->read(core::Reading::mean).mean;
    }

    /// Plays from the start until the moving part of the hierarchy has been built anew `most`
    /// times; every frame but the first must have its histories. Returns how often it was.
    uint32_t playThroughRebuilds(const ReuseParams& params, uint32_t most)
    {
        std::shared_ptr<const core::Bvh> before;
        uint32_t rebuilt = 0;
        for (uint32_t i = 0; i < kMovingFrames && rebuilt < most; ++i) {
            pose(double(i) / kMovingFrames);
            const auto now = core::bvhOf(*world_);
            if (before && !now->moving.slots.sharesWith(before->moving.slots)) ++rebuilt;
            before = now;
            look(swung(*world_, 0), params, i == 0 ? core::Start::anew : core::Start::moved);
            if (i > 0) {
                EXPECT_GT(detail("history"), 0.9) << "frame " << i;
            }
        }
        return rebuilt;
    }

    /// As good as 8192 independent samples (ReuseFlights::reference).
    core::Image truth()
    {
        pose(1);
        ReuseParams params = paramsOf(ReuseStrategy::discard, 991);
        params.sampler = core::SamplerKind::sobol;
        look(swung(*world_, 0), params, core::Start::anew, maxDepth_ > 2 ? 4096 : 2048);
        return renderer_->read(core::Reading::mean).mean;
    }

    Pictures pictures(ReuseStrategy strategy, const core::Image& truth, uint32_t count,
                      double step = 0)
    {
        Pictures found(truth);
        for (uint32_t i = 0; i < count; ++i)
            found.add(strategy == ReuseStrategy::discard ? fresh(40 + i)
                                                         : play(paramsOf(strategy, 40 + i), step));
        return found;
    }

    uint32_t maxDepth_ = 8;
};

/// T-31, as far as samples know over which ways their light has come: to the first hit over two
/// surfaces at most, old light counts only where nothing has come between. Naive accumulation shows
/// what the test would see: the ball's shadow of frames before.
TEST_P(ReuseMotion, ShadowsDoNotStayBehind)
{
    start(Moves{.ball = true}, 2);
    const core::Image expected = truth();
    const double discard = pictures(ReuseStrategy::discard, expected, 4).meanSquare();
    for (const ReuseStrategy strategy : {ReuseStrategy::ra, ReuseStrategy::mis}) {
        const Pictures found = pictures(strategy, expected, 32);
        EXPECT_LT(found.worstScore(), 5) << core::enumName(strategy);
        EXPECT_LT(std::abs(found.signedError()), 4.21 * found.deviation());
        EXPECT_LT(found.deviation(), 0.002) << "too little would be seen";
        EXPECT_LT(found.meanSquare(), 0.3 * discard) << core::enumName(strategy);  // .12 found
    }
    const Pictures naive = pictures(ReuseStrategy::naive, expected, 32);
    EXPECT_GT(naive.worstScore(), 10);
    EXPECT_GT(naive.worstError(), 0.05);
}

/// What a lamp shines on is refreshed wherever it may have shone; the rest keeps its samples.
TEST_P(ReuseMotion, LightOfALampGoesWithIt)
{
    start(Moves{.lamp = true}, 2);
    const core::Image expected = truth();
    const double discard = pictures(ReuseStrategy::discard, expected, 8).meanSquare();
    const Pictures found = pictures(ReuseStrategy::ra, expected, 32);
    EXPECT_LT(found.worstScore(), 5);
    EXPECT_LT(std::abs(found.signedError()), 4.21 * found.deviation());
    EXPECT_LT(found.deviation(), 0.006);
    EXPECT_LT(found.meanSquare(), discard);
}

/// Where lights move and no mesh, every pixel keeps its history.
TEST_P(ReuseMotion, LightOfAPointGoesWithIt)
{
    start(roomWithPointLight(), 2);
    const core::Image expected = truth();
    const Pictures found = pictures(ReuseStrategy::ra, expected, 32);
    EXPECT_EQ(detail("history"), 1);
    EXPECT_LT(found.worstScore(), 5);
    EXPECT_LT(std::abs(found.signedError()), 4.21 * found.deviation());
    EXPECT_LT(found.deviation(), 0.006);
}

/// What was known of a scene says nothing about the next one: not which slots its triangles went to
/// when a hierarchy was built anew.
TEST_P(ReuseMotion, AnotherSceneFindsNothingOfTheLast)
{
    start(Moves{.pebbles = 40}, 4);
    ASSERT_EQ(playThroughRebuilds(paramsOf(ReuseStrategy::ra, 5), 1), 1u);
    start(Moves{.ball = true}, 4);
    const core::Image after = play(paramsOf(ReuseStrategy::ra, 5));
    const auto fresh = app::makeRenderer("reuse", {.device = GetParam()});
    renderer_ = fresh.get();
    start(Moves{.ball = true}, 4);
    EXPECT_EQ(play(paramsOf(ReuseStrategy::ra, 5)).pixels, after.pixels);
}

/// Light over more surfaces is not asked about and lags: by little.
TEST_P(ReuseMotion, LongerPathsLagByLittle)
{
    start(Moves{.ball = true}, 8);
    const core::Image expected = truth();
    const double discard = pictures(ReuseStrategy::discard, expected, 4).meanSquare();
    const Pictures resting = pictures(ReuseStrategy::ra, expected, 16);
    EXPECT_LT(std::abs(resting.signedError()), 0.005 + 4.21 * resting.deviation());
    EXPECT_LT(resting.meanSquare(), 0.35 * discard);  // .16 found
    const Pictures swinging = pictures(ReuseStrategy::ra, expected, 16, 1);
    EXPECT_LT(std::abs(swinging.signedError()), 0.005 + 4.21 * swinging.deviation());
    EXPECT_LT(swinging.meanSquare(), 0.4 * discard);
}

/// The ball's own pixels find their history where it was.
TEST_P(ReuseMotion, WhatMovesTakesItsSamplesAlong)
{
    start(Moves{.ball = true}, 8);
    const core::Image expected = truth();
    const core::Aovs aovs = renderer_->aovs();
    double errors[2] = {};
    for (const ReuseStrategy strategy : {ReuseStrategy::discard, ReuseStrategy::ra})
        for (uint32_t flight = 0; flight < 12; ++flight) {
            const core::Image found = strategy == ReuseStrategy::discard
                                          ? fresh(80 + flight)
                                          : play(paramsOf(strategy, 80 + flight));
            for (size_t i = 0; i < found.pixels.size(); ++i) {
                const int material = int(aovs.ids.pixels[3 * (i / 3) + 1]);
                const double d = double(found.pixels[i]) - double(expected.pixels[i]);
                if (material >= 0 && world_->materials[size_t(material)].baseColor.y == 0.6f)
                    errors[strategy == ReuseStrategy::ra] += d * d;
            }
        }
    ASSERT_GT(errors[0], 0) << "the ball is seen";
    EXPECT_LT(errors[1], 0.6 * errors[0]);  // .3 found
}

/// No bound is known for what lags: who asks for one begins anew.
TEST_P(ReuseMotion, WhoAsksForABoundBeginsAnew)
{
    start(Moves{.ball = true}, 8);
    const core::Image discard = play(paramsOf(ReuseStrategy::discard, 5));
    for (const core::ReuseBias bias : {core::ReuseBias::bounded, core::ReuseBias::unbiased}) {
        ReuseParams params = paramsOf(ReuseStrategy::ra, 5);
        params.bias = bias;
        EXPECT_EQ(play(params).pixels, discard.pixels) << core::enumName(bias);
        EXPECT_EQ(detail("history"), 0);
    }
    EXPECT_EQ(bias(), "none");
    EXPECT_NE(play(paramsOf(ReuseStrategy::ra, 5)).pixels, discard.pixels);
    EXPECT_NE(bias().find("where things move"), std::string::npos) << "what lags is named";
    EXPECT_GT(detail("history"), 0.9);
}

/// A pass over a new pose that is cut short, and then another start: nothing of what had moved is
/// left to look back to.
TEST_P(ReuseMotion, AnInterruptedPoseLeavesNothingBehind)
{
    start(Moves{.ball = true}, 4);
    size_ = {64, 64};
    for (const core::Start again : {core::Start::anew, core::Start::moved}) {
        const auto other = paramsOf(ReuseStrategy::ra, again == core::Start::anew ? 5 : 6);
        pose(0.5);
        look(swung(*world_, 0), paramsOf(ReuseStrategy::ra, 5), core::Start::anew);
        pose(0.6);
        renderer_->setView({swung(*world_, 0), size_, paramsOf(ReuseStrategy::ra, 5)},
                           core::Start::moved);
        renderer_->advance({.samples = 1, .seconds = 0}, {});
        if (GetParam() == app::DeviceKind::cpu) {
            ASSERT_EQ(renderer_->progress().samples, 0u) << "else this proves nothing";
        }
        look(swung(*world_, 0), other, again);
        EXPECT_EQ(detail("history"), 0);
        if (again == core::Start::moved) continue;  // its random numbers go on
        const core::Image found = renderer_->read(core::Reading::mean).mean;
        look(swung(*world_, 0), other, core::Start::anew);
        EXPECT_EQ(renderer_->read(core::Reading::mean).mean.pixels, found.pixels);
    }
}

/// A pose in which nothing lies elsewhere is no reason to lose anything, and neither is one that
/// was never rendered.
TEST_P(ReuseMotion, OnlyWhatHasMovedCounts)
{
    start(Moves{}, 8);
    const core::Image posed = play(paramsOf(ReuseStrategy::ra, 5));
    for (uint32_t i = 0; i < kMovingFrames; ++i)
        look(swung(*world_, 0), paramsOf(ReuseStrategy::ra, 5),
             i == 0 ? core::Start::anew : core::Start::moved);
    EXPECT_EQ(renderer_->read(core::Reading::mean).mean.pixels, posed.pixels);

    start(Moves{.ball = true}, 8);
    core::Image found[2];
    for (const bool detour : {false, true}) {
        pose(0.5);
        look(swung(*world_, 0), paramsOf(ReuseStrategy::ra, 5), core::Start::anew);
        if (detour) {
            pose(0.9);
            renderer_->setView({swung(*world_, 20), size_, paramsOf(ReuseStrategy::ra, 5)},
                               core::Start::moved);
        }
        pose(0.6);
        look(swung(*world_, 0), paramsOf(ReuseStrategy::ra, 5), core::Start::moved);
        found[detour] = renderer_->read(core::Reading::mean).mean;
    }
    EXPECT_EQ(found[0].pixels, found[1].pixels);
}

/// The part of the device's hierarchy that moves is built anew when it has become loose: slots are
/// others then, and histories are found all the same.
TEST_P(ReuseMotion, HistoriesOutliveAHierarchy)
{
    start(Moves{.pebbles = 40}, 4);
    EXPECT_GT(playThroughRebuilds(paramsOf(ReuseStrategy::ra, 5), kMovingFrames), 0u)
        << "else this proves nothing";
}

/// A pose that comes back after another one, of which nothing was kept, may find its triangles in
/// other slots: what lies there now is no history.
TEST_P(ReuseMotion, APoseThatComesBackFindsItsOwnSamples)
{
    const auto posedRoom = roomWith(Moves{.pebbles = 40});
    for (const bool sameWorld : {false, true}) {
        core::Image found[2];
        for (const bool detour : {false, true}) {
            start(posedRoom, 4);
            pose(0);
            const auto world = world_;
            look(swung(*world_, 0), paramsOf(ReuseStrategy::ra, 5), core::Start::anew);
            if (detour) {
                const auto before = core::bvhOf(*world_);
                double time = 0;
                do {
                    ASSERT_LT(time += 1.0 / kMovingFrames, 1) << "nothing was built anew";
                    pose(time);
                    renderer_->setView({swung(*world_, 0), size_, paramsOf(ReuseStrategy::ra, 5)},
                                       core::Start::moved);
                } while (core::bvhOf(*world_)->moving.slots.sharesWith(before->moving.slots));
                pose(0);
                if (sameWorld) {
                    world_ = world;
                    renderer_->setWorld(world_, {});
                }
            }
            look(swung(*world_, 0), paramsOf(ReuseStrategy::ra, 5), core::Start::moved);
            found[detour] = renderer_->read(core::Reading::mean).mean;
        }
        if (detail("history") > 0) {
            EXPECT_EQ(found[0].pixels, found[1].pixels) << sameWorld;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Devices, ReuseMotion,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace

// The reference as a job: it grows, reports its progress, is independent of the picture with the
// same parameters, is right, and ends when asked to.
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "app/pictures/reference_job.h"
#include "core/gltf/gltf.h"
#include "core/image/metrics.h"
#include "tests/support/scenes/test_scenes.h"

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

app::ReferenceOrder boxOrder(uint64_t samples)
{
    app::ReferenceOrder order;
    order.world =
        core::makeWorld(core::loadGltf(REKINDLE_SOURCE_DIR "/assets/cornell-diffuse.gltf"));
    order.camera = order.world->cameras.at(0);
    order.size = {48, 40};
    order.params.as<core::PathParams>().sampler = core::SamplerKind::independent;
    order.samples = samples;
    return order;
}

TEST(ReferenceJob, IsRightAndIndependentOfThePicture)
{
    const app::ReferenceOrder order = boxOrder(1400);
    const auto box = std::make_shared<core::Mailbox<app::Reference>>();
    core::Worker worker("core");
    const uint64_t generation = worker.start("reference", app::referenceJob(order, box));
    worker.wait();
    ASSERT_EQ(worker.status().state, core::JobState::done) << worker.status().error;
    EXPECT_EQ(worker.status().fraction, 1);
    const auto reference = box->get(generation);
    ASSERT_NE(reference, nullptr);
    EXPECT_EQ(reference->samples, 1400u);
    EXPECT_GT(reference->seconds, 0);
    EXPECT_NE(reference->origin.find("seed"), std::string::npos);

    // The same parameters, the seed included: means that differ by noise of both, nowhere equal.
    const core::Estimate film =
        tests::render(order.world, order.size.x, order.size.y, 1400, order.params);
    const core::Image &mean = film.mean, &variance = film.variance;
    const core::WelchResult welch =
        core::welchTest({mean, variance, 1400}, {reference->mean, reference->variance, 1400}, 8);
    for (const core::WelchScore& channel : welch.image) EXPECT_LT(std::abs(channel.z), 4.21);
    for (const double bias : welch.detectableBias)
        EXPECT_LT(bias, 0.03) << "the test could not see an error";
    EXPECT_GT(welch.uniformP, 2.5e-5) << "tiles do not differ as independent ones would";
    size_t equal = 0, lit = 0;
    for (size_t i = 0; i < mean.pixels.size(); ++i) {
        lit += mean.pixels[i] > 0 ? 1u : 0u;
        equal += mean.pixels[i] > 0 && mean.pixels[i] == reference->mean.pixels[i] ? 1u : 0u;
    }
    EXPECT_LT(equal, lit / 100);
}

TEST(ReferenceJob, HandsOutMoreAndMoreUntilItIsCancelled)
{
    const auto box = std::make_shared<core::Mailbox<app::Reference>>();
    core::Worker worker("core");
    const uint64_t generation =
        worker.start("reference", app::referenceJob(boxOrder(1u << 30), box));
    std::vector<uint64_t> samples;
    for (const auto end = Clock::now() + 20s; Clock::now() < end && samples.size() < 6;) {
        const auto reference = box->get(generation);
        if (reference && (samples.empty() || reference->samples > samples.back()))
            samples.push_back(reference->samples);
        std::this_thread::sleep_for(100us);
    }
    ASSERT_EQ(samples.size(), 6u);
    EXPECT_LE(samples.front(), 32u);
    const core::JobStatus status = worker.status();
    EXPECT_EQ(status.stage, "reference");
    EXPECT_GT(status.fraction, 0);
    EXPECT_LT(status.fraction, 0.01);
    worker.cancel();
    const auto begin = Clock::now();
    worker.wait();
    EXPECT_LT(Clock::now() - begin, 1s);
    EXPECT_EQ(worker.status().state, core::JobState::cancelled);

    const uint64_t next = worker.start("reference", app::referenceJob(boxOrder(7), box));
    worker.wait();
    EXPECT_EQ(box->get(generation), nullptr) << "the old one is no longer taken for the new one";
    ASSERT_NE(box->get(next), nullptr);
    EXPECT_EQ(box->get(next)->samples, 7u);
}

TEST(ReferenceJob, IsCancelledWhileTheHierarchyIsBuilt)
{
    tests::SceneBuilder builder =
        tests::room(tests::lambert(glm::vec3(0.5f)), tests::lambert(glm::vec3(0.5f)));
    builder.sphere(glm::vec3(0), 0.5f, 8, 0);  // half a million triangles
    app::ReferenceOrder order = boxOrder(1000);
    order.world = builder.world();
    const auto box = std::make_shared<core::Mailbox<app::Reference>>();
    core::Worker worker("core");
    worker.start("reference", app::referenceJob(order, box));
    while (worker.status().stage != "building the BVH" && worker.status().active())
        std::this_thread::sleep_for(100us);
    worker.cancel();
    worker.wait();
    EXPECT_EQ(worker.status().state, core::JobState::cancelled);
    EXPECT_EQ(box->newest(), nullptr);
}

}  // namespace

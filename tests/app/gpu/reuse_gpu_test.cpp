// The text of shared/reuse.h and shared/rgbe.h on the device against the same text in C++ (T-29),
// on densities with every kind of fault: nothing becomes NaN, infinite or negative (T-15).
// Validation is on.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "app/gpu/base/kernel.h"
#include "core/base/pcg32.h"
#include "tests/kernels/reuse_check.h"

#include "spirv/reuse_check.h"
#include "tests/support/statistics/no_numbers.h"
#include "tests/support/statistics/random_values.h"

namespace {

using core::Pcg32;
using shared::checkReuse;
using shared::ReuseCheckInput;
using shared::ReuseCheckOutput;
using shared::RisCheck;
using tests::kFloatInf;
using tests::kFloatNan;
using tests::logUniform;
using tests::uniform;

constexpr size_t kReuseCases = 100000;

/// A density; one in eight is invalid. Without `denormals` none is negative and denormal: a fault
/// for the host, 0 for a device that has no such numbers.
float anyDensity(Pcg32& random, bool denormals)
{
    const float negative = denormals ? -1e-40f : -1.2e-38f;
    const float special[] = {0,  -0.0f,  kFloatNan, -kFloatNan,    kFloatInf, -kFloatInf,
                             -1, 1e-40f, negative,  3.4028235e38f, 3e38f};
    if (random.bits() % 8 == 0) return special[random.bits() % std::size(special)];
    return random.bits() % 2 ? logUniform(random, 1e-20, 1e20) : logUniform(random, 0.01, 100);
}

ReuseCheckInput anyInput(Pcg32& random, bool denormals)
{
    ReuseCheckInput a{};
    a.N = random.bits() % 16 == 0 ? 0 : std::floor(logUniform(random, 1, 10000));
    a.n = std::floor(logUniform(random, 1, 10000));
    a.c = static_cast<float>(
        std::clamp(double(logUniform(random, 1e-6, double(std::max(a.N, 1.0f) / a.n))), 1e-6, 1e4));
    if (random.bits() % 64 == 0) a.c = anyDensity(random, denormals);
    a.k = 1 + random.bits() % shared::kReuseMaxCandidates;
    for (size_t t = 0; t < shared::kReuseMaxCandidates; ++t) {
        a.q[t] = anyDensity(random, denormals);
        a.p[t] = random.bits() % 8 == 0 ? a.q[t] : anyDensity(random, denormals);
        a.weight[t] = anyDensity(random, denormals);
        if (a.weight[t] > 1e37f && a.weight[t] < 3e38f)
            a.weight[t] = 1e37f;  // sixteen of them are a number
        a.xi[t] = uniform(random);
    }
    a.kappa = logUniform(random, 1e-10, 1e10);
    const float scale = logUniform(random, denormals ? 1e-37 : 1e-33, 1e38);
    a.colour = {scale * uniform(random), scale * uniform(random),
                scale * logUniform(random, 1e-4, 1)};
    if (random.bits() % 8 == 0) a.colour[int(random.bits() % 3)] = anyDensity(random, denormals);
    return a;
}

std::vector<ReuseCheckOutput> onDevice(gpu::Device& device,
                                       const std::vector<ReuseCheckInput>& inputs)
{
    gpu::Kernel<shared::ItemRange> kernel(device, k_reuse_check);
    gpu::DescriptorSet set(device, kernel.own());
    gpu::Buffer in(device, "the inputs", inputs.size() * sizeof(ReuseCheckInput));
    gpu::Buffer out(device, "the answers", inputs.size() * sizeof(ReuseCheckOutput));
    in.writeAll(inputs);
    set.bind(0, in);
    set.bind(1, out);
    const shared::ItemRange range{static_cast<uint32_t>(inputs.size())};
    device.submit([&](VkCommandBuffer commands) {
        kernel.dispatch(commands, kernel.pipeline(), {nullptr, nullptr, &set}, range,
                        gpu::groupsFor(range.count));
        gpu::barrier(commands);
    });
    std::vector<ReuseCheckOutput> outputs(inputs.size());
    out.read(std::as_writable_bytes(std::span(outputs)));
    return outputs;
}

struct NamedNumber {
    const char* name;
    float ReuseCheckOutput::*member;
};
constexpr NamedNumber kNumbers[] = {
    {"alpha", &ReuseCheckOutput::alpha},        {"alphaOverQ", &ReuseCheckOutput::alphaOverQ},
    {"ratio", &ReuseCheckOutput::ratio},        {"nextC", &ReuseCheckOutput::nextC},
    {"solvedC", &ReuseCheckOutput::solvedC},    {"keepSum", &ReuseCheckOutput::keepSum},
    {"keepScale", &ReuseCheckOutput::keepScale}};

struct NamedWeight {
    const char* name;
    float RisCheck::*member;
};
constexpr NamedWeight kWeights[] = {
    {"sum", &RisCheck::sum}, {"omega", &RisCheck::omega}, {"p", &RisCheck::p}, {"u", &RisCheck::u}};

/// To 1e-4 relative, and `slack`. Denormal numbers may be 0 on a device; on one that has none, so
/// may quotients by more than 2^126, whose reciprocals are denormal.
struct Agreement {
    bool denormals;

    bool operator()(float a, float b, float slack = 0) const
    {
        return std::abs(a - b) <= std::max((1e-4f + slack) * std::max(std::abs(a), std::abs(b)),
                                           denormals ? 1.2e-38f : 1e-36f);
    }
};

/// Whether some decision of the resampling is within rounding of its threshold, so that devices may
/// differ.
bool isClose(const ReuseCheckInput& a, bool residual)
{
    float sum = 0;
    for (size_t t = 0; t < a.k; ++t) {
        const float omega = residual ? 1 - shared::reuseAlpha(a.c, a.q[t], a.p[t]) : a.weight[t];
        if (!shared::usableDensity(omega) || !shared::usableDensity(a.p[t])) continue;
        sum += omega;
        if (std::abs(a.xi[t] * sum - omega) <= 1e-5f * omega + (residual ? 1e-6f : 0)) return true;
    }
    return false;
}

bool everyNumber(const ReuseCheckOutput& r, const std::function<bool(float)>& holds)
{
    for (const NamedNumber& number : kNumbers)
        if (!holds(r.*number.member)) return false;
    for (const NamedWeight& weight : kWeights)
        if (!holds(r.residual.*weight.member) || !holds(r.weighted.*weight.member)) return false;
    return holds(r.unpacked.x) && holds(r.unpacked.y) && holds(r.unpacked.z);
}

class ReuseGpu : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

    static std::vector<ReuseCheckInput> inputs(bool denormals)
    {
        Pcg32 random(501);
        std::vector<ReuseCheckInput> all(kReuseCases);
        for (ReuseCheckInput& a : all) a = anyInput(random, denormals);
        return all;
    }

private:
    const uint64_t messages_ = gpu::validationMessages();
};

TEST_F(ReuseGpu, AnswersAsTheHostDoes)
{
    gpu::Device gpu({.index = -1, .validation = true});
    const bool denormals = gpu.isSoftware();  // Mesa's has them; a graphics card is not asked
    const Agreement agree{denormals};
    const std::vector<ReuseCheckInput> all = inputs(denormals);
    const std::vector<ReuseCheckOutput> device = onDevice(gpu, all);
    size_t parted = 0, unlikeNumber = 0, unlikeWeight = 0, unlikeFlags = 0, unlikeKept = 0,
           unlikeColour = 0;
    size_t strange = 0, reused = 0, solved = 0, picked = 0;
    for (size_t i = 0; i < all.size(); ++i) {
        const ReuseCheckInput& a = all[i];
        const ReuseCheckOutput host = checkReuse(a);
        const ReuseCheckOutput& other = device[i];
        const auto sound = [](float x) { return std::isfinite(x) && !(x < 0); };
        if (!everyNumber(host, sound) || !everyNumber(other, sound)) ++strange;
        reused += host.alpha > 0 && host.alpha < 1;
        solved += host.solvedC > shared::kReuseLeastC && host.solvedC < a.N / a.n;
        picked += host.residual.u > 0 && host.residual.pick > 0;

        unlikeFlags += host.usable != other.usable || host.faulty != other.faulty;
        for (const NamedNumber& number : kNumbers) {
            if (agree(host.*number.member, other.*number.member)) continue;
            if (unlikeNumber++ < 5)
                ADD_FAILURE() << number.name << " of case " << i << ": " << host.*number.member
                              << " on the host, " << other.*number.member << " on the device";
        }
        for (const bool residual : {true, false}) {
            const RisCheck& x = residual ? host.residual : host.weighted;
            const RisCheck& y = residual ? other.residual : other.weighted;
            if (x.accepted != y.accepted || x.pick != y.pick) {
                EXPECT_TRUE(isClose(a, residual))
                    << "case " << i << ": picks differ without reason";
                ++parted;
                continue;
            }
            // Where alpha is nearly one, what is left of 1 - alpha is rounding.
            const float slack =
                residual && x.omega > 0 ? 1e-6f * static_cast<float>(a.k) / x.omega : 0;
            for (const NamedWeight& weight : kWeights) {
                if (agree(x.*weight.member, y.*weight.member, slack)) continue;
                if (unlikeWeight++ < 5)
                    ADD_FAILURE() << "RIS " << weight.name << " of case " << i << ": "
                                  << x.*weight.member << " and " << y.*weight.member;
            }
        }
        unlikeKept += host.kept != other.kept;
        unlikeColour += host.rounded != other.rounded || host.nearest != other.nearest;
        for (int c = 0; c < 3; ++c) unlikeColour += !agree(host.unpacked[c], other.unpacked[c]);
    }
    EXPECT_EQ(strange, 0u) << "numbers that are NaN, infinite or negative";
    EXPECT_EQ(unlikeFlags, 0u);
    EXPECT_EQ(unlikeNumber, 0u);
    EXPECT_EQ(unlikeWeight, 0u);
    EXPECT_LE(parted, all.size() / 10000);
    EXPECT_LE(unlikeKept, all.size() / 10000);
    EXPECT_LE(unlikeColour, all.size() / 10000);
    // The inputs reach what they are meant to reach.
    EXPECT_GT(reused, all.size() / 10);
    EXPECT_GT(solved, all.size() / 10);
    EXPECT_GT(picked, all.size() / 10);
}

}  // namespace

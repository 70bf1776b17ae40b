// The text of shared/film.h on the device against the same text in C++: packing loses nothing,
// compensated sums agree to the bit and are those of double precision, and samples that are no
// colours are told apart. Then gpu::Film as a whole: clearing, weights, the mean. Validation is on.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "app/gpu/film.h"
#include "app/gpu/tiled_film.h"
#include "core/base/pcg32.h"
#include "tests/kernels/film_check.h"

#include "spirv/film_check.h"
#include "tests/support/statistics/no_numbers.h"
#include "tests/support/statistics/random_values.h"

namespace {

using core::Pcg32;
using shared::checkFilm;
using shared::FilmCheckInput;
using shared::FilmCheckOutput;
using shared::FilmPixel;
using tests::kFloatInf;
using tests::kFloatNan;
using tests::uniform;

constexpr size_t kFilmCases = 20000;

/// Radiance of very different sizes; one in thirty is no colour.
glm::vec3 anySample(Pcg32& random)
{
    const float scale = std::exp2(40 * uniform(random) - 30);
    glm::vec3 L(scale * uniform(random), scale * uniform(random), scale * uniform(random));
    constexpr float kSpecial[] = {kFloatNan, kFloatInf, -kFloatInf, -1.0f};
    if (random.bits() % 30 == 0)
        L[static_cast<int>(random.bits() % 3)] = kSpecial[random.bits() % 4];
    return L;
}

std::vector<FilmCheckInput> anyInputs()
{
    Pcg32 random(77);
    std::vector<FilmCheckInput> inputs(kFilmCases);
    for (FilmCheckInput& a : inputs) {
        FilmPixel p{};
        for (int c = 0; c < 3; ++c) {
            p.sum[c] = 1000 * uniform(random);
            p.sumLost[c] = 1e-5f * uniform(random);
            p.squares[c] = 1e6f * uniform(random);
            p.squaresLost[c] = 0.01f * uniform(random);
        }
        p.weight = static_cast<float>(random.bits() % 5000);
        if (random.bits() % 8 == 0) p = {};                  // an empty film
        if (random.bits() % 8 == 0) p.weight = 0x1p24f - 2;  // where a float alone stays
        a.before = shared::packFilm(p);
        for (glm::vec3& L : a.samples) L = anySample(random);
    }
    return inputs;
}

template <class T> bool sameBits(const T& a, const T& b)
{
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

class FilmGpu : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

    gpu::Context context{{.index = -1, .validation = true}};

private:
    const uint64_t messages_ = gpu::validationMessages();
};

TEST_F(FilmGpu, AnswersAsTheHostDoes)
{
    const std::vector<FilmCheckInput> inputs = anyInputs();
    gpu::Kernel<shared::ItemRange> kernel(context.device, k_film_check);
    gpu::DescriptorSet set(context.device, kernel.own());
    gpu::Buffer in(context.device, "the inputs", inputs.size() * sizeof(FilmCheckInput));
    gpu::Buffer out(context.device, "the answers", inputs.size() * sizeof(FilmCheckOutput));
    in.writeAll(inputs);
    set.bind(0, in);
    set.bind(1, out);
    context.device.submit([&](VkCommandBuffer commands) {
        kernel.dispatch(commands, kernel.pipeline(), {nullptr, nullptr, &set},
                        {static_cast<uint32_t>(kFilmCases)}, gpu::groupsFor(kFilmCases));
        gpu::barrier(commands);
    });
    std::vector<FilmCheckOutput> outputs(inputs.size());
    out.read(std::as_writable_bytes(std::span(outputs)));

    size_t unlikeSums = 0, unlikeMeans = 0, unlikeKinds = 0, repacked = 0, dropped = 0;
    for (size_t i = 0; i < inputs.size(); ++i) {
        const FilmCheckOutput host = checkFilm(inputs[i]);
        const FilmCheckOutput& device = outputs[i];
        unlikeSums += sameBits(host.after, device.after) ? 0u : 1u;
        unlikeKinds += sameBits(host.kinds, device.kinds) ? 0u : 1u;
        repacked += sameBits(inputs[i].before, device.packedAgain) &&
                            sameBits(inputs[i].before, host.packedAgain)
                        ? 0u
                        : 1u;
        for (int c = 0; c < 3; ++c)  // a device may divide by multiplying with the reciprocal
            unlikeMeans +=
                std::abs(host.mean[c] - device.mean[c]) <= 1e-6f * host.mean[c] ? 0u : 1u;
        for (const uint32_t kind :
             {shared::kSampleNan, shared::kSampleInfinite, shared::kSampleNegative})
            dropped += host.kinds[kind];
    }
    EXPECT_EQ(unlikeSums, 0u) << "compensated sums must be the same bits everywhere";
    EXPECT_EQ(unlikeKinds, 0u);
    EXPECT_EQ(unlikeMeans, 0u);
    EXPECT_EQ(repacked, 0u) << "packing loses something";
    EXPECT_GT(dropped, kFilmCases / 2) << "the inputs hold too few samples that are no colours";
}

TEST_F(FilmGpu, SumsAreThoseOfDoublePrecision)
{
    Pcg32 random(78);
    for (int trial = 0; trial < 20; ++trial) {
        FilmPixel p{};
        glm::dvec3 sum(0), squares(0);
        float plain = 0;
        constexpr int kSamples = 100000;
        for (int s = 0; s < kSamples; ++s) {
            const glm::vec3 L(uniform(random), 1e-3f * uniform(random), 1e3f * uniform(random));
            shared::addSample(p, L);
            sum += glm::dvec3(L);
            squares += glm::dvec3(L * L);
            plain += L.x;
        }
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(double(p.sum[c]) - double(p.sumLost[c]), sum[c], 1e-7 * sum[c]);
            EXPECT_NEAR(double(p.squares[c]) - double(p.squaresLost[c]), squares[c],
                        1e-7 * squares[c]);
        }
        // What compensation is for: the plain sum is further off.
        EXPECT_GT(std::abs(double(plain) - sum.x),
                  std::abs(double(p.sum.x) - double(p.sumLost.x) - sum.x));
    }
}

/// As a view that is left to itself for a night: a float alone would stay at 2^24, and the picture
/// would brighten.
TEST_F(FilmGpu, WeightsGoOnWhereAFloatStays)
{
    FilmPixel p{};
    p.weight = 0x1p24f - 2;
    double expected = double(p.weight);
    const auto add = [&](float weight) {
        shared::addWeight(p, weight);
        expected += double(weight);
    };
    for (int i = 0; i < 8; ++i) add(1);
    add(13.3f);  // a first picture that counts as more than one sample
    EXPECT_NEAR(double(p.weight) - double(p.weightLost), expected, 1e-6);
    const FilmPixel again = shared::unpackFilm(shared::packFilm(p));
    EXPECT_EQ(again.weight, p.weight);
    EXPECT_EQ(again.weightLost, p.weightLost);
}

/// A frame of `width` x `height` pixels, and radiance for whole tiles of two samples each.
struct Batches {
    gpu::Frame frame;
    gpu::Buffer radiance;
    std::vector<glm::vec4> values;

    Batches(gpu::Context& context, uint32_t width, uint32_t height)
        : frame(context.device, context.layouts)
    {
        shared::FrameData data{};
        data.settings.imageWidth = width;
        data.settings.imageHeight = height;
        data.tilesPerRow = (width + 7) / 8;
        frame.write(data);
        Pcg32 random(79);
        values.resize(size_t(frame.tileCount()) * 64 * 2);
        for (glm::vec4& v : values) v = {uniform(random), uniform(random), uniform(random), 0};
        radiance = gpu::Buffer(context.device, "the radiance", values.size() * sizeof(glm::vec4));
        radiance.writeAll(values);
    }
};

TEST_F(FilmGpu, PixelsMayBeASampleAhead)
{
    // Two samples for the first tiles only, as a renderer that stops between two batches leaves
    // them.
    constexpr uint32_t kWidth = 21, kHeight = 13,
                       kTiles = 3;  // of 6, and the image ends inside some
    Batches batches(context, kWidth, kHeight);
    gpu::Film film(context);
    for (int round = 0; round < 2; ++round) {  // the second one on a film that has been used
        film.reset(batches.frame);
        film.setRadiance(batches.radiance);
        context.device.submit([&](VkCommandBuffer commands) {
            film.accumulate(commands, batches.frame, {0, kTiles, 0, 2});
        });
        core::Image mean(kWidth, kHeight, 3);
        film.readMean(mean);
        size_t ahead = 0;
        film.read([&](size_t i, const FilmPixel& p) {
            const size_t x = i % kWidth, y = i / kWidth;
            const bool traced = y < 8;  // three tiles make a row
            EXPECT_EQ(p.weight, traced ? 2.0f : 0.0f) << x << ", " << y;
            size_t lane = (x / 8) * 64;
            for (size_t bit = 0; bit < 3; ++bit)
                lane += ((x >> bit & 1) << (2 * bit)) + ((y >> bit & 1) << (2 * bit + 1));
            for (int c = 0; c < 3; ++c) {
                const float expected =
                    traced
                        ? 0.5f * (batches.values[lane][c] + batches.values[kTiles * 64 + lane][c])
                        : 0.0f;
                EXPECT_NEAR(mean.pixels[3 * i + static_cast<size_t>(c)], expected, 1e-6f)
                    << x << ", " << y;
            }
            ahead += traced ? 1u : 0u;
        });
        EXPECT_EQ(ahead, size_t(kWidth) * 8);
    }
}

/// Films are read in parts: every pixel once and in order, with what is its own.
TEST_F(FilmGpu, PartsOfAFilmAreReadInOrder)
{
    constexpr uint32_t kWidth = 1032, kHeight = 512, kTiles = kWidth / 8 * (kHeight / 8);
    constexpr size_t kPixels = size_t(kWidth) * kHeight;
    static_assert(kPixels > 2 * gpu::Film::kPixelsRead && kPixels % gpu::Film::kPixelsRead != 0);
    Batches batches(context, kWidth, kHeight);
    gpu::Film film(context);
    film.reset(batches.frame);
    film.setRadiance(batches.radiance);
    context.device.submit([&](VkCommandBuffer commands) {
        film.accumulate(commands, batches.frame, {0, kTiles, 0, 1});
    });
    core::Image mean(kWidth, kHeight, 3);
    film.readMean(mean);
    size_t next = 0, right = 0;
    film.read([&](size_t i, const FilmPixel& p) {
        const float* const expected = mean.pixels.data() + 3 * i;
        right += i == next++ && p.weight == 1 && p.sum.x == expected[0] && p.sum.y == expected[1] &&
                         p.sum.z == expected[2]
                     ? 1u
                     : 0u;
    });
    EXPECT_EQ(next, kPixels);
    EXPECT_EQ(right, kPixels);
}

/// Squares of such radiances are infinite: without an end their pixels would be left out of the
/// picture's noise, as if there were none.
TEST_F(FilmGpu, VariancesEndAtTheLargestFloat)
{
    Batches batches(context, 16, 8);
    for (size_t i = 0; i < batches.values.size(); i += 2) batches.values[i].x = 1e20f;
    batches.radiance.writeAll(batches.values);
    gpu::TiledFilm film(context);
    film.reset(batches.frame.data());
    film.begin(batches.radiance);
    film.advance(
        {.samples = 2}, {}, [] { return 2u * 2 * 64; },
        [&](const shared::Batch& batch, const gpu::TiledFilm::Then& then) {
            context.device.submit([&](VkCommandBuffer commands) { then(commands, batch); });
        });
    const core::Image variance = film.read(core::Reading::everything).variance;
    size_t most = 0;
    for (size_t i = 0; i < variance.pixels.size(); ++i) {
        most += variance.pixels[i] == std::numeric_limits<float>::max() ? 1u : 0u;
        EXPECT_LE(variance.pixels[i], std::numeric_limits<float>::max()) << i;
        if (i % 3 != 0) {
            EXPECT_LT(variance.pixels[i], 1) << i;
        }
    }
    EXPECT_EQ(most, 64u) << "in red, of every other pixel";
}

/// Counters of 32 bits are read before they can come to their end, however long paths are.
TEST(TiledFilm, CountersAreReadInTime)
{
    for (const uint32_t maxDepth : {0u, 1u, 8u, 511u, 4096u}) {
        const uint64_t paths = gpu::pathsBetweenDrains(maxDepth);
        EXPECT_GT(paths, 0u);
        // Two rays for each vertex, and what is a batch too much.
        EXPECT_LE(paths * (uint64_t(maxDepth) + 1) * 2 * 4, uint64_t(1) << 32) << maxDepth;
        EXPECT_LE(paths << 8, uint64_t(1) << 28) << "sample reuse adds so much";
    }
    EXPECT_EQ(gpu::pathsBetweenDrains(8), 1u << 20);
    static_assert(sizeof(shared::Counters::closestRays) == 4);
}

}  // namespace

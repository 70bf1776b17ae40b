// The display transform: the kernel and the C++ text agree on random images with everything in them
// that a renderer may leave behind; maps rise in lightness; errors and differences have the values
// that their formulas give.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include "app/gpu/window/display.h"
#include "core/image/display.h"
#include "tests/support/statistics/no_numbers.h"
#include "tests/support/vulkan/vulkan_fails.h"
#include "tests/support/vulkan/vulkan_faults.h"

namespace {

using core::Image;
using shared::DisplaySettings;
using tests::kFloatInf;
using tests::kFloatNan;

/// CIE lightness of sRGB-encoded values.
double lightness(glm::vec3 c)
{
    const double y = double(shared::luminance(
        {shared::srgbDecode(c.x), shared::srgbDecode(c.y), shared::srgbDecode(c.z)}));
    return y > 0.008856 ? 116 * std::cbrt(y) - 16 : 903.3 * y;
}

/// `odd`: with what a renderer may leave behind. Without `denormals` neither denormal numbers nor
/// what has a denormal reciprocal: both may be 0 for a graphics card.
Image randomImage(uint32_t width, uint32_t height, uint32_t channels, uint32_t seed, bool odd,
                  bool denormals = true)
{
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    Image image(width, height, channels);
    const float least = denormals ? 1e-40f : 1.2e-38f, most = denormals ? 3e38f : 8e37f;
    const std::array<float, 10> special{kFloatNan, kFloatInf, -kFloatInf, 0.0f, -0.0f,
                                        -1.0f,     1e30f,     least,      most, -5.5f};
    for (float& value : image.pixels) {
        value = std::exp2(24 * unit(random) - 12) * (unit(random) < 0.1f ? -1.0f : 1.0f);
        if (odd && unit(random) < 0.15f) value = special[random() % special.size()];
    }
    return image;
}

DisplaySettings settingsOf(uint32_t show, uint32_t width, uint32_t height)
{
    DisplaySettings s{};
    s.width = width;
    s.height = height;
    s.show = show;
    s.tone = shared::kToneAgx;
    s.low = 0.01f;
    s.high = 4;
    return s;
}

std::vector<uint8_t> onDevice(gpu::Device& device, gpu::Display& display,
                              const DisplaySettings& settings, bool swapped)
{
    display.setSize(settings.width, settings.height);
    device.submit([&](VkCommandBuffer commands) { display.record(commands, settings, swapped); });
    std::vector<uint8_t> bytes(size_t(settings.width) * settings.height * 4);
    display.output().read(std::as_writable_bytes(std::span(bytes)));
    return bytes;
}

class DisplayTest : public testing::Test {
protected:
    void TearDown() override { EXPECT_EQ(gpu::validationMessages(), messages_); }

private:
    const uint64_t messages_ = gpu::validationMessages();
};

TEST_F(DisplayTest, KernelEqualsTheText)
{
    gpu::Device device({.validation = true});
    gpu::Display display(device);
    int views = 0;
    const auto compare = [&](const Image* a, const Image* b, DisplaySettings s,
                             const std::string& what) {
        display.setImage(0, a);
        display.setImage(1, b);
        s.width = 67;  // no multiple of a group, no size of an image
        s.height = 45;
        const std::vector<uint8_t> cpu = core::displayImage(a, b, s),
                                   gpu = onDevice(device, display, s, false);
        ASSERT_EQ(cpu.size(), gpu.size());
        size_t far = 0;
        for (size_t i = 0; i < cpu.size(); ++i)
            far += std::abs(int(cpu[i]) - int(gpu[i])) > 1 ? 1u : 0u;
        EXPECT_EQ(far, 0u) << what;
        ++views;
    };
    for (const bool odd : {false, true}) {
        for (const uint32_t channels : {1u, 3u}) {
            const Image a = randomImage(31, 17, channels, 1 + channels, odd, device.isSoftware());
            const Image b =
                randomImage(64, 40, 4 - channels, 11 + channels, odd, device.isSoftware());
            for (uint32_t show = 0; show <= shared::kShowPreview; ++show) {
                // Of map, kind of error, curve and channel at once; each is a kernel that has to be
                // compiled.
                for (uint32_t choice = channels == 1 ? 2 : 0; choice < (channels == 1 ? 3 : 4);
                     ++choice) {
                    DisplaySettings s = settingsOf(show, 0, 0);
                    s.tone = choice;
                    s.map = choice % 3;
                    s.errorKind = choice % 3;
                    s.channel = choice % 3;
                    s.logarithmic = choice % 2;
                    s.exposure = static_cast<float>(choice) - 1.5f;
                    s.slider = 0.3f * static_cast<float>(choice);
                    const std::string what = "show " + std::to_string(show) + " choice " +
                                             std::to_string(choice) + " channels " +
                                             std::to_string(channels) + (odd ? " odd" : "");
                    compare(&a, &b, s, what);
                    if (choice == 2) compare(&a, nullptr, s, what + " without b");
                }
            }
        }
    }
    compare(nullptr, nullptr, settingsOf(shared::kShowRadiance, 0, 0), "nothing");
    EXPECT_EQ(views, 2 * 10 * (1 + 1 + 4 + 1) + 1);
    // Beside the output's edges, inside of it, and not at all
    const Image a = randomImage(31, 17, 3, 21, false), b = randomImage(64, 40, 3, 22, false);
    for (const uint32_t show : {shared::kShowRadiance, shared::kShowCompare, shared::kShowError})
        for (const glm::vec4& place : {glm::vec4(0.25f, 0, 0.5f, 1), {-0.1f, -0.2f, 1.2f, 1.4f}}) {
            DisplaySettings s = settingsOf(show, 67, 45);
            s.slider = 0.5f;
            const core::DisplayPlaces places{place, {0, 0.3f, 1, 0.4f}};
            display.setImage(0, &a);
            display.setImage(1, &b);
            display.setSize(67, 45);
            device.submit([&](VkCommandBuffer c) { display.record(c, s, false, places); });
            std::vector<uint8_t> gpu(size_t(67) * 45 * 4);
            display.output().read(std::as_writable_bytes(std::span(gpu)));
            const std::vector<uint8_t> cpu = core::displayImage(&a, &b, s, places);
            size_t far = 0;
            for (size_t i = 0; i < cpu.size(); ++i)
                far += std::abs(int(cpu[i]) - int(gpu[i])) > 1 ? 1u : 0u;
            EXPECT_EQ(far, 0u) << show;
        }
}

/// Four columns of pixels, the first two of one surface.
TEST_F(DisplayTest, PreviewsAreSmoothWithinASurfaceAndSharpBetweenSurfaces)
{
    Image a(4, 2, 3), guide(4, 2, 1);
    constexpr uint32_t kLeft = 0b001001001, kRight = 0b100100100, kSame = 0b010010010;
    for (uint32_t y = 0; y < 2; ++y)
        for (uint32_t x = 0; x < 4; ++x) {
            for (int c = 0; c < 3; ++c) a.at(x, y)[c] = 0.1f + 0.1f * static_cast<float>(x);
            const uint32_t rows = y == 0 ? 0b111111000 : 0b000111111;
            const uint32_t bits = kSame | (x == 0 ? kRight : x == 1 ? kLeft : 0u);
            *guide.at(x, y) = static_cast<float>(bits & rows);
        }
    DisplaySettings s = settingsOf(shared::kShowPreview, 40, 20);
    s.tone = shared::kToneLinear;
    const std::vector<uint8_t> bytes = core::displayImage(&a, &guide, s);
    const auto at = [&](uint32_t x) { return bytes[(10 * 40 + x) * 4] / 255.0; };
    const auto encoded = [](float x) { return static_cast<double>(shared::srgbEncode(x)); };
    const double first = encoded(0.1f), second = encoded(0.2f);
    for (uint32_t x = 0; x < 5; ++x) EXPECT_NEAR(at(x), first, 0.003) << "the picture's edge";
    for (uint32_t x = 5; x < 15; ++x)
        EXPECT_NEAR(at(x), first + (second - first) * (x + 0.5 - 5) / 10, 0.003)
            << "one surface: a ramp of colours";
    for (uint32_t x = 15; x < 20; ++x) EXPECT_NEAR(at(x), second, 0.003) << "up to its edge";
    for (uint32_t x = 20; x < 30; ++x)
        EXPECT_NEAR(at(x), encoded(0.3f), 0.003) << "another surface";
    for (uint32_t x = 30; x < 40; ++x) EXPECT_NEAR(at(x), encoded(0.4f), 0.003);

    gpu::Device device({.validation = true});
    gpu::Display display(device);
    const Image noise = randomImage(31, 17, 3, 31, false);
    Image surfaces(31, 17, 1);
    std::mt19937 random(7);
    for (uint32_t y = 0; y < 17; ++y)
        for (uint32_t x = 0; x < 31; ++x) {
            uint32_t inside = 0x1ff;  // no bit leads out of the image
            if (x == 0) inside &= ~kLeft;
            if (x == 30) inside &= ~kRight;
            if (y == 0) inside &= 0b111111000;
            if (y == 16) inside &= 0b000111111;
            *surfaces.at(x, y) = static_cast<float>((random() | 16) & inside);
        }
    display.setImage(0, &noise);
    display.setImage(1, &surfaces);
    s = settingsOf(shared::kShowPreview, 67, 45);
    const std::vector<uint8_t> cpu = core::displayImage(&noise, &surfaces, s),
                               gpu = onDevice(device, display, s, false);
    size_t far = 0;
    for (size_t i = 0; i < cpu.size(); ++i)
        far += std::abs(int(cpu[i]) - int(gpu[i])) > 1 ? 1u : 0u;
    EXPECT_EQ(far, 0u);
}

/// More groups than any device has to take in one dimension.
TEST_F(DisplayTest, PreviewsOfLargePicturesAreWhole)
{
    tests::VulkanFaults faults;
    uint32_t most = 0;
    faults.replace<&gpu::Api::CmdDispatch>(
        [&most](auto driver, VkCommandBuffer commands, uint32_t x, uint32_t y, uint32_t z) {
            most = std::max({most, x, y, z});
            driver(commands, x, y, z);
        });
    gpu::Device device({.validation = true});
    gpu::Display display(device);
    Image a(2900, 1500, 3);
    const Image guide(2900, 1500, 1);
    for (size_t i = 0; i < a.pixels.size(); ++i) a.pixels[i] = static_cast<float>(i % 97) / 97;
    display.setImage(0, &a);
    display.setImage(1, &guide);
    const DisplaySettings s = settingsOf(shared::kShowPreview, 64, 48);
    const std::vector<uint8_t> cpu = core::displayImage(&a, &guide, s),
                               gpu = onDevice(device, display, s, false);
    size_t far = 0;
    for (size_t i = 0; i < cpu.size(); ++i)
        far += std::abs(int(cpu[i]) - int(gpu[i])) > 1 ? 1u : 0u;
    EXPECT_EQ(far, 0u);
    EXPECT_LE(most, 65535u);
}

TEST_F(DisplayTest, BesideAPictureIsTheBackground)
{
    Image a(2, 2, 3);
    for (size_t i = 0; i < a.pixels.size(); ++i) a.pixels[i] = static_cast<float>(1 + i / 3) / 4;
    DisplaySettings s = settingsOf(shared::kShowColour, 8, 4);
    const std::vector<uint8_t> bytes =
        core::displayImage(&a, nullptr, s, {.a = {0.25f, 0, 0.5f, 1}, .b = {}});
    const auto at = [&](uint32_t x, uint32_t y) { return int(bytes[(y * 8 + x) * 4]); };
    const auto is = [](float value) {
        return static_cast<int>(shared::srgbEncode(value) * 255 + 0.5f);
    };
    for (uint32_t y = 0; y < 4; ++y) {
        for (const uint32_t x : {0u, 1u, 6u, 7u}) EXPECT_EQ(at(x, y), int(0.07f * 255 + 0.5f));
        for (uint32_t x = 2; x < 6; ++x)
            EXPECT_EQ(at(x, y), is(static_cast<float>(1 + (x - 2) / 2 + 2 * (y / 2)) / 4));
    }
}

TEST_F(DisplayTest, WhereNothingWasHitIsNotWhatIsNear)
{
    Image depth(3, 1, 1);
    depth.pixels = {0, 1, 2};
    DisplaySettings s = settingsOf(shared::kShowDepth, 3, 1);
    s.low = 1;
    s.high = 2;
    const auto colour = [&](uint32_t map, size_t pixel) {
        s.map = map;
        const std::vector<uint8_t> bytes = core::displayImage(&depth, nullptr, s);
        return std::array<uint8_t, 3>{bytes[4 * pixel], bytes[4 * pixel + 1], bytes[4 * pixel + 2]};
    };
    for (const uint32_t map : {shared::kMapViridis, shared::kMapMagma, shared::kMapGrey}) {
        EXPECT_NE(colour(map, 0), colour(map, 1));
        EXPECT_EQ(colour(map, 0), colour(shared::kMapViridis, 0));
        EXPECT_NE(colour(map, 1), colour(map, 2));
    }
}

TEST_F(DisplayTest, RedAndBlueAreExchangedForWindowsThatWantIt)
{
    gpu::Device device({.validation = true});
    gpu::Display display(device);
    const Image a = randomImage(9, 7, 3, 5, true);
    display.setImage(0, &a);
    const DisplaySettings s = settingsOf(shared::kShowColour, 9, 7);
    const std::vector<uint8_t> rgba = onDevice(device, display, s, false),
                               bgra = onDevice(device, display, s, true);
    for (size_t i = 0; i < rgba.size(); i += 4) {
        EXPECT_EQ(rgba[i], bgra[i + 2]);
        EXPECT_EQ(rgba[i + 1], bgra[i + 1]);
        EXPECT_EQ(rgba[i + 2], bgra[i]);
        EXPECT_EQ(rgba[i + 3], 255);
    }
}

/// An image of more pixels than a texel buffer holds is shown thinned, not refused.
TEST_F(DisplayTest, AnImageBeyondTheLimitsOfTheDeviceIsThinned)
{
    tests::VulkanFaults faults;
    tests::lieAboutProperties(faults, [](VkPhysicalDeviceProperties& p) {
        p.limits.maxTexelBufferElements = (1u << 16) * shared::kStateWords;
    });
    gpu::Device device({.validation = true});
    const auto side = static_cast<uint32_t>(std::sqrt(device.limits().maxTexelBufferElements)) + 10;
    ASSERT_LT(side, 1000u);
    Image a(side, side, 1);
    for (uint32_t y = 0; y < side; ++y) {
        for (uint32_t x = 0; x < side; ++x) *a.at(x, y) = x < side / 2 ? 0.25f : 0.75f;
    }
    gpu::Display display(device);
    display.setImage(0, &a);
    DisplaySettings s = settingsOf(shared::kShowScalar, 40, 30);
    s.map = shared::kMapGrey;
    s.low = 0;
    s.high = 1;
    const std::vector<uint8_t> bytes = onDevice(device, display, s, false);
    for (uint32_t x = 0; x < 40; ++x)
        EXPECT_EQ(bytes[(size_t(15) * 40 + x) * 4], x < 20 ? 64 : 191) << x;
}

// --- colour maps

TEST(DisplayMap, LightnessRises)
{
    const std::array<double, 3> slopes{53, 30, 100};  // as the head of display.h says
    for (uint32_t map = 0; map < 3; ++map) {
        const int steps = 500;
        for (int i = 0; i < steps; ++i) {
            const double rise =
                lightness(shared::displayMap(map, static_cast<float>(i + 1) / steps)) -
                lightness(shared::displayMap(map, static_cast<float>(i) / steps));
            // Grey rises by 100 in all, its lower end by the linear part of the transfer function.
            EXPECT_GT(rise * steps, map == 2 ? 60 : slopes[map] * 0.98) << map << " at " << i;
        }
        EXPECT_EQ(shared::displayMap(map, -3), shared::displayMap(map, 0));
        EXPECT_EQ(shared::displayMap(map, 7), shared::displayMap(map, 1));
    }
}

/// Published values of the two maps at 0, 1/4, 1/2, 3/4, 1 (rows 0, 64, 128, 191, 255 of the tables
/// of 256).
TEST(DisplayMap, IsNearThePublishedTables)
{
    const std::array<std::array<int, 3>, 5> viridis{
        {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {92, 200, 99}, {253, 231, 37}}};
    const std::array<std::array<int, 3>, 5> magma{
        {{0, 0, 4}, {81, 18, 124}, {183, 55, 121}, {251, 135, 97}, {252, 253, 191}}};
    const std::array<int, 5> rows{0, 64, 128, 191, 255};
    for (size_t i = 0; i < 5; ++i) {
        for (int c = 0; c < 3; ++c) {
            const float t = static_cast<float>(rows[i]) / 255;
            EXPECT_NEAR(shared::displayMap(shared::kMapViridis, t)[c] * 255,
                        viridis[i][static_cast<size_t>(c)], 0.010 * 255 + 0.5);
            EXPECT_NEAR(shared::displayMap(shared::kMapMagma, t)[c] * 255,
                        magma[i][static_cast<size_t>(c)], 0.017 * 255 + 0.5);
        }
    }
}

TEST(DisplayScale, LinearAndLogarithmic)
{
    EXPECT_FLOAT_EQ(shared::displayScale(3, 1, 5, 0), 0.5f);
    EXPECT_FLOAT_EQ(shared::displayScale(-3, 1, 5, 0), 0);
    EXPECT_FLOAT_EQ(shared::displayScale(kFloatInf, 1, 5, 0), 1);
    EXPECT_NEAR(shared::displayScale(10, 1, 100, 1), 0.5f, 1e-6);
    EXPECT_EQ(shared::displayScale(0, 1, 100, 1), 0);
    EXPECT_EQ(shared::displayScale(kFloatInf, 1, 100, 1), 1);
    EXPECT_EQ(shared::displayScale(2, 3, 3, 0), 0);  // no range: below or above
    EXPECT_EQ(shared::displayScale(4, 3, 3, 0), 1);
}

// --- errors, differences, ids

TEST(DisplayError, KnownValues)
{
    EXPECT_FLOAT_EQ(shared::displayError(1.5f, 1.0f, shared::kErrorAbsolute), 0.5f);
    EXPECT_FLOAT_EQ(shared::displayError(0.5f, 1.0f, shared::kErrorAbsolute), 0.5f);
    EXPECT_FLOAT_EQ(shared::displayError(1.5f, 0.99f, shared::kErrorRelative), 0.51f);
    EXPECT_FLOAT_EQ(shared::displayError(0.1f, 0.0f, shared::kErrorRelative), 10.0f);
    EXPECT_FLOAT_EQ(shared::displayError(3.0f, 1.0f, shared::kErrorSquared), 4.0f / 1.01f);
    EXPECT_FLOAT_EQ(shared::displayError(0.1f, 0.0f, shared::kErrorSquared), 1.0f);
}

std::array<int, 3> shownAs(DisplaySettings s, glm::vec3 a, glm::vec3 b)
{
    Image imageA(1, 1, 3), imageB(1, 1, 3);
    for (uint32_t c = 0; c < 3; ++c) {
        imageA.pixels[c] = a[static_cast<int>(c)];
        imageB.pixels[c] = b[static_cast<int>(c)];
    }
    s.width = s.height = 1;
    s.slider = 9;  // far to the right: a alone
    const std::vector<uint8_t> bytes = core::displayImage(&imageA, &imageB, s);
    return {bytes[0], bytes[1], bytes[2]};
}

TEST(DisplayColour, NothingHidesNan)
{
    const std::array<int, 3> magenta{255, 0, 255};
    for (uint32_t show = 0; show <= shared::kShowPreview; ++show) {
        DisplaySettings s = settingsOf(show, 1, 1);
        s.channel = 1;
        EXPECT_EQ(shownAs(s, {1, kFloatNan, 1}, {1, 1, 1}), magenta) << show;
        EXPECT_NE(shownAs(s, {1, 1, 1}, {1, 1, 1}), magenta) << show;
    }
    EXPECT_EQ(
        shownAs(settingsOf(shared::kShowDifference, 1, 1), {kFloatInf, 1, 1}, {kFloatInf, 1, 1}),
        magenta);
    DisplaySettings linear = settingsOf(shared::kShowRadiance, 1, 1);
    linear.tone = shared::kToneLinear;
    EXPECT_EQ(shownAs(linear, {kFloatInf, kFloatInf, kFloatInf}, {}),
              (std::array<int, 3>{255, 255, 255}));
}

TEST(DisplayColour, DifferencesAreBlueBelowAndRedAbove)
{
    DisplaySettings s = settingsOf(shared::kShowDifference, 1, 1);
    s.high = 0.5f;
    const auto below = shownAs(s, glm::vec3(0.5f), glm::vec3(1)),
               above = shownAs(s, glm::vec3(1), glm::vec3(0.5f));
    EXPECT_EQ(below, (std::array<int, 3>{77, 148, 255}));
    EXPECT_EQ(above, (std::array<int, 3>{255, 92, 56}));
    EXPECT_EQ(shownAs(s, glm::vec3(9), glm::vec3(1)), above);  // full colour and no further
    EXPECT_EQ(shownAs(s, glm::vec3(1), glm::vec3(1)), (std::array<int, 3>{0, 0, 0}));
    const auto little = shownAs(s, glm::vec3(1.02f), glm::vec3(1));
    EXPECT_LT(little[0], above[0]);
    EXPECT_GT(little[0], little[2]);
}

TEST(DisplayColour, TheSliderHasALineBetweenTheTwo)
{
    Image a(100, 1, 1), b(100, 1, 1);
    for (float& v : b.pixels) v = 1;
    DisplaySettings s = settingsOf(shared::kShowCompare, 100, 1);
    s.tone = shared::kToneLinear;
    s.slider = 0.4f;
    const std::vector<uint8_t> bytes = core::displayImage(&a, &b, s);
    for (uint32_t x = 0; x < 100; ++x) {
        const int shown = bytes[x * 4];
        const int expected = x < 38 ? 0 : x == 38 || x == 41 ? 13 : x < 41 ? 242 : 255;
        EXPECT_EQ(shown, expected) << x;
    }
}

TEST(DisplayColour, NeighbouringIdsAreToldApart)
{
    std::set<std::array<int, 3>> seen;
    double closest = 1e9, darkest = 1e9;
    glm::vec3 before(0);
    for (int id = 0; id < 1000; ++id) {
        const glm::vec3 c = shared::displayId(static_cast<float>(id));
        seen.insert({int(c.x * 255), int(c.y * 255), int(c.z * 255)});
        if (id > 0) closest = std::min(closest, double(glm::distance(c, before)));
        darkest = std::min(darkest, lightness(c));
        before = c;
    }
    EXPECT_GT(seen.size(), 990u);
    EXPECT_GT(darkest, 15);
    EXPECT_GT(closest, 0.002);
    EXPECT_EQ(shared::displayId(-1), glm::vec3(0));
}

TEST(Display, WhatIsStretchedBeforehandLooksTheSame)
{
    for (const glm::uvec2 size : {glm::uvec2(13, 9), glm::uvec2(64, 36), glm::uvec2(7, 5)}) {
        const Image small = randomImage(7, 5, 3, 3, false);
        const Image large = core::stretched(small, size);
        ASSERT_EQ(glm::uvec2(large.width, large.height), size);
        const DisplaySettings settings = settingsOf(shared::kShowRadiance, size.x, size.y);
        EXPECT_EQ(core::displayImage(&large, nullptr, settings),
                  core::displayImage(&small, nullptr, settings));
    }
}

}  // namespace

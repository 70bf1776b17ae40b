// Edges of coarse pictures, enlarged: lines where steps are, as they can be told beforehand.
#include "app/pictures/edge_cuts.h"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "app/gpu/window/display.h"
#include "app/pictures/preview_shading.h"
#include "core/image/display.h"
#include "core/methods/first_hits.h"

namespace {

using Labels = std::function<int(glm::ivec2)>;

constexpr int kSide = 24, kTimes = 8;  // pixels of a picture, of the window for each of them

/// First hits of a picture whose pixels are of such surfaces.
core::Image guideTo(const Labels& labels)
{
    core::Aovs aovs = core::emptyAovs(kSide, kSide);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            *aovs.depth.at(x, y) = 1;
            aovs.normal.at(x, y)[2] = 1;
            aovs.ids.at(x, y)[1] = static_cast<float>(labels({x, y}));
        }
    return app::surfaceGuide(aovs);
}

shared::DisplaySettings preview()
{
    shared::DisplaySettings s{};
    s.width = s.height = kSide * kTimes;
    s.show = shared::kShowPreview;
    s.tone = shared::kToneLinear;
    return s;
}

/// What is red in the window where a surface's red is `red` of its pixels.
std::vector<int> shown(const Labels& labels, const std::function<float(glm::ivec2)>& red)
{
    core::Image a(kSide, kSide, 3);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) *a.at(x, y) = red({x, y});
    const core::Image guide = guideTo(labels);
    const std::vector<uint8_t> bytes = core::displayImage(&a, &guide, preview());
    std::vector<int> result;
    for (size_t i = 0; i < bytes.size(); i += 4) result.push_back(bytes[i]);
    return result;
}

std::vector<int> shown(const Labels& labels)
{
    return shown(labels, [&](glm::ivec2 p) { return static_cast<float>(labels(p)); });
}

size_t windowPixel(glm::ivec2 p)
{
    return size_t(p.y * kSide * kTimes + p.x);
}

int divided(int a, int b)  // downwards
{
    return a >= 0 ? a / b : -((b - 1 - a) / b);
}

/// Turned and mirrored in all eight ways.
glm::ivec2 turned(glm::ivec2 p, int way, int last)
{
    if ((way & 1) != 0) p.x = last - p.x;
    if ((way & 2) != 0) p.y = last - p.y;
    return (way & 4) != 0 ? glm::ivec2(p.y, p.x) : p;
}

TEST(EdgeCuts, EdgesAslantAreStraightLines)
{
    for (const int run : {1, 2, 3, 4, 5, 6, 7, 11, 15})
        for (int way = 0; way < 8; ++way) {
            const int start = run > 7 ? 4 : 12;  // of a step that is in the picture whole
            const auto lower = [&](glm::ivec2 p) { return divided(p.x - start, run) <= p.y - 12; };
            const std::vector<int> pixels =
                shown([&](glm::ivec2 p) { return lower(turned(p, way, kSide - 1)) ? 1 : 0; });
            int far = 0, between = 0;
            // At the picture's rim it is not known how an edge goes on.
            const int rim = (run > 7 ? 0 : 8) * kTimes, end = kSide * kTimes - rim;
            for (int y = rim; y < end; ++y)
                for (int x = rim; x < end; ++x) {
                    const glm::ivec2 p = turned({x, y}, way, kSide * kTimes - 1);
                    const glm::dvec2 at =
                        (glm::dvec2(p) + 0.5) / double(kTimes) - glm::dvec2(start, 12);
                    // Steps are at 0, run, 2 run, ...; the line leads through their middles.
                    if (run > 7 && std::abs(at.x - 0.5 * run) >= 0.5 * run) continue;
                    const double below =
                        kTimes * (at.y - (at.x / run - 0.5)) * run / std::hypot(run, 1);
                    const double expected = 255 * std::clamp(0.5 + below, 0.0, 1.0);
                    const int is = pixels[windowPixel({x, y})];
                    between += is > 0 && is < 255 ? 1 : 0;
                    far += std::abs(is - expected) > 1 ? 1 : 0;
                }
            EXPECT_EQ(far, 0) << "run " << run << " way " << way;
            EXPECT_GT(between, 10) << "smooth";
        }
}

/// How much of a pixel lies below a line through `through` that rises by one in `run`.
double areaBelow(glm::ivec2 p, glm::dvec2 through, int run)
{
    constexpr int kParts = 32;
    int below = 0;
    for (int i = 0; i < kParts * kParts; ++i) {
        const glm::dvec2 at =
            glm::dvec2(p) + (glm::dvec2(i % kParts, i / kParts) + 0.5) / double(kParts);
        below += at.y - through.y > (at.x - through.x) / run ? 1 : 0;
    }
    return below / double(kParts * kParts);
}

TEST(EdgeCuts, InPicturesOfTheWindowsSizeEdgesAreSmoothByArea)
{
    for (const int run : {1, 2, 3, 5, 7}) {
        const auto lower = [&](glm::ivec2 p) { return divided(p.x - 12, run) <= p.y - 12 ? 1 : 0; };
        core::Image a(kSide, kSide, 3);
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                *a.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) =
                    static_cast<float>(lower({x, y}));
        const core::Image guide = guideTo(lower);
        shared::DisplaySettings s = preview();
        s.width = s.height = kSide;
        const std::vector<uint8_t> bytes = core::displayImage(&a, &guide, s);
        for (int y = 8; y < 16; ++y)
            for (int x = 8; x < 16; ++x)
                EXPECT_NEAR(bytes[4 * size_t(y * kSide + x)] / 255.0,
                            areaBelow({x, y}, {12 + 0.5 * run, 12}, run), 0.06)
                    << "run " << run << " at " << x << " " << y;
    }
}

TEST(EdgeCuts, AtTheRimNothingIsReadFromBeside)
{
    // Rings around a corner: edges of all directions meet the rim.
    const auto rings = [](glm::ivec2 p) {
        return static_cast<int>(glm::length(glm::dvec2(p) - glm::dvec2(-3, 27)) / 2.3) % 2;
    };
    const core::Image guide = guideTo(rings);
    const shared::DisplaySettings s = core::displaySizes(preview(), kSide * kTimes, kSide * kTimes,
                                                         {kSide, kSide, 3}, {kSide, kSide, 1});
    for (uint32_t y = 0; y < s.height; ++y)
        for (uint32_t x = 0; x < s.width; ++x) {
            glm::uvec4 pixels;
            glm::vec4 weights;
            const auto alike = static_cast<uint32_t>(*guide.at(x / kTimes, y / kTimes));
            shared::displayCorners(s, x, y, alike, pixels, weights);
            for (int i = 0; i < 4; ++i) {
                ASSERT_LT(pixels[i], uint32_t(kSide * kSide)) << x << " " << y;
                const glm::ivec2 d = glm::abs(glm::ivec2(pixels[i] % kSide, pixels[i] / kSide) -
                                              glm::ivec2(x, y) / kTimes);
                ASSERT_LE(std::max(d.x, d.y), 1) << x << " " << y;
            }
        }
}

/// Pixels of the picture that are not of one colour, their own.
int cutPixels(const Labels& labels)
{
    const std::vector<int> pixels = shown(labels);
    int cut = 0;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            bool whole = true;
            for (int i = 0; i < kTimes * kTimes; ++i) {
                const glm::ivec2 p(x * kTimes + i % kTimes, y * kTimes + i / kTimes);
                whole = whole && pixels[windowPixel(p)] == 255 * labels({x, y});
            }
            cut += whole ? 0 : 1;
        }
    return cut;
}

TEST(EdgeCuts, EdgesAlongRowsAndColumnsAndTheirCornersStay)
{
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p.x > 9 ? 1 : 0; }), 0);
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p.y > 9 ? 1 : 0; }), 0);
    const auto box = [](glm::ivec2 p) {
        return p.x > 9 && p.y > 9 && p.x < 16 && p.y < 14 ? 1 : 0;
    };
    EXPECT_EQ(cutPixels(box), 0);
    EXPECT_EQ(cutPixels([&](glm::ivec2 p) { return 1 - box(p); }), 0);
    EXPECT_GT(cutPixels([](glm::ivec2 p) { return p.x > p.y ? 1 : 0; }), 20) << "others do not";
}

TEST(EdgeCuts, LinesOfOnePixelAreKept)
{
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p.x == 9 ? 1 : 0; }), 0);
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p.x == p.y ? 1 : 0; }), 0);
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p.x + p.y == 20 ? 1 : 0; }), 0);
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p.y == p.x / 4 + 8 ? 1 : 0; }), 0);
    EXPECT_EQ(cutPixels([](glm::ivec2 p) { return p == glm::ivec2(9, 9) ? 1 : 0; }), 0);
}

TEST(EdgeCuts, BeyondACutIsWhatIsAcrossTheEdge)
{
    const auto lower = [](glm::ivec2 p) { return p.y - 8 >= divided(p.x, 3) ? 1 : 0; };
    const auto ramp = [&](glm::ivec2 p) {
        return lower(p) == 1 ? 0.05f * static_cast<float>(p.x % 12) : 1.0f;
    };
    const std::vector<int> pixels = shown(lower, ramp);
    int beyond = 0;
    for (int y = 8; y < 12 * kTimes; ++y)
        for (int x = 4 * kTimes; x < 11 * kTimes; ++x) {
            const int is = pixels[windowPixel({x, y})];
            const glm::dvec2 at = (glm::dvec2(x, y) + 0.5) / double(kTimes);
            const double below = kTimes * (at.y - 8 - (at.x / 3 - 0.5)) * 3 / std::hypot(3, 1);
            if (below < 0.5 || lower({x / kTimes, y / kTimes}) == 1) continue;
            ++beyond;
            const int across = pixels[windowPixel({x, 20 * kTimes})];
            EXPECT_NEAR(is, across, 1) << x << " " << y << ": smooth as it is there";
        }
    EXPECT_GT(beyond, 20);
}

TEST(EdgeCuts, DevicesShowTheSame)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(0, 1);
    core::Image a(kSide, kSide, 3);
    for (float& v : a.pixels) v = unit(random);
    const auto rings = [](glm::ivec2 p) {
        return static_cast<int>(glm::length(glm::dvec2(p) - glm::dvec2(7, 9)) / 3.7) % 3;
    };
    const core::Image guide = guideTo(rings);
    uint32_t cuts = 0;
    for (const float v : guide.pixels) cuts += v >= 512 ? 1u : 0u;
    EXPECT_GT(cuts, 60u);
    gpu::Device device({.validation = true});
    gpu::Display display(device);
    shared::DisplaySettings s = preview();
    s.width = 77;  // no multiple of the picture's
    display.setImage(0, &a);
    display.setImage(1, &guide);
    display.setSize(s.width, s.height);
    device.submit([&](VkCommandBuffer c) { display.record(c, s, false); });
    const std::vector<uint8_t> cpu = core::displayImage(&a, &guide, s);
    std::vector<uint8_t> gpu(cpu.size());
    display.output().read(std::as_writable_bytes(std::span(gpu)));
    size_t far = 0;
    for (size_t i = 0; i < cpu.size(); ++i)
        far += std::abs(int(cpu[i]) - int(gpu[i])) > 1 ? 1u : 0u;
    EXPECT_EQ(far, 0u);
}

}  // namespace

// Radiance pictures: every packing and orientation gives the values that the format defines; what
// is cut off, damaged or too large is refused (B46, B89).
#include "core/image/hdr_file.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "tests/support/files/hdr_fixture.h"
#include "tests/support/files/picture_bytes.h"

namespace {

using namespace tests;

std::string hdrProblem(const Bytes& bytes, const core::ImageGuards& guards = {})
{
    const core::DecodedImage decoded = core::decodeHdr(bytes, guards);
    EXPECT_NE(decoded.problem.empty(), decoded.image.pixels.empty());
    return decoded.problem;
}

std::vector<float> valuesOf(const core::RawImage& image)
{
    std::vector<float> values(image.pixels.size() / sizeof(float));
    std::memcpy(values.data(), image.pixels.data(), image.pixels.size());
    return values;
}

/// Pixels with runs of all lengths; none is (1, 1, 1), which the old packing gives a meaning to.
std::vector<uint8_t> somePixels(size_t count, uint32_t seed)
{
    std::mt19937 random(seed);
    std::vector<uint8_t> rgbe;
    while (rgbe.size() < 4 * count) {
        const size_t run = random() % 3 == 0 ? 1 + random() % 400 : 1;
        const uint8_t pixel[] = {uint8_t(128 + random() % 128), uint8_t(random()),
                                 uint8_t(random()), uint8_t(random())};
        for (size_t i = 0; i < run && rgbe.size() < 4 * count; ++i)
            rgbe.insert(rgbe.end(), std::begin(pixel), std::end(pixel));
    }
    return rgbe;
}

/// By the definition, in double.
std::vector<float> valuesFrom(const std::vector<uint8_t>& rgbe)
{
    std::vector<float> values;
    for (size_t i = 0; i < rgbe.size(); i += 4)
        for (size_t c = 0; c < 3; ++c)
            values.push_back(rgbe[i + 3] == 0
                                 ? 0.0f
                                 : float(std::ldexp(double(rgbe[i + c]), rgbe[i + 3] - 136)));
    return values;
}

TEST(HdrFile, EveryPackingGivesTheSameValues)
{
    for (const uint32_t width : {1u, 7u, 8u, 128u, 130u, 1000u, 32767u, 32768u}) {
        const std::vector<uint8_t> rgbe = somePixels(3 * width, width);
        const std::string sizes = "-Y 3 +X " + std::to_string(width);
        core::ImageGuards guards;
        guards.maxSize = 40000;
        for (const HdrPacking packing : {HdrPacking::none, HdrPacking::old, HdrPacking::lines}) {
            if (packing == HdrPacking::lines && (width < 8 || width > 32767)) continue;
            const auto decoded = core::decodeHdr(makeHdr(sizes, width, rgbe, packing), guards);
            ASSERT_EQ(decoded.problem, "") << width << ' ' << int(packing);
            EXPECT_EQ(decoded.image.width, width);
            EXPECT_EQ(decoded.image.height, 3u);
            EXPECT_EQ(decoded.image.channels, 3u);
            EXPECT_TRUE(valuesOf(decoded.image) == valuesFrom(rgbe)) << width << int(packing);
        }
    }
}

TEST(HdrFile, EveryExponent)
{
    std::vector<uint8_t> rgbe;
    for (int e = 0; e < 256; ++e) rgbe.insert(rgbe.end(), {255, 128, 1, uint8_t(e)});
    const auto decoded = core::decodeHdr(makeHdr("-Y 1 +X 256", 256, rgbe, HdrPacking::lines), {});
    ASSERT_EQ(decoded.problem, "");
    EXPECT_TRUE(valuesOf(decoded.image) == valuesFrom(rgbe));
}

TEST(HdrFile, OrientationsAreTurnedUpright)
{
    // Mantissas of the exponent 136 are the values themselves: the upright picture is 1 2 3 / 4
    // 5 6.
    const auto read = [](const std::string& sizes, uint32_t width,
                         const std::vector<uint8_t>& red) {
        std::vector<uint8_t> rgbe;
        for (const uint8_t value : red) rgbe.insert(rgbe.end(), {value, 0, 200, 136});
        const auto decoded = core::decodeHdr(makeHdr(sizes, width, rgbe, HdrPacking::none), {});
        EXPECT_EQ(decoded.problem, "") << sizes;
        EXPECT_EQ(decoded.image.width, 3u) << sizes;
        std::vector<float> values = valuesOf(decoded.image), reds;
        for (size_t i = 0; i < values.size(); i += 3) reds.push_back(values[i]);
        return reds;
    };
    const std::vector<float> upright{1, 2, 3, 4, 5, 6};
    EXPECT_EQ(read("-Y 2 +X 3", 3, {1, 2, 3, 4, 5, 6}), upright);
    EXPECT_EQ(read("-Y 2 -X 3", 3, {3, 2, 1, 6, 5, 4}), upright);
    EXPECT_EQ(read("+Y 2 +X 3", 3, {4, 5, 6, 1, 2, 3}), upright);
    EXPECT_EQ(read("+Y 2 -X 3", 3, {6, 5, 4, 3, 2, 1}), upright);
    EXPECT_EQ(read("+X 3 -Y 2", 2, {1, 4, 2, 5, 3, 6}), upright);
    EXPECT_EQ(read("+X 3 +Y 2", 2, {4, 1, 5, 2, 6, 3}), upright);
    EXPECT_EQ(read("-X 3 -Y 2", 2, {3, 6, 2, 5, 1, 4}), upright);
    EXPECT_EQ(read("-X 3 +Y 2", 2, {6, 3, 5, 2, 4, 1}), upright);
}

TEST(HdrFile, EveryCutIsRefused)
{
    for (const HdrPacking packing : {HdrPacking::none, HdrPacking::old, HdrPacking::lines}) {
        const Bytes whole = makeHdr("-Y 4 +X 20", 20, somePixels(80, 5), packing);
        ASSERT_EQ(hdrProblem(whole), "");
        for (size_t size = 0; size < whole.size(); ++size)
            EXPECT_NE(hdrProblem({whole.begin(), whole.begin() + ptrdiff_t(size)}), "") << size;
    }
}

TEST(HdrFile, RunsThatLeaveTheirLineAreRefused)
{
    const auto picture = [](const std::string& line) {
        return bytesOf("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n" + line +
                       std::string(64, '\7'));
    };
    const auto problem = [&](const std::string& line) { return hdrProblem(picture(line)); };
    using std::string;
    EXPECT_EQ(problem(string("\2\2\0\x8\x88\1\x88\1\x88\1\x88\1", 12)), "");
    for (const string& line :
         {string("\2\2\0\x8\x89\1", 6), string("\2\2\0\x8\0\1", 6), string("\2\2\0\x8\x9", 5),
          string("\2\2\0\x8\x84\1\x85\1", 8), string("\1\1\1\1", 4), string("\7\7\7\7\1\1\1\x8", 8),
          string("\7\7\7\7\1\1\1\0\1\1\1\1", 12)})
        EXPECT_EQ(problem(line), "is damaged: a run leaves its line");
    string endless("\7\7\7\7", 4);
    for (int i = 0; i < 9; ++i) endless += string("\1\1\1\0", 4);
    EXPECT_EQ(problem(endless), "is damaged: a run leaves its line");
    EXPECT_EQ(problem(string("\2\2\0\x9", 4)),
              "is damaged: a line has another length than the image");
}

TEST(HdrFile, HeadersAreCheckedBeforeAnythingIsAllocated)
{
    const auto problem = [](const std::string& text) { return hdrProblem(bytesOf(text)); };
    const std::string start = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
    EXPECT_NE(problem(start + "-Y 65536 +X 65536\n").find("65536 x 65536 pixels, allowed are"),
              std::string::npos);
    EXPECT_NE(problem(start + "-Y 16000 +X 16000\n").find("too much for a file of"),
              std::string::npos);
    EXPECT_NE(problem(start + "-Y 0 +X 5\n").find("has no pixels"), std::string::npos);
    EXPECT_NE(problem(start + "-Y 18446744073709551615 +X 5\n")
                  .find("5 x 1.84467440737096e+19 pixels, allowed"),
              std::string::npos);
    for (const std::string sizes :
         {"", "-Y 5\n", "-Y 5 +Y 5\n", "-Y 5 +X 5 7\n", "-Y -5 +X 5\n", "*Y 5 +X 5\n", "-Y5+X5\n",
          "-Y 99999999999999999999 +X 5\n", "-Y 5 +X 5"})
        EXPECT_NE(problem(start + sizes).find("no size"), std::string::npos) << sizes;
    EXPECT_NE(problem("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n1111").find("xyze"),
              std::string::npos);
    EXPECT_NE(problem("#?RADIANCE\n" + std::string(100000, 'a') + "\n\n").find("does not end"),
              std::string::npos);
    std::string many = "#?RADIANCE\n";
    for (int i = 0; i < 30000; ++i) many += "A=b\n";
    EXPECT_NE(problem(many + "\n-Y 1 +X 1\n1111").find("does not end"), std::string::npos);
    EXPECT_EQ(problem("P6 1 1"), "is no Radiance picture");
}

TEST(HdrFile, WhatOtherProgramsWriteInHeaders)
{
    const std::string pixel("\x80\x80\x80\x81", 4);
    for (const std::string header :
         {"#?RADIANCE\n\n-Y 1 +X 1\n", "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n",
          "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n",
          "#?RADIANCE\n# a comment\nEXPOSURE=4\nPRIMARIES=0 0 0 0 0 0 0 0\n\n-Y   1   +X  1 \n"}) {
        const auto decoded = core::decodeHdr(bytesOf(header + pixel), {});
        ASSERT_EQ(decoded.problem, "") << header;
        EXPECT_EQ(valuesOf(decoded.image), std::vector<float>(3, 1.0f));
    }
}

TEST(HdrFile, DamageNeverDoesMoreThanRefuse)
{
    const Bytes good = makeHdr("-Y 9 +X 40", 40, somePixels(360, 3), HdrPacking::lines);
    std::mt19937 random(11);
    int refusals = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        Bytes damaged = good;
        for (int i = 0; i < 1 + trial % 3; ++i)
            damaged[random() % damaged.size()] = std::byte(random() & 255u);
        refusals += core::decodeHdr(damaged, {}).problem.empty() ? 0 : 1;
    }
    EXPECT_GT(refusals, 300);
}

TEST(HdrFile, ReadingCanBeStopped)
{
    std::stop_source source;
    source.request_stop();
    const Bytes good = makeHdr("-Y 9 +X 40", 40, somePixels(360, 3), HdrPacking::lines);
    EXPECT_NE(core::decodeHdr(good, {}, source.get_token()).problem.find("stopped"),
              std::string::npos);
}

}  // namespace

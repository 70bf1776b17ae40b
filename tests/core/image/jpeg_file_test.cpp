// JPEG through libjpeg-turbo: profiles are not read, sizes are judged before pixels are allocated,
// runs over the whole image are counted (B89-B91).
#include "core/image/jpeg_file.h"

#include <gtest/gtest.h>

#include "tests/support/files/picture_bytes.h"
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using namespace tests;

Bytes smallJpeg()
{
    return test::encodeImage("jpg", 16, 16, 1, std::vector<uint8_t>(256, 119));
}

// Of the frame's height in what progressiveJpeg makes: behind start, quantization and depth.
constexpr size_t kSizeAt = 2 + 69 + 5;

std::string jpegProblem(const Bytes& bytes, const core::ImageGuards& guards = {})
{
    const core::DecodedImage decoded = core::decodeJpeg(bytes, guards);
    EXPECT_NE(decoded.problem.empty(), decoded.image.pixels.empty());
    return decoded.problem;
}

TEST(JpegFile, DamagedProfilesAreNotRead)
{
    std::string icc(3500, '\x5a');
    icc.replace(36, 4, "acsp");
    for (const Bytes& profile : {Bytes{}, bytesOf(icc), Bytes(128, std::byte{0xff})}) {
        const core::DecodedImage decoded =
            core::decodeJpeg(behindStart(smallJpeg(), jpegProfile(profile)), {});
        EXPECT_EQ(decoded.problem, "");
        EXPECT_EQ(decoded.damage, "");
        EXPECT_EQ(decoded.image.width, 16u);
        EXPECT_EQ(static_cast<int>(decoded.image.pixels.at(77)), 119);
    }
}

TEST(JpegFile, SizesAreJudgedBeforeAnythingIsAllocated)
{
    const auto ofSide = [](int side) {
        Bytes jpeg = progressiveJpeg(8, 8, 0);
        for (const size_t at : {kSizeAt, kSizeAt + 2}) {  // height, width
            jpeg[at] = static_cast<std::byte>(side >> 8);
            jpeg[at + 1] = static_cast<std::byte>(side & 0xff);
        }
        return jpeg;
    };
    EXPECT_EQ(jpegProblem(ofSide(8)), "");
    EXPECT_NE(jpegProblem(ofSide(65500)).find("allowed are 16384"), std::string::npos);
    EXPECT_NE(jpegProblem(ofSide(16000)).find("too much for a file"), std::string::npos);
}

TEST(JpegFile, ProgressiveImagesCountTheirCoefficients)
{
    uint64_t asked = 0;
    core::ImageGuards guards;
    guards.beforeAllocation = [&](uint64_t, uint64_t bytes) { asked = bytes; };
    EXPECT_EQ(jpegProblem(progressiveJpeg(64, 64, 3), guards), "");
    EXPECT_GE(asked, 64u * 64 + 2 * 64 * 64);
    EXPECT_EQ(jpegProblem(smallJpeg(), guards), "");
    EXPECT_EQ(asked, 256u);
}

TEST(JpegFile, RunsOverTheImageAreCounted)
{
    EXPECT_EQ(jpegProblem(progressiveJpeg(64, 64, 90)), "");
    EXPECT_NE(jpegProblem(progressiveJpeg(64, 64, 30000)).find("too many scans"),
              std::string::npos);
}

TEST(JpegFile, DamagedPixelsAreShownAsFarAsTheyGo)
{
    std::vector<uint8_t> noise(64 * 64);
    for (size_t i = 0; i < noise.size(); ++i)
        noise[i] = static_cast<uint8_t>(i * 2654435761u >> 13);
    Bytes jpeg = test::encodeImage("jpg", 64, 64, 1, noise);
    jpeg.resize(jpeg.size() / 2);
    const core::DecodedImage decoded = core::decodeJpeg(jpeg, {});
    EXPECT_EQ(decoded.problem, "");
    EXPECT_NE(decoded.damage, "");
}

TEST(JpegFile, EveryByteChangedEndsInAnImageOrAReason)
{
    const Bytes jpeg = smallJpeg();
    core::ImageGuards guards;
    guards.maxBytes = 1 << 20;
    for (size_t i = 3; i < jpeg.size(); ++i)
        for (const unsigned flip : {0x01u, 0x80u, 0xffu}) {
            Bytes changed = jpeg;
            changed[i] ^= static_cast<std::byte>(flip);
            jpegProblem(changed, guards);
        }
    for (size_t size = 3; size < jpeg.size(); ++size)
        jpegProblem({jpeg.begin(), jpeg.begin() + static_cast<ptrdiff_t>(size)}, guards);
}

TEST(JpegFile, StopsWhenAsked)
{
    std::stop_source source;
    source.request_stop();
    for (const Bytes& jpeg : {smallJpeg(), progressiveJpeg(64, 64, 9)})
        EXPECT_NE(core::decodeJpeg(jpeg, {}, source.get_token()).problem.find("stopped"),
                  std::string::npos);
}

}  // namespace

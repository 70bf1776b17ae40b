// PNG through libpng: what is around the pixels is not read, what is damaged is refused (B89).
#include "core/image/png_file.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/files/picture_bytes.h"
#include "tests/support/scenes/gltf_fixture.h"

namespace {

using namespace tests;

const std::vector<uint8_t> kFourColours{0, 10, 128, 255, 1, 2, 7, 8, 9, 200, 100, 50};

Bytes smallPng()
{
    return test::encodeImage("png", 2, 2, 3, kFourColours);
}

void expectPixels(const core::DecodedImage& decoded)
{
    EXPECT_EQ(decoded.problem, "");
    EXPECT_EQ(decoded.damage, "");
    ASSERT_EQ(decoded.image.pixels.size(), kFourColours.size());
    for (size_t i = 0; i < kFourColours.size(); ++i)
        EXPECT_EQ(static_cast<uint8_t>(decoded.image.pixels[i]), kFourColours[i]);
}

TEST(PngFile, ProfilesAndTextsAreNotRead)
{
    expectPixels(core::decodePng(smallPng(), {}));
    const Bytes name = bytesOf(std::string("profile\0\0", 9));
    const Bytes bomb(1 << 20, std::byte{0});  // would be decompressed
    for (const Bytes& chunk :
         {pngChunk("iCCP", name + Bytes(3500, std::byte{0x5a})), pngChunk("iCCP", {}),
          pngChunk("zTXt", name + bomb), pngChunk("iTXt", bomb), pngChunk("tEXt", bomb),
          pngChunk("eXIf", Bytes(9, std::byte{0xff})), pngChunk("gAMA", bigEndian(0)),
          pngChunk("cHRM", Bytes(32, std::byte{0xff})), pngChunk("sPLT", name),
          pngChunk("vpAg", bomb)})
        expectPixels(core::decodePng(behindHeader(smallPng(), chunk), {}));
}

TEST(PngFile, DamageIsRefusedWithItsReason)
{
    const auto problem = [](const Bytes& bytes) { return core::decodePng(bytes, {}).problem; };
    const Bytes png = smallPng();
    for (size_t size = 0; size < png.size(); ++size)
        EXPECT_NE(problem({png.begin(), png.begin() + static_cast<ptrdiff_t>(size)}), "") << size;
    Bytes changed = png;
    changed[changed.size() - 20] ^= std::byte{1};  // in the checksum of the pixels
    EXPECT_NE(problem(changed).find("is damaged"), std::string::npos);
    const Bytes noHeader(png.begin() + 33, png.end());
    const Bytes signature(png.begin(), png.begin() + 8);
    EXPECT_EQ(problem(signature + noHeader), "is damaged: no header");
    EXPECT_NE(problem(behindHeader(png, pngChunk("IHDR", Bytes(13)))), "");
    EXPECT_NE(problem(behindHeader(png, pngChunk("CrIT", {}))), "");  // critical and unknown
    EXPECT_EQ(problem(signature +
                      pngChunk("IHDR", bigEndian(1) + bigEndian(1) +
                                           bytesOf(std::string("\x20\x07\0\0\0", 5))) +
                      pngChunk("IEND", {}))
                  .substr(0, 11),
              "is damaged:");
}

TEST(PngFile, EveryByteChangedEndsInAnImageOrAReason)
{
    const Bytes png = behindHeader(smallPng(), pngChunk("tEXt", bytesOf("a text")));
    for (size_t i = 8; i < png.size(); ++i)
        for (const unsigned flip : {0x01u, 0x80u, 0xffu}) {
            Bytes changed = png;
            changed[i] ^= static_cast<std::byte>(flip);
            core::ImageGuards guards;
            guards.maxBytes = 1 << 20;
            const core::DecodedImage decoded = core::decodePng(changed, guards);
            EXPECT_NE(decoded.problem.empty(), decoded.image.pixels.empty()) << i;
        }
}

TEST(PngFile, StopsWhenAsked)
{
    std::stop_source source;
    source.request_stop();
    const core::DecodedImage decoded = core::decodePng(smallPng(), {}, source.get_token());
    EXPECT_NE(decoded.problem.find("stopped"), std::string::npos);
}

TEST(PngFile, TextsAreFoundWithoutDecompressing)
{
    const Bytes text = pngChunk("tEXt", bytesOf(std::string("key\0value", 9))) +
                       pngChunk("tEXt", bytesOf("no end of the key")) +
                       pngChunk("zTXt", bytesOf(std::string("other\0\0zzz", 10)));
    const auto texts = core::pngText(behindHeader(smallPng(), text));
    EXPECT_EQ(texts, (std::map<std::string, std::string>{{"key", "value"}}));
    EXPECT_TRUE(core::pngText(bytesOf("no PNG")).empty());
}

TEST(PngFile, WhatIsWrittenIsReadAgain)
{
    const std::string written = core::encodeGreyPng(4, kFourColours);
    const core::DecodedImage decoded = core::decodePng(bytesOf(written), {});
    EXPECT_EQ(decoded.image.width, 4u);
    EXPECT_EQ(decoded.image.height, 3u);
    EXPECT_EQ(decoded.image.channels, 1u);
    expectPixels(decoded);
}

}  // namespace

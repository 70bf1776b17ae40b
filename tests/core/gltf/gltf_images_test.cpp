// Images: what is decoded to which values, and what is repaired (B39-B45, B47-B49, N18).
#include "tests/support/scenes/gltf_fixture.h"

#include <cmath>

#include <glm/gtc/packing.hpp>

#include "core/gltf/texture_image.h"

namespace {

using test::Json;

using Bytes = std::vector<std::byte>;

glm::vec4 floats(const core::Texel& t)
{
    return {glm::unpackHalf1x16(t.r), glm::unpackHalf1x16(t.g), glm::unpackHalf1x16(t.b),
            glm::unpackHalf1x16(t.a)};
}

/// The definition of sRGB (IEC 61966-2-1), in double.
double linearOf(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

void expectTexel(const core::Texture& texture, uint32_t x, uint32_t y, const glm::dvec4& expected)
{
    const glm::vec4 got = floats(texture.texels.at(size_t{y} * texture.width + x));
    for (int k = 0; k < 4; ++k)
        EXPECT_NEAR(got[k], expected[k], std::max(6e-8, expected[k] / 2048))
            << "texel " << x << "," << y << " channel " << k;
}

core::Texture decode(const Bytes& bytes, bool color)
{
    const core::DecodedImage decoded = core::decodeImage(bytes, {});
    EXPECT_EQ(decoded.problem, "");
    uint64_t repaired = 0;
    core::Texture texture = core::makeTexture(decoded.image, color, repaired);
    EXPECT_EQ(repaired, 0u);
    return texture;
}

// --- values

TEST(GltfImages, EightBitColourIsDecodedFromSrgbButNotItsAlpha)
{
    const Bytes png = test::encodeImage(
        "png", 2, 2, 4,
        std::vector<uint8_t>{0, 10, 128, 255, 255, 1, 2, 128, 7, 8, 9, 0, 200, 100, 50, 1});
    const core::Texture color = decode(png, true), data = decode(png, false);
    ASSERT_EQ(color.width, 2u);
    ASSERT_EQ(color.height, 2u);
    expectTexel(color, 0, 0, {linearOf(0), linearOf(10 / 255.0), linearOf(128 / 255.0), 1});
    expectTexel(color, 1, 0, {1, linearOf(1 / 255.0), linearOf(2 / 255.0), 128 / 255.0});
    expectTexel(color, 0, 1, {linearOf(7 / 255.0), linearOf(8 / 255.0), linearOf(9 / 255.0), 0});
    expectTexel(color, 1, 1,
                {linearOf(200 / 255.0), linearOf(100 / 255.0), linearOf(50 / 255.0), 1 / 255.0});
    expectTexel(data, 1, 1, {200 / 255.0, 100 / 255.0, 50 / 255.0, 1 / 255.0});
}

TEST(GltfImages, SixteenBitGreyAndGreyAlpha)
{
    const core::Texture grey16 =
        decode(test::encodeImage("png", 2, 1, 1, std::vector<uint16_t>{257, 40000}), false);
    expectTexel(grey16, 0, 0, {257 / 65535.0, 257 / 65535.0, 257 / 65535.0, 1});
    expectTexel(grey16, 1, 0, {40000 / 65535.0, 40000 / 65535.0, 40000 / 65535.0, 1});
    const core::Texture greyAlpha =
        decode(test::encodeImage("png", 1, 1, 2, std::vector<uint8_t>{188, 77}), true);
    expectTexel(greyAlpha, 0, 0,
                {linearOf(188 / 255.0), linearOf(188 / 255.0), linearOf(188 / 255.0), 77 / 255.0});
    const core::Texture rgb16 =
        decode(test::encodeImage("png", 1, 1, 3, std::vector<uint16_t>{1000, 30000, 65535}), true);
    expectTexel(rgb16, 0, 0, {linearOf(1000 / 65535.0), linearOf(30000 / 65535.0), 1, 1});
}

TEST(GltfImages, JpegInGreyAndColour)
{
    const core::Texture grey =
        decode(test::encodeImage("jpg", 8, 8, 1, std::vector<uint8_t>(64, 119)), false);
    expectTexel(grey, 3, 3, {119 / 255.0, 119 / 255.0, 119 / 255.0, 1});
    std::vector<uint8_t> pixels;
    for (int i = 0; i < 64; ++i) pixels.insert(pixels.end(), {200, 90, 30});
    const core::Texture color = decode(test::encodeImage("jpg", 8, 8, 3, pixels), false);
    const glm::vec4 texel = floats(color.texels[20]);
    EXPECT_NEAR(texel.r, 200 / 255.0, 3 / 255.0);
    EXPECT_NEAR(texel.g, 90 / 255.0, 3 / 255.0);
    EXPECT_NEAR(texel.b, 30 / 255.0, 3 / 255.0);
}

/// Bytes of a file as hexadecimal digits.
Bytes fromHex(const std::string& digits)
{
    Bytes bytes;
    for (size_t i = 0; i + 1 < digits.size(); i += 2)
        bytes.push_back(static_cast<std::byte>(std::stoi(digits.substr(i, 2), nullptr, 16)));
    return bytes;
}

TEST(GltfImages, JpegInCmykWithAdobesInvertedInks)
{
    // 8 x 8 pixels of the stored inks 230, 100, 50, 200, written with libjpeg at quality 100.
    const core::Texture texture =
        decode(fromHex("ffd8ffee000e41646f626500640000000000ffdb00430001010101010101010101010101010"
                       "101010101010101010101010101010101"
                       "010101010101010101010101010101010101010101010101010101010101010101ffc000140"
                       "800080008044311004d11005911004b11"
                       "00ffc4001500010100000000000000000000000000000a08ffc400141001000000000000000"
                       "00000000000000000ffda000e0443004d"
                       "0059004b00003f0066087c63c901ffd9"),
               false);
    ASSERT_EQ(texture.width, 8u);
    const glm::vec4 texel = floats(texture.texels[27]);
    EXPECT_NEAR(texel.r, 230 * 200 / 65025.0, 3 / 255.0);
    EXPECT_NEAR(texel.g, 100 * 200 / 65025.0, 3 / 255.0);
    EXPECT_NEAR(texel.b, 50 * 200 / 65025.0, 3 / 255.0);
    EXPECT_EQ(texel.a, 1.0f);
}

TEST(GltfImages, ProgressiveJpeg)
{
    // 8 x 8 pixels of 200, 90, 30, written with libjpeg at quality 100.
    const core::Texture texture =
        decode(fromHex("ffd8ffe000104a46494600010100000100010000ffdb0043000101010101010101010101010"
                       "101010101010101010101010101010101"
                       "0101010101010101010101010101010101010101010101010101010101010101010101ffdb0"
                       "043010101010101010101010101010101"
                       "010101010101010101010101010101010101010101010101010101010101010101010101010"
                       "1010101010101010101010101ffc20011"
                       "080008000803012200021101031101ffc400150001010000000000000000000000000000000"
                       "6ffc40014010100000000000000000000"
                       "000000000008ffda000c030100021003100000018f03b787ffc400141001000000000000000"
                       "00000000000000000ffda000801010001"
                       "05027fffc40014110100000000000000000000000000000000ffda0008010301013f017fffc"
                       "400141101000000000000000000000000"
                       "00000000ffda0008010201013f017fffc40014100100000000000000000000000000000000f"
                       "fda0008010100063f027fffc400141001"
                       "00000000000000000000000000000000ffda0008010100013f217fffda000c0301000200030"
                       "000001003ffc400141101000000000000"
                       "00000000000000000000ffda0008010301013f107fffc400141101000000000000000000000"
                       "00000000000ffda0008010201013f107f"
                       "ffc40014100100000000000000000000000000000000ffda0008010100013f107fffd9"),
               false);
    const glm::vec4 texel = floats(texture.texels.at(63));
    EXPECT_NEAR(texel.r, 200 / 255.0, 3 / 255.0);
    EXPECT_NEAR(texel.g, 90 / 255.0, 3 / 255.0);
    EXPECT_NEAR(texel.b, 30 / 255.0, 3 / 255.0);
}

/// A PNG as its specification (ISO 15948) defines it, with one stored deflate block. `lines`:
/// filter byte and packed samples per row; `palette` may be empty.
Bytes makePng(uint32_t width, uint32_t height, uint8_t depth, uint8_t colorType,
              const std::vector<uint8_t>& palette, const std::vector<uint8_t>& lines)
{
    std::vector<uint8_t> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const auto put = [](std::vector<uint8_t>& to, uint32_t value) {
        for (int shift = 24; shift >= 0; shift -= 8)
            to.push_back(static_cast<uint8_t>(value >> shift & 0xffu));
    };
    const auto chunk = [&](const char* name, const std::vector<uint8_t>& content) {
        put(png, static_cast<uint32_t>(content.size()));
        const size_t start = png.size();
        png.insert(png.end(), name, name + 4);
        png.insert(png.end(), content.begin(), content.end());
        uint32_t crc = 0xffffffffu;
        for (size_t i = start; i < png.size(); ++i) {
            crc ^= png[i];
            for (int k = 0; k < 8; ++k) crc = (crc & 1u) != 0 ? 0xedb88320u ^ crc >> 1 : crc >> 1;
        }
        put(png, ~crc);
    };
    std::vector<uint8_t> header;
    put(header, width);
    put(header, height);
    header.insert(header.end(), {depth, colorType, 0, 0, 0});
    chunk("IHDR", header);
    if (!palette.empty()) chunk("PLTE", palette);
    const auto size = static_cast<uint8_t>(lines.size());
    std::vector<uint8_t> data{0x78, 0x01, 0x01, size, 0, static_cast<uint8_t>(~size), 0xff};
    data.insert(data.end(), lines.begin(), lines.end());
    uint32_t a = 1, b = 0;  // Adler-32
    for (const uint8_t value : lines) {
        a = (a + value) % 65521;
        b = (b + a) % 65521;
    }
    put(data, b << 16 | a);
    chunk("IDAT", data);
    chunk("IEND", {});
    const std::span<const std::byte> bytes = std::as_bytes(std::span(png));
    return {bytes.begin(), bytes.end()};
}

TEST(GltfImages, PaletteAndFewBits)
{
    const core::Texture palette =
        decode(makePng(3, 1, 8, 3, {10, 20, 30, 200, 100, 50, 0, 0, 255}, {0, 1, 0, 2}), true);
    expectTexel(palette, 0, 0,
                {linearOf(200 / 255.0), linearOf(100 / 255.0), linearOf(50 / 255.0), 1});
    expectTexel(palette, 1, 0,
                {linearOf(10 / 255.0), linearOf(20 / 255.0), linearOf(30 / 255.0), 1});
    expectTexel(palette, 2, 0, {0, 0, 1, 1});
    const core::Texture bits = decode(makePng(4, 1, 1, 0, {}, {0, 0b01010000}), false);
    expectTexel(bits, 0, 0, {0, 0, 0, 1});
    expectTexel(bits, 1, 0, {1, 1, 1, 1});
    const core::Texture four = decode(makePng(2, 1, 4, 0, {}, {0, 0x3c}), false);
    expectTexel(four, 0, 0, {0.2, 0.2, 0.2, 1});
    expectTexel(four, 1, 0, {0.8, 0.8, 0.8, 1});
}

TEST(GltfImages, FloatsStayLinearAndAreSanitised)
{
    const float nan = std::nanf(""), infinity = HUGE_VALF;
    const Bytes exr = test::encodeImage(
        "exr", 4, 1, 3,
        std::vector<float>{0.5f, 2, 100, nan, 1, -1, infinity, 1e6f, 0, 0.25f, 0, 1});
    const core::DecodedImage decoded = core::decodeImage(exr, {});
    ASSERT_EQ(decoded.problem, "");
    uint64_t repaired = 0;
    const core::Texture texture = core::makeTexture(decoded.image, true, repaired);
    EXPECT_EQ(repaired, 4u);
    expectTexel(texture, 0, 0, {0.5, 2, 100, 1});
    expectTexel(texture, 1, 0, {0, 1, 0, 1});
    expectTexel(texture, 2, 0, {65504, 65504, 0, 1});
    expectTexel(texture, 3, 0, {0.25, 0, 1, 1});
    uint64_t repairedRadiance = 0;
    const std::vector<glm::vec4> radiance = core::makeRadiance(decoded.image, repairedRadiance);
    EXPECT_EQ(repairedRadiance, 3u);
    EXPECT_EQ(radiance[2].y, 1e6f) << "radiance has the range of a float";
}

TEST(GltfImages, RadianceFilesKeepTheirRange)
{
    const Bytes hdr =
        test::encodeImage("hdr", 2, 1, 3, std::vector<float>{0.25f, 0.5f, 1, 1024, 0, 2048});
    const core::DecodedImage decoded = core::decodeImage(hdr, {});
    ASSERT_EQ(decoded.problem, "");
    uint64_t repaired = 0;
    const std::vector<glm::vec4> texels = core::makeRadiance(decoded.image, repaired);
    EXPECT_NEAR(texels[0].x, 0.25, 0.01);
    EXPECT_NEAR(texels[1].z, 2048, 16);
}

TEST(GltfImages, OddSizes)
{
    EXPECT_EQ(decode(test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{1, 2, 3}), true)
                  .texels.size(),
              1u);
    EXPECT_EQ(
        decode(test::encodeImage("png", 1, 16384, 1, std::vector<uint8_t>(16384, 9)), true).height,
        16384u);
    EXPECT_EQ(
        decode(test::encodeImage("png", 16384, 1, 1, std::vector<uint8_t>(16384, 9)), true).width,
        16384u);
}

// --- refusals of the decoder

std::string imageProblem(const Bytes& bytes)
{
    const core::DecodedImage decoded = core::decodeImage(bytes, {});
    EXPECT_TRUE(decoded.image.pixels.empty() || decoded.problem.empty());
    return decoded.problem;
}

/// A PNG header of that size, followed by nothing that belongs to it.
Bytes pngHeader(uint32_t width, uint32_t height)
{
    return makePng(width, height, 8, 0, {}, {0, 5});
}

TEST(GltfImages, ImplausibleSizesAreRefusedBeforeAllocation)
{
    EXPECT_NE(imageProblem(pngHeader(30000, 30000)), "");
    EXPECT_NE(imageProblem(pngHeader(0x7fffffff, 0x7fffffff)), "");
    EXPECT_NE(imageProblem(pngHeader(0, 0)), "");
    EXPECT_NE(imageProblem(pngHeader(16000, 16000)).find("too much for a file of"),
              std::string::npos);
    EXPECT_NE(imageProblem(pngHeader(1, 20000)).find("allowed are 16384"), std::string::npos);
    const std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n";
    const std::span<const std::byte> bytes = test::bytesOf(hdr);
    EXPECT_NE(imageProblem({bytes.begin(), bytes.end()}), "");
    core::ImageGuards guards;
    guards.maxSize = 4;
    EXPECT_NE(
        core::decodeImage(test::encodeImage("png", 5, 1, 1, std::vector<uint8_t>(5, 0)), guards)
            .problem,
        "");
}

TEST(GltfImages, ForeignContentIsNotGuessed)
{
    for (const std::string content : {"P6\n100000 100000\n255\n", "GIF89a",
                                      "RIFF\x10\0\0\0WEBPVP8 ", "BM", "<svg/>", "", "\x89PN"}) {
        const std::span<const std::byte> bytes = test::bytesOf(content);
        EXPECT_NE(
            imageProblem({bytes.begin(), bytes.end()}).find("no PNG, JPEG, OpenEXR or Radiance"),
            std::string::npos);
    }
}

TEST(GltfImages, TruncationIsNoticed)
{
    std::vector<uint8_t> noise(64 * 64 * 3);
    for (size_t i = 0; i < noise.size(); ++i)
        noise[i] = static_cast<uint8_t>(i * 2654435761u >> 13);
    std::vector<float> noiseFloat(noise.begin(), noise.end());
    for (const Bytes& good : {test::encodeImage("png", 64, 64, 3, noise),
                              test::encodeImage("exr", 64, 64, 3, noiseFloat),
                              test::encodeImage("hdr", 64, 64, 3, noiseFloat)}) {
        ASSERT_EQ(imageProblem(good), "");
        for (const size_t keep : {good.size() / 2, good.size() / 4, size_t{40}, size_t{11}})
            EXPECT_NE(
                imageProblem({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(keep)}), "")
                << keep << " of " << good.size();
    }
}

TEST(GltfImages, ManyChannelsAreRefused)
{
    EXPECT_NE(imageProblem(test::encodeImage("exr", 2, 2, 64, std::vector<float>(256, 1)))
                  .find("64 channels"),
              std::string::npos);
}

// --- repairs in a document

test::Document damagedImage(const Json& image)
{
    test::Document document = test::texturedTriangle(test::bytesOf("rubbish that is no image"));
    if (!image.is_null()) document.json["images"][0] = image;
    return document;
}

TEST(GltfImages, BrokenImagesBecomeACheckerWithAWarning)
{
    for (const Json& image :
         {Json(), Json{{"bufferView", 55}}, Json{{"bufferView", -1}}, Json{{"bufferView", "x"}},
          Json{{"bufferView", 2}, {"uri", "a.png"}}, Json::object(), Json(5), Json{{"uri", 7}},
          Json{{"uri", "missing.png"}}, Json{{"uri", "data:image/png;base64,####"}},
          Json{{"uri", "http://example.org/a.png"}}}) {
        EXPECT_REPAIRED(scene, damagedImage(image), "IMAGE_UNUSABLE", "/images/0");
        ASSERT_EQ(scene->textures.size(), 1u);
        EXPECT_EQ(scene->textures[0].width, 8u);
        EXPECT_EQ(scene->textureUses.at(0).record.width, 8u);
        EXPECT_EQ(scene->materials.at(0).textures[shared::kTextureBaseColor], 0);
        EXPECT_EQ(scene->warnings.total(), 1u);
    }
}

TEST(GltfImages, OtherUsesOfABrokenImageAreLeftOut)
{
    test::Document document = damagedImage({});
    document.material()["emissiveFactor"] = {1, 1, 1};
    document.material()["emissiveTexture"]["index"] = 0;
    document.material()["normalTexture"]["index"] = 0;
    EXPECT_REPAIRED(scene, document, "IMAGE_UNUSABLE", "/images/0");
    const core::Material& material = scene->materials.at(0);
    EXPECT_GE(material.textures[shared::kTextureBaseColor], 0);
    EXPECT_EQ(material.textures[shared::kTextureEmissive], -1);
    EXPECT_EQ(material.textures[shared::kTextureNormal], -1);
    EXPECT_EQ(material.data.emissive, glm::vec3(0))
        << "an unknown pattern must not shine everywhere";
    const shared::Material packed = core::makeWorld(scene)->materials[0];
    EXPECT_EQ(packed.textures0, 1u) << "base colour is the first use";
    EXPECT_EQ(packed.textures1, 0u);
}

TEST(GltfImages, UnusedImagesAreNotTouched)
{
    test::Document document = test::triangle();
    document.json["images"] = Json::array({{{"uri", "../../etc/passwd"}}, 7});
    document.json["textures"] = Json::array({{{"source", 0}}});
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    EXPECT_TRUE(scene->textures.empty());
}

TEST(GltfImages, OneImageInTwoRolesBecomesTwoTextures)
{
    test::Document document = test::texturedTriangle(
        test::encodeImage("png", 1, 1, 3, std::vector<uint8_t>{128, 64, 32}));
    document.material()["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 0;
    const auto scene = test::load(document);
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->warnings.total(), 0u);
    ASSERT_EQ(scene->textures.size(), 2u);
    const core::Material& material = scene->materials.at(0);
    const auto textureOf = [&](uint32_t slot) {
        return scene->textures.at(static_cast<size_t>(
            scene->textureUses.at(static_cast<size_t>(material.textures[slot])).texture));
    };
    expectTexel(textureOf(shared::kTextureBaseColor), 0, 0,
                {linearOf(128 / 255.0), linearOf(64 / 255.0), linearOf(32 / 255.0), 1});
    expectTexel(textureOf(shared::kTextureMetallicRoughness), 0, 0,
                {128 / 255.0, 64 / 255.0, 32 / 255.0, 1});
}

}  // namespace

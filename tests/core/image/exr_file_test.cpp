// EXR files of other programs: every compression, type and layout of pixels gives the values that
// were written; what is deep, sub-sampled or contradictory is refused (T29, B48).
#include "core/image/exr_file.h"

#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/image/exr_header.h"
#include "tests/support/files/exr_fixture.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"

namespace core {
namespace {

using tests::ExrPicture;
using tests::ExrType;
using tests::TemporaryFolder;
using tests::writeAll;
using Bytes = std::vector<std::byte>;

/// Smooth, so that the compressions that lose something lose little; whole numbers up to 2048,
/// which every type holds.
ExrPicture gradient(ExrType type)
{
    ExrPicture picture{.width = 75, .height = 301};
    for (const char* name : {"A", "B", "G", "R"}) {
        std::vector<float> values;
        for (int y = 0; y < picture.height; ++y)
            for (int x = 0; x < picture.width; ++x)
                values.push_back(float(500 + x + 2 * y + name[0]));
        picture.planes.push_back({name, type, std::move(values)});
    }
    return picture;
}

std::vector<Layer> layersOf(const Bytes& bytes)
{
    const TemporaryFolder folder;
    writeAll(folder / "a.exr", bytes);
    return readExr(folder / "a.exr").layers;
}

/// Largest difference from the picture of what both readers make of it, relative to its values.
double errorOf(const ExrPicture& picture)
{
    const Bytes bytes = tests::makeExr(picture);
    const DecodedImage decoded = decodeExr(bytes, {});
    EXPECT_EQ(decoded.problem, "");
    const std::vector<Layer> layers = layersOf(bytes);
    EXPECT_EQ(layers.size(), 1u);
    const Image& image = layers.at(0).image;
    const size_t count = picture.planes.size();
    EXPECT_EQ(image.pixels.size() * sizeof(float), decoded.image.pixels.size());
    if (image.pixels.size() * sizeof(float) != decoded.image.pixels.size()) return HUGE_VAL;
    EXPECT_EQ(
        std::memcmp(image.pixels.data(), decoded.image.pixels.data(), decoded.image.pixels.size()),
        0);
    double worst = 0;
    const std::vector<size_t> order{3, 2, 1, 0};  // R, G, B, A among A, B, G, R
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        const double expected = double(picture.planes[order[i % count]].values[i / count]);
        worst = std::max(worst, std::abs(double(image.pixels[i]) - expected) / expected);
    }
    return worst;
}

TEST(ExrFile, EveryCompressionTypeAndLayout)
{
    for (int compression = 0; compression < tests::kExrCompressions; ++compression)
        for (const ExrType type : {ExrType::unsigned32, ExrType::half, ExrType::float32})
            for (const int tileSide : {0, 32}) {
                ExrPicture picture = gradient(type);
                picture.compression = compression;
                picture.tileSide = tileSide;
                picture.left = -7;
                picture.top = 5;
                EXPECT_LE(errorOf(picture), compression < 6 ? 0 : 0.02)
                    << compression << ' ' << int(type) << ' ' << tileSide;
            }
}

TEST(ExrFile, LinesFromTheBottomAndLevelsOfDetail)
{
    ExrPicture picture = gradient(ExrType::half);
    picture.bottomUp = true;
    EXPECT_EQ(errorOf(picture), 0);
    picture.tileSide = 16;
    EXPECT_EQ(errorOf(picture), 0);
    picture.levels = true;
    EXPECT_EQ(errorOf(picture), 0);
    picture.tileSide = 400;
    EXPECT_EQ(errorOf(picture), 0) << "one tile, larger than the image";
}

TEST(ExrFile, TheFirstOfSeveralPartsIsAnImage)
{
    const ExrPicture picture = gradient(ExrType::float32);
    const DecodedImage decoded = decodeExr(tests::makeExrOfTwoParts(picture), {});
    ASSERT_EQ(decoded.problem, "");
    EXPECT_EQ(decoded.image.width, 75u);
    float first = 0;
    std::memcpy(&first, decoded.image.pixels.data(), sizeof(first));
    EXPECT_EQ(first, picture.planes[3].values[0]);
}

TEST(ExrFile, ChannelsWithinALayer)
{
    const auto order = [](const std::vector<std::string>& names) {
        ExrPicture picture;
        for (size_t i = 0; i < names.size(); ++i)
            picture.planes.push_back({names[i], ExrType::float32, {float(i)}});
        std::string text;
        for (const Layer& layer : layersOf(tests::makeExr(picture))) {
            text += layer.name + ":";
            for (const float value : layer.image.pixels) text += ' ' + names[size_t(value)];
            text += "; ";
        }
        return text;
    };
    EXPECT_EQ(order({"A", "B", "G", "R", "Z"}), ": R G B A Z; ");
    EXPECT_EQ(order({"A", "Y"}), ": Y A; ");
    EXPECT_EQ(order({"A", "X", "Y", "Z"}), ": X Y Z A; ");
    EXPECT_EQ(order({"alpha", "blue", "green", "red"}), ": red green blue alpha; ");
    EXPECT_EQ(order({"b.G", "b.R", "a.x.B", "a.x.R", "G", "other"}),
              ": G other; a.x: a.x.R a.x.B; b: b.R b.G; ");
}

/// What both readers say of a file.
std::string problemOf(const TemporaryFolder& folder, const Bytes& bytes)
{
    writeAll(folder / "a.exr", bytes);
    const DecodedImage decoded = decodeExr(bytes, {});
    EXPECT_EQ(decoded.problem.empty(), !decoded.image.pixels.empty());
    try {
        (void)readExr(folder / "a.exr");
        EXPECT_EQ(decoded.problem, "");
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(message.rfind((folder / "a.exr").string() + ": ", 0), 0u) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        EXPECT_NE(decoded.problem, "") << message;
    }
    return decoded.problem;
}

TEST(ExrFile, FewerValuesThanPixelsAreRefused)
{
    const TemporaryFolder folder;
    ExrPicture picture{.width = 4, .height = 4};
    picture.planes = {{"Y", ExrType::half, std::vector<float>(16, 1.0f)},
                      {"RY", ExrType::half, std::vector<float>(4, 1.0f), 2}};
    EXPECT_NE(problemOf(folder, tests::makeExr(picture)).find("fewer values than pixels"),
              std::string::npos);
}

TEST(ExrFile, TilesThatAreLargerThanSenseAreRefused)
{
    const TemporaryFolder folder;
    ExrPicture picture = gradient(ExrType::float32);
    picture.tileSide = 32;
    Bytes bytes = tests::makeExr(picture);
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const size_t tiles = text.find(std::string("tiles\0tiledesc\0", 15)) + 15 + 4;
    ASSERT_LT(tiles, bytes.size());
    for (const uint32_t side : {0u, 1025u, 1u << 30, 0xffffffffu}) {
        std::memcpy(&bytes[tiles + 4], &side, 4);
        EXPECT_NE(problemOf(folder, bytes), "") << side;
    }
}

TEST(ExrFile, MoreBlocksThanTheFileHasRoomForAreRefused)
{
    const Bytes good = tests::makeExrOfTwoParts(gradient(ExrType::half));
    const std::string text(reinterpret_cast<const char*>(good.data()), good.size());
    const std::string name("chunkCount\0int\0", 15);
    size_t at = 0;
    for (int part = 0; part < 2; ++part) {
        at = text.find(name, at) + name.size() + 4;
        ASSERT_LT(at, good.size());
        Bytes bytes = good;
        const uint32_t count = 100000000;
        std::memcpy(&bytes[at], &count, 4);
        EXPECT_NE(decodeExr(bytes, {}).problem.find("blocks of pixels"), std::string::npos) << part;
    }
}

TEST(ExrFile, EveryCutOfTilesAndOtherCompressionsIsRefused)
{
    const TemporaryFolder folder;
    for (const int compression : {0, 1, 4, 6, 8})
        for (const int tileSide : {0, 32}) {
            ExrPicture picture = gradient(ExrType::half);
            picture.compression = compression;
            picture.tileSide = tileSide;
            const Bytes bytes = tests::makeExr(picture);
            for (size_t k = 0; k < 40; ++k) {
                const size_t size = bytes.size() * k / 40;
                EXPECT_NE(problemOf(folder, {bytes.begin(), bytes.begin() + ptrdiff_t(size)}), "")
                    << compression << ' ' << tileSide << ' ' << size;
            }
        }
}

TEST(ExrFile, DamagedHeadersNeverDoMoreThanRefuse)
{
    ImageGuards guards;
    guards.maxSize = 4096;
    guards.maxBytes = 64 << 20;
    std::mt19937 random(12);
    int refusals = 0;
    for (const int tileSide : {0, 32}) {
        ExrPicture picture = gradient(ExrType::half);
        picture.tileSide = tileSide;
        const Bytes good = tests::makeExr(picture);
        for (int trial = 0; trial < 400; ++trial) {
            Bytes damaged = good;
            for (int i = 0; i < 1 + trial % 3; ++i)
                damaged[random() % 400] = std::byte(random() & 255u);
            refusals += decodeExr(damaged, guards).problem.empty() ? 0 : 1;
        }
    }
    EXPECT_GT(refusals, 300);
}

TEST(ExrFile, ReadingCanBeStopped)
{
    std::stop_source source;
    source.request_stop();
    const Bytes bytes = tests::makeExr(gradient(ExrType::half));
    EXPECT_NE(decodeExr(bytes, {}, source.get_token()).problem.find("stopped"), std::string::npos);
}

}  // namespace
}  // namespace core

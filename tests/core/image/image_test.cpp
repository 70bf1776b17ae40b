// T29: files hold exactly what was written, and bad files or places give one clear error and
// nothing half-written.
#include "core/image/image.h"

#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <png.h>

#include "core/base/check.h"
#include "core/image/exr_header.h"
#include "shared/tonemap.h"
#include "tests/support/files/exr_fixture.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/whole_files.h"

namespace core {
namespace {

using tests::readAll;
using tests::TemporaryFolder;
using tests::writeAll;

Image randomImage(uint32_t width, uint32_t height, uint32_t channels, uint32_t seed)
{
    std::mt19937 random(seed);
    std::lognormal_distribution<float> radiance(0.0f, 3.0f);
    Image image(width, height, channels);
    for (float& value : image.pixels) value = radiance(random);
    return image;
}

ImageFile sampleFile()
{
    ImageFile file;
    file.layers = {{"", randomImage(37, 23, 3, 1)},
                   {"variance", randomImage(37, 23, 3, 2)},
                   {"depth", randomImage(37, 23, 1, 3)},
                   {"normal", randomImage(37, 23, 3, 4)},
                   {"mask", randomImage(37, 23, 4, 5)}};
    file.metadata = {{"seed", "12"}, {"params", "{\"a\": [1, 2]}\nsecond \xc3\xa9"}};
    return file;
}

/// Message of the core::Error that `action` throws; a line without line breaks.
std::string errorOf(const std::function<void()>& action)
{
    try {
        action();
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
        return message;
    }
    ADD_FAILURE() << "no error";
    return {};
}

bool sameBits(const Image& a, const Image& b)
{
    return a.width == b.width && a.height == b.height && a.channels == b.channels &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(float)) == 0;
}

TEST(Exr, roundTripIsExact)
{
    const TemporaryFolder folder;
    ImageFile file = sampleFile();
    Image& picture = file.layers[0].image;
    const float odd[] = {-0.0f,
                         1e-45f,
                         std::numeric_limits<float>::max(),
                         std::numeric_limits<float>::infinity(),
                         -std::numeric_limits<float>::infinity(),
                         std::numeric_limits<float>::quiet_NaN(),
                         -3.5f,
                         65504.5f};
    std::copy(std::begin(odd), std::end(odd), picture.pixels.begin());
    writeExr(folder / "a.exr", file);
    const ImageFile back = readExr(folder / "a.exr");
    EXPECT_EQ(back.layers.size(), file.layers.size());
    for (const Layer& layer : file.layers) {
        ASSERT_TRUE(back.hasLayer(layer.name)) << layer.name;
        EXPECT_TRUE(sameBits(layer.image, back.layer(layer.name))) << layer.name;
    }
    EXPECT_EQ(back.metadata, file.metadata);
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Exr, equalImagesGiveEqualBytes)
{
    const TemporaryFolder folder;
    writeExr(folder / "a.exr", sampleFile());
    writeExr(folder / "b.exr", sampleFile());
    const std::string bytes = readAll(folder / "a.exr");
    EXPECT_TRUE(bytes == readAll(folder / "b.exr"));
    // The library's time of day, if it is there at all, is an empty string: a second later changes
    // nothing.
    const size_t date = bytes.find("capDate");
    if (date != std::string::npos) {
        EXPECT_EQ(bytes.substr(date + 8, 11), std::string("string\0\0\0\0\0", 11));
    }
}

TEST(Exr, sizesFromOnePixel)
{
    const TemporaryFolder folder;
    for (const auto& [width, height] : {std::pair(1u, 1u), {1u, 300u}, {300u, 1u}, {17u, 16u}}) {
        const ImageFile file{{{"", randomImage(width, height, 3, width)}}, {}};
        writeExr(folder / "a.exr", file);
        EXPECT_TRUE(sameBits(readExr(folder / "a.exr").layer(""), file.layer("")));
    }
}

TEST(Exr, foreignChannelNamesAreOrdered)
{
    const TemporaryFolder folder;
    tests::ExrPicture picture{.width = 2};
    for (const auto& [name, value] : {std::pair("n.Z", 3.0f),
                                      {"n.X", 1.0f},
                                      {"n.Y", 2.0f},
                                      {"B", 30.0f},
                                      {"G", 20.0f},
                                      {"R", 10.0f}})
        picture.planes.push_back({name, tests::ExrType::half, {value, value}});
    writeAll(folder / "f.exr", tests::makeExr(picture));
    const ImageFile file = readExr(folder / "f.exr");
    EXPECT_EQ(file.layer("").pixels, (std::vector<float>{10, 20, 30, 10, 20, 30}));
    EXPECT_EQ(file.layer("n").pixels, (std::vector<float>{1, 2, 3, 1, 2, 3}));
}

TEST(Exr, missingLayerIsNamedWithThoseThereAre)
{
    const ImageFile file = sampleFile();
    const std::string message = errorOf([&] { file.layer("albedo"); });
    EXPECT_NE(message.find("albedo"), std::string::npos);
    EXPECT_NE(message.find("variance"), std::string::npos);
}

TEST(Exr, badFilesAreRefused)
{
    const TemporaryFolder folder;
    const auto refused = [&](const std::string& name, const std::string& part) {
        const std::string message = errorOf([&] { readExr(folder / name); });
        EXPECT_EQ(message.rfind((folder / name).string(), 0), 0u) << message;
        EXPECT_NE(message.find(part), std::string::npos) << message;
    };
    refused("none.exr", "no such file");
    std::filesystem::create_directory(folder / "folder.exr");
    refused("folder.exr", "not a regular file");
    writeAll(folder / "text.exr", "this is a text that is not an image");
    refused("text.exr", "not an EXR");
    writeAll(folder / "empty.exr", "");
    refused("empty.exr", "not an EXR");
}

TEST(Exr, everyTruncationIsRefused)
{
    const TemporaryFolder folder;
    writeExr(folder / "a.exr", sampleFile());
    const std::string bytes = readAll(folder / "a.exr");
    ASSERT_GT(bytes.size(), 5000u);
    for (size_t length = 0; length < bytes.size(); length += length < 1200 ? 13 : 997) {
        writeAll(folder / "cut.exr", bytes.substr(0, length));
        EXPECT_THROW(readExr(folder / "cut.exr"), Error) << length;
    }
}

/// Header with one attribute of each kind that matters, claiming the given window.
std::string craftedHeader(int32_t left, int32_t top, int32_t right, int32_t bottom,
                          uint32_t version)
{
    std::string bytes("\x76\x2f\x31\x01", 4);
    const auto word = [&](auto value) { bytes.append(reinterpret_cast<const char*>(&value), 4); };
    word(version);
    bytes.append("channels\0chlist\0", 16);
    word(19);
    bytes.append("R\0", 2);
    word(2);
    word(0);
    word(1);
    word(1);
    bytes.append(1, '\0');
    bytes.append("dataWindow\0box2i\0", 17);
    word(16);
    for (const int32_t side : {left, top, right, bottom}) word(side);
    return bytes.append(1, '\0');
}

TEST(Exr, claimsAreCheckedBeforeAnythingIsAllocated)
{
    const TemporaryFolder folder;
    const auto message = [&](const std::string& bytes) {
        writeAll(folder / "c.exr", bytes);
        return errorOf([&] { readExr(folder / "c.exr"); });
    };
    EXPECT_NE(message(craftedHeader(0, 0, 99999, 9, 2)).find("100000 x 10"), std::string::npos);
    EXPECT_NE(message(craftedHeader(0, 0, 65535, 65535, 2)).find("at most"), std::string::npos);
    EXPECT_NE(message(craftedHeader(INT32_MIN, 0, INT32_MAX, 9, 2)).find("damaged"),
              std::string::npos);
    EXPECT_NE(message(craftedHeader(5, 0, 4, 9, 2)).find("damaged"), std::string::npos);
    EXPECT_NE(message(craftedHeader(0, 0, 9, 9, 2 | 0x800)).find("deep"), std::string::npos);
    EXPECT_NE(message(craftedHeader(0, 0, 9, 9, 2 | 0x1000)).find("multi-part"), std::string::npos);
    writeAll(folder / "ok.exr", craftedHeader(-3, 0, 6, 4, 2));
    const ExrHeader header = readExrHeader(folder / "ok.exr");
    EXPECT_EQ(header.width, 10u);
    EXPECT_EQ(header.height, 5u);
    EXPECT_EQ(header.channels, 1u);
}

TEST(Exr, damagedFilesNeverDoMoreThanThrow)
{
    const TemporaryFolder folder;
    writeExr(folder / "a.exr", {{{"", randomImage(9, 7, 3, 6)}}, {{"seed", "1"}}});
    const std::string bytes = readAll(folder / "a.exr");
    std::mt19937 random(7);
    int refusals = 0;
    for (int trial = 0; trial < 400; ++trial) {
        std::string damaged = bytes;
        // Mostly in the header, which decides what is allocated.
        const size_t range = trial % 4 == 0 ? bytes.size() : 330;
        for (int i = 0; i < 1 + trial % 3; ++i) damaged[random() % range] = char(random());
        writeAll(folder / "d.exr", damaged);
        try {
            readExr(folder / "d.exr");
        } catch (const Error&) {
            ++refusals;
        }
    }
    EXPECT_GT(refusals, 100);
}

TEST(Exr, failedWritesLeaveNothingBehind)
{
    const TemporaryFolder folder;
    const ImageFile file = sampleFile();
    std::filesystem::create_directory(folder / "taken.exr");
    EXPECT_NE(errorOf([&] { writeExr(folder / "taken.exr", file); }).find("is a folder"),
              std::string::npos);
    EXPECT_NE(errorOf([&] { writeExr(folder / "no" / "a.exr", file); }).find("cannot be written"),
              std::string::npos);
    EXPECT_NE(errorOf([&] {
                  writePng(folder / "no" / "a.png", file.layer(""), 0, 0, {});
              }).find("cannot be written"),
              std::string::npos);
    EXPECT_EQ(folder.count(), 1u);
    EXPECT_TRUE(std::filesystem::is_directory(folder / "taken.exr"));
}

/// While it lives, files cannot grow beyond `bytes`: what a full disk does.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes)
    {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
        handler_ = std::signal(SIGXFSZ, SIG_IGN);
    }
    ~FileSizeLimit()
    {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
    rlimit before_{};
    void (*handler_)(int) = nullptr;
};

TEST(Exr, aFullDiskLeavesTheOlderFile)
{
    const TemporaryFolder folder;
    writeAll(folder / "a.exr", "older");
    writeAll(folder / "a.png", "older");
    ImageFile file{{{"", randomImage(200, 200, 3, 10)}}, {}};
    for (const rlim_t bytes : {rlim_t(0), rlim_t(100), rlim_t(20000)}) {
        const FileSizeLimit limit(bytes);
        EXPECT_THROW(writeExr(folder / "a.exr", file), Error) << bytes;
        EXPECT_THROW(writePng(folder / "a.png", file.layer(""), 0, 0, {}), Error) << bytes;
    }
    EXPECT_EQ(std::filesystem::file_size(folder / "a.exr"), 5u);
    EXPECT_EQ(std::filesystem::file_size(folder / "a.png"), 5u);
    EXPECT_EQ(folder.count(), 2u);
}

TEST(Exr, overwritesOnlyWithTheWhole)
{
    const TemporaryFolder folder;
    writeAll(folder / "a.exr", "something older");
    writeExr(folder / "a.exr", sampleFile());
    EXPECT_EQ(readExr(folder / "a.exr").layers.size(), 5u);
    EXPECT_EQ(folder.count(), 1u);
}

struct Decoded {
    std::vector<uint8_t> bytes;
    std::map<std::string, std::string> texts;
    bool srgb = false;
};

/// What libpng makes of a file when it is asked for all that is in it.
Decoded decodePng(const std::filesystem::path& file)
{
    Decoded result;
    FILE* stream = std::fopen(file.c_str(), "rb");
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_read_png(png, info, PNG_TRANSFORM_IDENTITY, nullptr);  // ends the process on a fault
    png_bytepp rows = png_get_rows(png, info);
    for (uint32_t y = 0; y < png_get_image_height(png, info); ++y)
        result.bytes.insert(result.bytes.end(), rows[y], rows[y] + png_get_rowbytes(png, info));
    png_textp texts = nullptr;
    int count = 0;
    png_get_text(png, info, &texts, &count);
    for (int i = 0; i < count; ++i) result.texts[texts[i].key] = texts[i].text;
    result.srgb = png_get_valid(png, info, PNG_INFO_sRGB) != 0;
    png_destroy_read_struct(&png, &info, nullptr);
    std::fclose(stream);
    return result;
}

double encodeInDouble(double x)
{
    x = std::min(std::max(x, 0.0), 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

TEST(Png, linearRampMatchesDouble)
{
    const TemporaryFolder folder;
    Image ramp(256, 16, 3);
    for (size_t i = 0; i < ramp.pixels.size(); ++i)
        ramp.pixels[i] = 1.3f * float(i) / float(ramp.pixels.size()) - 0.05f;
    for (const float exposure : {0.0f, -2.5f, 3.0f}) {
        writePng(folder / "r.png", ramp, exposure, shared::kToneLinear, {});
        const Decoded png = decodePng(folder / "r.png");
        ASSERT_EQ(png.bytes.size(), ramp.pixels.size());
        int off = 0;
        for (size_t i = 0; i < png.bytes.size(); ++i) {
            const double exact =
                255 * encodeInDouble(double(ramp.pixels[i]) * std::exp2(double(exposure)));
            EXPECT_NEAR(png.bytes[i], exact, 0.5001) << ramp.pixels[i];
            off += std::abs(png.bytes[i] - exact) > 0.5;
        }
        EXPECT_LT(off, 20);
    }
}

TEST(Png, appliesTheToneCurve)
{
    const TemporaryFolder folder;
    const Image image = randomImage(32, 32, 3, 8);
    for (const uint32_t curve : {shared::kToneAces, shared::kToneAgx, shared::kToneNeutral}) {
        writePng(folder / "t.png", image, 0.5f, curve, {});
        const Decoded png = decodePng(folder / "t.png");
        for (size_t p = 0; p < 32 * 32; ++p) {
            const float* c = &image.pixels[3 * p];
            const glm::vec3 shown =
                shared::toneMap(std::exp2(0.5f) * glm::vec3(c[0], c[1], c[2]), curve);
            for (int k = 0; k < 3; ++k)
                ASSERT_NEAR(png.bytes[3 * p + size_t(k)], 255 * encodeInDouble(double(shown[k])),
                            0.51);
        }
    }
}

TEST(Png, oddValuesAndMetadata)
{
    const TemporaryFolder folder;
    Image image(4, 1, 4);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    image.pixels = {nan, 0.5f, -1, 9, inf, 1, 2, 9, -inf, 0, 1e30f, 9, 1, 1, 1, 9};
    const Metadata metadata{{"seed", "12"}, {"scene", "room \"a\""}};
    writePng(folder / "o.png", image, 0, shared::kToneLinear, metadata);
    const Decoded png = decodePng(folder / "o.png");
    EXPECT_EQ(png.bytes,
              (std::vector<uint8_t>{0, 188, 0, 255, 255, 255, 0, 0, 255, 255, 255, 255}));
    EXPECT_TRUE(png.srgb);
    EXPECT_EQ(png.texts.size(), metadata.size());
    for (const auto& [key, value] : metadata) EXPECT_EQ(png.texts.at("rekindle:" + key), value);
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Png, bytesComeBackAsTheyWere)
{
    const TemporaryFolder folder;
    std::mt19937 random(9);
    for (const uint32_t channels : {1u, 2u, 3u, 4u}) {
        std::vector<uint8_t> bytes(13 * 11 * channels);
        for (uint8_t& b : bytes) b = uint8_t(random());
        writePngBytes(folder / "b.png", 13, 11, channels, bytes, {});
        EXPECT_EQ(decodePng(folder / "b.png").bytes, bytes) << channels;
    }
}

TEST(RequireWritable, saysWhyNot)
{
    const TemporaryFolder folder;
    requireWritable(folder / "a.exr");
    requireWritable(folder / "a.PNG");
    EXPECT_EQ(folder.count(), 0u);
    const auto refused = [&](const std::filesystem::path& file, const std::string& part,
                             ExitCode code) {
        try {
            requireWritable(file);
            ADD_FAILURE() << file;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
            EXPECT_EQ(error.code(), code);
        }
    };
    refused(folder / "a.jpg", ".exr or .png", ExitCode::commandLine);
    refused(folder / "a", ".exr or .png", ExitCode::commandLine);
    refused(folder / "none" / "a.exr", "does not exist", ExitCode::badInput);
    refused("/proc/a.exr", "cannot be written", ExitCode::badInput);
    std::filesystem::create_directory(folder / "b.exr");
    refused(folder / "b.exr", "is a folder", ExitCode::badInput);
    writeAll(folder / "old.exr", "keep me");
    requireWritable(folder / "old.exr");
    EXPECT_EQ(readAll(folder / "old.exr"), "keep me");
}

}  // namespace
}  // namespace core

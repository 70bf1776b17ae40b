// Frames of the window against frames that a person has checked (tests/golden). At most one per
// cent of the pixels may differ by more than 0.016 of white; the status line, which shows times, is
// left out. After an intended change, check the frames that this test writes (its message says
// where) and copy them there.
#include <cmath>
#include <fstream>

#include "core/image/png_file.h"
#include "tests/support/process/program.h"
#include "tests/support/session/virtual_display.h"

namespace {

using namespace tests;

constexpr int kStatusLine = 30;  // pixels at the bottom

struct Frame {
    int width = 0, height = 0, channels = 0;
    std::vector<uint8_t> pixels;
};

Frame readPng(const fs::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const core::DecodedImage png = core::decodePng(std::as_bytes(std::span(text)), {});
    if (!png.problem.empty() || png.image.type != core::RawImage::Type::unsigned8) return {};
    const auto* first = reinterpret_cast<const uint8_t*>(png.image.pixels.data());
    return {static_cast<int>(png.image.width),
            static_cast<int>(png.image.height),
            static_cast<int>(png.image.channels),
            {first, first + png.image.pixels.size()}};
}

/// Share of pixels with a channel that differs by more than 0.016.
double different(const Frame& a, const Frame& b)
{
    size_t count = 0, all = 0;
    for (int y = 0; y < a.height - kStatusLine; ++y) {
        for (int x = 0; x < a.width; ++x, ++all) {
            const size_t pixel =
                static_cast<size_t>(y) * static_cast<size_t>(a.width) + static_cast<size_t>(x);
            bool off = false;
            for (size_t c = 0; c < 3; ++c)
                off = off || std::abs(int(a.pixels[pixel * size_t(a.channels) + c]) -
                                      int(b.pixels[pixel * size_t(b.channels) + c])) > 0.016 * 255;
            count += off ? 1 : 0;
        }
    }
    return double(count) / double(all);
}

class GoldenView : public Cli {};

TEST_F(GoldenView, FramesAreThoseThatWereLookedAt)
{
    if (!VirtualDisplay::installed()) GTEST_SKIP() << "Xvfb is not installed";
    const VirtualDisplay display;
    // Notices would be in the way while they fade: so this waits for the picture instead of the
    // log.
    writeFile("script.json", R"({"steps":[
        {"wait":"loaded"}, {"do":"plot"}, {"do":"set","name":"spp-limit","value":8},
        {"do":"set","name":"picture-scale","value":0.5},
        {"wait":"finished","timeout":600}, {"wait":"seconds","value":8}, {"wait":"frames","value":4},
        {"do":"screenshot","file":"panel.png"}, {"wait":"seconds","value":10},
        {"do":"panel"}, {"wait":"seconds","value":0.5}, {"wait":"finished","timeout":600},
        {"do":"reference","spp":16}, {"wait":"reference","value":16,"timeout":600}, {"wait":"job"},
        {"do":"show-error"}, {"wait":"seconds","value":0.5}, {"wait":"frames","value":4},
        {"do":"screenshot","file":"error.png"}]})");
    const Result result = finish(start({"view", kScene, "--script", "script.json", "--no-settings",
                                        "--size", "640x360", "--device", "cpu"}),
                                 120);
    ASSERT_EQ(result.code, 0) << result.err << result.out;
    for (const char* name : {"panel.png", "error.png"}) {
        const fs::path kept = fs::path(REKINDLE_SOURCE_DIR) / "tests" / "golden" / name;
        const Frame golden = readPng(kept), now = readPng(work(name));
        const fs::path shown = fs::path(testing::TempDir()) / (std::string("rekindle-now-") + name);
        fs::copy_file(work(name), shown, fs::copy_options::overwrite_existing);
        ASSERT_GT(now.width, 0) << name;
        ASSERT_EQ(golden.width, now.width) << kept << " against " << shown;
        ASSERT_EQ(golden.height, now.height) << kept << " against " << shown;
        EXPECT_LT(different(golden, now), 0.01) << kept << " against " << shown;
        fs::remove(shown);
    }
}

}  // namespace

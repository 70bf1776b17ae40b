// The command `compare`: its numbers are those of the metrics, its refusals say what is wrong.
#include "app/commands/compare.h"

#include <cmath>
#include <cstdlib>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/check.h"
#include "core/image/flip.h"
#include "core/image/image.h"
#include "core/image/metrics.h"
#include "core/methods/method.h"
#include "tests/support/files/source_folder.h"
#include "tests/support/files/temporary_folder.h"

namespace app {
namespace {

using core::Image;
using core::ImageFile;

Image filled(uint32_t width, uint32_t height, uint32_t channels, float value, float slope = 0)
{
    Image image(width, height, channels);
    for (size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = value + slope * float(i / channels % width);
    return image;
}

class Compare : public testing::Test {
protected:
    nlohmann::json run(const ImageFile& image, const ImageFile& reference)
    {
        core::writeExr(folder_ / "image.exr", image);
        core::writeExr(folder_ / "reference.exr", reference);
        std::ostringstream out;
        EXPECT_EQ(compareCommand(folder_ / "image.exr", folder_ / "reference.exr", out), 0);
        return nlohmann::json::parse(out.str());
    }

    std::string refusal(const std::string& image, const std::string& reference)
    {
        std::ostringstream out;
        try {
            compareCommand(folder_ / image, folder_ / reference, out);
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::badInput);
            EXPECT_EQ(out.str(), "");
            return error.what();
        }
        ADD_FAILURE() << "not refused";
        return {};
    }

    tests::TemporaryFolder folder_;
};

TEST_F(Compare, numbersAreThoseOfTheMetrics)
{
    const Image image = filled(20, 10, 3, 0.5f, 0.11f), reference = filled(20, 10, 3, 0.4f, 0.1f);
    const nlohmann::json json = run({{{"", image}}, {}}, {{{"", reference}}, {}});
    const core::ImageErrors errors = core::imageErrors(image, reference);
    EXPECT_EQ(json["rmse"], errors.rmse);
    EXPECT_EQ(json["relmse"], errors.relMse);
    EXPECT_EQ(json["mean_signed_error"], errors.meanSignedError);
    EXPECT_EQ(json["flip"], core::flipHdr(image, reference).mean);
    for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(json["mean_image"][size_t(c)], errors.meanImage[c]);
        EXPECT_EQ(json["mean_reference"][size_t(c)], errors.meanReference[c]);
    }
    EXPECT_GT(json["rmse"].get<double>(), 0.1);
    EXPECT_EQ(json["formulas"]["rmse"], core::kRmseFormula);
    EXPECT_EQ(json["size"], (nlohmann::json{20, 10}));
    EXPECT_FALSE(json.contains("welch_z"));
}

TEST_F(Compare, welchNeedsBothVariances)
{
    const Image image = filled(16, 16, 3, 1.0f), reference = filled(16, 16, 3, 1.1f);
    const Image variance = filled(16, 16, 3, 0.01f);
    const ImageFile a{{{"", image}, {"variance", variance}}, {{"spp", "64"}, {"seed", "1"}}};
    const ImageFile b{{{"", reference}, {"variance", variance}}, {{"spp", "64"}, {"seed", "2"}}};
    const nlohmann::json json = run(a, b);
    // 256 pixels: difference -0.1 over sqrt(0.02 / 256); many degrees of freedom.
    EXPECT_NEAR(json["welch_z"].get<double>(), -0.1 / std::sqrt(0.02 / 256), 0.02);
    EXPECT_EQ(json["welch"]["tiles"], 4);
    EXPECT_LT(json["welch"]["smallest_p"].get<double>(), 1e-4);
    EXPECT_FALSE(json["welch"].contains("notes"));
    EXPECT_FALSE(run(a, {{{"", reference}}, {}}).contains("welch_z"));
}

TEST_F(Compare, saysWhenTheTestUnderstates)
{
    const Image image = filled(8, 8, 3, 1.0f), variance = filled(8, 8, 3, 0.01f);
    ImageFile a{{{"", image}, {"variance", variance}}, {{"scene_hash", "ab"}, {"seed", "1"}}};
    const nlohmann::json shared = run(a, a)["welch"]["notes"];
    ASSERT_EQ(shared.size(), 1u);
    EXPECT_NE(shared[0].get<std::string>().find("seed"), std::string::npos);
    ImageFile b = a;
    b.metadata["seed"] = "2";
    b.metadata["params"] = "{\"sampler\":\"sobol\"}";
    const nlohmann::json sobol = run(a, b)["welch"]["notes"];
    ASSERT_EQ(sobol.size(), 1u);
    EXPECT_NE(sobol[0].get<std::string>().find("sobol"), std::string::npos);
}

TEST_F(Compare, tellsTheNoiseOfTheReference)
{
    const Image image = filled(16, 16, 3, 1.0f), variance = filled(16, 16, 3, 0.04f);
    const ImageFile plain{{{"", image}}, {}}, noisy{{{"", image}, {"variance", variance}}, {}};
    EXPECT_FALSE(run(noisy, plain).contains("reference_noise"));
    EXPECT_NEAR(run(plain, noisy)["reference_noise"].get<double>(), 0.2, 1e-6);
}

/// Two pictures of every method, which differ in their seeds alone, as the program writes them: the
/// tiles' p are uniform, or it is said why there are none.
TEST_F(Compare, knowsOfEveryMethodWhetherItsPixelsErrAlone)
{
    for (const core::MethodInfo& method : core::methods()) {
        SCOPED_TRACE(method.id());
        for (const char* seed : {"1", "2"}) {
            const std::string command =
                "'" REKINDLE_BINARY "' render '" +
                (tests::kAssets / "cornell-diffuse.gltf").string() + "' -o '" +
                (folder_ / seed).string() + ".exr' -q --device cpu --size 64x64 --spp 8" +
                " --method " + std::string(method.id()) + " --sampler independent --seed " + seed;
            ASSERT_EQ(std::system(command.c_str()), 0) << command;
        }
        std::ostringstream out;
        EXPECT_EQ(compareCommand(folder_ / "1.exr", folder_ / "2.exr", out), 0);
        const nlohmann::json json = nlohmann::json::parse(out.str());
        EXPECT_TRUE(json.contains("welch_z"));
        const nlohmann::json& welch = json["welch"];
        for (const char* key : {"smallest_p", "uniform_p", "p_histogram"})
            EXPECT_NE(welch.contains(key), method.traits.sharesLight) << key;
        EXPECT_EQ(welch.dump().find("share their light") != std::string::npos,
                  method.traits.sharesLight);
        if (welch.contains("uniform_p")) {
            EXPECT_GT(welch["uniform_p"].get<double>(), 1e-4);
        }
    }
}

TEST_F(Compare, oneChannelCountsForThree)
{
    const nlohmann::json json =
        run({{{"", filled(4, 4, 1, 0.5f)}}, {}}, {{{"", filled(4, 4, 3, 0.25f)}}, {}});
    EXPECT_EQ(json["rmse"], 0.25);
    EXPECT_EQ(json["mean_image"][2], 0.5);
}

TEST_F(Compare, refusesWhatItCannotCompare)
{
    core::writeExr(folder_ / "a.exr", {{{"", filled(20, 10, 3, 1)}}, {}});
    core::writeExr(folder_ / "b.exr", {{{"", filled(10, 20, 3, 1)}}, {}});
    core::writeExr(folder_ / "depth.exr", {{{"depth", filled(20, 10, 1, 1)}}, {}});
    const std::string sizes = refusal("a.exr", "b.exr");
    EXPECT_NE(sizes.find("20 x 10"), std::string::npos) << sizes;
    EXPECT_NE(sizes.find("10 x 20"), std::string::npos) << sizes;
    EXPECT_NE(refusal("a.exr", "none.exr").find("none.exr: no such file"), std::string::npos);
    EXPECT_NE(refusal("depth.exr", "a.exr").find("depth"), std::string::npos);
}

}  // namespace
}  // namespace app

// Light that comes to a first hit by a mirror, through glass, or from a lamp that also reflects:
// flights keep it as they keep what a wall reflects, on every device, and the mean stays.
#include "tests/support/methods/reuse_flights.h"
#include "tests/support/scenes/test_scenes.h"
#include "tests/support/statistics/stats.h"

namespace {

using namespace tests;

/// A room whose right wall is a mirror, with a pane of clear glass below a lamp that mirrors, too.
std::shared_ptr<const core::World> mirrorRoom()
{
    SceneBuilder b = room(lambert(glm::vec3(0.7f)), lambert(glm::vec3(0.5f)));
    b.quad({0.99f, -1, -1}, {0, 0, 2}, {0, 2, 0}, b.material(glossy(glm::vec3(0.95f), 1, 0)));
    core::Material lamp = glossy(glm::vec3(0), 0, 0);
    lamp.data.emissive = glm::vec3(9);
    b.quad({-0.95f, 0.1f, -0.5f}, {0, 0.6f, 0}, {0, 0, 0.6f}, b.material(lamp));
    core::Material pane = glossy(glm::vec3(1), 0, 0);
    pane.data.transmission = 1;
    b.quad({-0.9f, 0.7f, -0.9f}, {1.8f, 0, 0}, {0, 0, 1.8f}, b.material(pane));
    return b.world();
}

/// A room of which one wall shines, and reflects more than the others.
std::shared_ptr<const core::World> shiningWall()
{
    SceneBuilder b = room(lambert(glm::vec3(0.5f)), lambert(glm::vec3(0.5f)));
    core::Material lamp = lambert(glm::vec3(0.8f));
    lamp.data.emissive = glm::vec3(1);
    b.quad({-0.97f, -1, -1}, {0, 2, 0}, {0, 0, 2}, b.material(lamp));
    return b.world();
}

class ReuseMirrors : public ReuseFlights {
protected:
    ReuseParams asking(uint32_t seed) const
    {
        ReuseParams params = with(ReuseStrategy::ra, seed);
        params.bias = core::ReuseBias::unbiased;
        return params;
    }

    void expectTheMeanStays(uint32_t flights);

    /// The mean of a map of the last view over pixels that have a history.
    double meanOfMap(size_t map) const
    {
        const std::vector<core::Image> maps = renderer_->maps();
        double sum = 0, count = 0;
        for (size_t i = 0; i < maps[0].pixels.size(); ++i) {
            if (maps[0].pixels[i] <= 1) continue;
            sum += double(maps[map].pixels[i]);
            ++count;
        }
        EXPECT_GT(count, 0.5 * double(maps[0].pixels.size()));
        return sum / count;
    }
};

/// T-35. Nearly all that a history could answer for is kept: c on average, less what lobes have
/// turned. Where it is asked what lies in between, what mirrors show is left to new paths.
TEST_P(ReuseMirrors, AnswerForAsMuchAsWallsDo)
{
    constexpr size_t kAlpha = 1, kC = 2;
    begin(mirrorRoom(), {32, 32});
    fly(with(ReuseStrategy::ra, 5), 12, 0.5);
    EXPECT_GT(meanOfMap(kAlpha), 0.97 * meanOfMap(kC));
    fly(asking(5), 12, 0.5);
    EXPECT_LT(meanOfMap(kAlpha), 0.9 * meanOfMap(kC));
}

/// The mean after a flight is that of the scene, and the error a fifth of that of new paths.
void ReuseMirrors::expectTheMeanStays(uint32_t flights)
{
    constexpr double kBound = 0.005;
    const core::Image truth = reference(4096).mean;
    const double expected = meanOf(truth);
    Moments means;
    double kept = 0, fresh = 0;
    const auto squares = [&](const core::Image& image) {
        double sum = 0;
        for (size_t i = 0; i < image.pixels.size(); ++i)
            sum += std::pow(double(image.pixels[i]) - double(truth.pixels[i]), 2);
        return sum;
    };
    for (uint32_t flight = 0; flight < flights; ++flight) {
        const core::Image image = fly(with(ReuseStrategy::ra, 100 + flight), 12, 0.5).mean;
        means.add(meanOf(image));
        kept += squares(image);
        fresh += squares(fly(with(ReuseStrategy::discard, 100 + flight), 1, 0).mean);
    }
    const double error = std::sqrt(means.varianceOfMean());
    EXPECT_LT(std::abs(means.mean() - expected), kBound * expected + kScore * error)
        << means.mean() << " of " << expected << " +- " << error;
    EXPECT_LT(error, 0.01 * expected) << "underpowered";
    EXPECT_LT(kept, 0.2 * fresh);
}

TEST_P(ReuseMirrors, AMoveLeavesTheMeanAsItIs)
{
    begin(mirrorRoom(), {24, 24});
    expectTheMeanStays(64);
}

TEST_P(ReuseMirrors, LampsShineOnceAndReflect)
{
    begin(shiningWall(), {24, 24});
    expectTheMeanStays(16);
}

INSTANTIATE_TEST_SUITE_P(Devices, ReuseMirrors,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace

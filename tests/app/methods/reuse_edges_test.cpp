// T-38. First hits on the edges of walls, on every device: the camera looks into the middle of a
// square box, whose edges lie on the diagonals of the picture, and so under the middles of pixels.
#include <algorithm>

#include "tests/support/methods/reuse_flights.h"

namespace {

using namespace tests;

using ReuseEdges = ReuseFlights;

TEST_P(ReuseEdges, PointsOnTheEdgesOfWallsSeeLight)
{
    constexpr uint32_t kSide = 48;
    begin("cornell-diffuse", {kSide, kSide});
    const core::Image image = reference(256).mean;
    // One wall may have little of a colour of which the other has much.
    const auto at = [&](uint32_t x, uint32_t y) {
        const float* c = image.at(x, y);
        return double(c[0]) + double(c[1]) + double(c[2]);
    };
    uint32_t edges = 0;
    for (uint32_t i = 1; i < 8; ++i) {
        for (const uint32_t x : {i, kSide - 1 - i}) {
            for (const uint32_t y : {i, kSide - 1 - i}) {
                const double beside = std::min(at(x - 1, y), at(x + 1, y));
                EXPECT_GT(at(x, y), 0.2 * beside) << x << ", " << y;
                edges += beside > 0 ? 1 : 0;
            }
        }
    }
    EXPECT_EQ(edges, 28u);
}

INSTANTIATE_TEST_SUITE_P(Device, ReuseEdges,
                         testing::Values(app::DeviceKind::cpu, app::DeviceKind::vulkan),
                         DeviceName());

}  // namespace

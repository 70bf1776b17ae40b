// M26. Shadow rays of many rows in packets say of each row what its ray alone says, whether its
// neighbours are asked with it or not.
#include "core/many_lights/shadow_packets.h"

#include <gtest/gtest.h>

#include <random>

#include "core/many_lights/slice_oracle.h"
#include "tests/support/methods/light_stage.h"
#include "tests/support/scenes/asset.h"
#include "tests/support/scenes/test_scenes.h"

namespace core::many_lights {
namespace {

using namespace tests;
using glm::vec3;

/// Each row with the probability `share`, and besides runs of rows.
Words randomMask(uint32_t rows, double share, uint32_t runs, std::mt19937& random)
{
    Words mask(wordsFor(rows), 0);
    const auto set = [&](uint32_t row) { mask[row / 64] |= uint64_t(1) << row % 64; };
    std::bernoulli_distribution chosen(share);
    for (uint32_t row = 0; row < rows; ++row)
        if (chosen(random)) set(row);
    for (; runs > 0; --runs) {
        const uint32_t begin = std::uniform_int_distribution(0u, rows - 1)(random);
        const uint32_t length = std::uniform_int_distribution(10u, 90u)(random);
        for (uint32_t row = begin; row < std::min(begin + length, rows); ++row) set(row);
    }
    return mask;
}

/// Whether nothing lies between row and light, by a ray of its own.
bool isOpen(const StageRows& s, const Column& column, uint32_t row)
{
    const bool distant = column.light->kind == LightKind::directional;
    const auto from = [&](uint32_t i) {
        return vec3(s.rows.originX()[i], s.rows.originY()[i], s.rows.originZ()[i]);
    };
    const auto along = [&](const vec3& origin) {
        return distant ? -column.light->normal : column.light->position - origin;
    };
    const uint32_t side = s.rows.fromBehind(row, along(from(row))) ? s.rows.count() : 0;
    const Ray ray{from(side + row),
                  distant ? shared::kDistant : endTowards(along(from(side + row))),
                  along(from(side + row)), shared::hashUint(column.seed ^ s.rows.seeds()[row])};
    return !s.job.receivers.accel->occluded(ray);
}

/// Lights of the stage and one from far away.
std::vector<Column> columnsOf(const LightStage& stage, const VirtualLight& sun)
{
    std::vector<Column> columns{columnOf(sun, 1, 1u << 20, 0)};
    const std::vector<VirtualLight>& lights = stage.lights->set.lights;
    for (uint32_t i = 0; i < lights.size(); i += 3) columns.push_back(columnOf(lights[i], 1, i, 0));
    return columns;
}

/// How many bits were compared and are set.
struct Compared {
    size_t rays = 0, open = 0;
};

Compared compareWithSingleRays(const StageRows& s, std::span<const Column> columns,
                               std::mt19937& random)
{
    Compared compared;
    ShadowPackets packets(*s.job.receivers.accel, s.rows);
    std::vector<Words> asked, visible;
    const Words before = randomMask(s.rows.count(), 0.01, 0, random);
    for (uint32_t j = 0; j < columns.size(); ++j) {
        asked.push_back(j % 5 == 0
                            ? randomMask(s.rows.count(), 1, 0, random)
                            : randomMask(s.rows.count(), j % 2 == 0 ? 0.1 : 0.6, j % 7, random));
        visible.push_back(before);
    }
    for (size_t j = 0; j < columns.size(); ++j)
        packets.addAll(columns[j], asked[j].data(), visible[j].data());
    packets.flush();
    for (size_t j = 0; j < columns.size(); ++j) {
        for (uint32_t row = 0; row < s.rows.count(); ++row) {
            const auto bit = [row](const Words& words) { return words[row / 64] >> row % 64 & 1; };
            const bool expected =
                bit(before) != 0 || (bit(asked[j]) != 0 && isOpen(s, columns[j], row));
            EXPECT_EQ(bit(visible[j]) != 0, expected) << "column " << j << ", row " << row;
            compared.rays += bit(asked[j]);
            compared.open += expected;
        }
    }
    return compared;
}

/// Rooms with shadows, with cut-out and blended surfaces, and with glass, whose rows have two
/// sides.
TEST(ShadowPackets, SayWhatSingleRaysSay)
{
    for (const char* name : {"cornell-diffuse", "textured-box", "glass"}) {
        SCOPED_TRACE(name);
        const LightStage stage(asset(name), 40, 120);
        const StageRows s(stage);
        EXPECT_EQ(s.rows.anyTransmits(), name == std::string("glass"));
        VirtualLight sun;
        sun.kind = LightKind::directional;
        sun.normal = glm::normalize(vec3(-0.2f, -1, -0.3f));
        std::mt19937 random(7);
        const std::vector<Column> columns = columnsOf(stage, sun);
        const Compared compared = compareWithSingleRays(s, columns, random);
        EXPECT_GT(compared.rays, 10000u);
        EXPECT_GT(compared.open, compared.rays / 20);
        EXPECT_LT(compared.open, compared.rays * 99 / 100);
    }
}

}  // namespace
}  // namespace core::many_lights

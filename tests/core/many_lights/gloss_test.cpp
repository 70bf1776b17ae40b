// M21. Glossy rows and lights, which loops over arrays evaluate, against the text of the kernels.
#include "core/many_lights/gloss_rows.h"

#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "core/many_lights/virtual_light.h"
#include "tests/support/methods/bsdf_cases.h"

namespace core::many_lights {
namespace {

using glm::vec3;

/// Unit vectors and surfaces as materials have them.
class Draw {
public:
    float uniform(float low, float high)
    {
        return std::uniform_real_distribution<float>(low, high)(random_);
    }

    vec3 direction()
    {
        std::normal_distribution<float> normal;
        return glm::normalize(vec3(normal(random_), normal(random_), normal(random_)));
    }

    vec3 colour() { return {uniform(0, 1), uniform(0, 1), uniform(0, 1)}; }

    glm::mat3 frame()
    {
        const vec3 n = direction(), t = glm::normalize(glm::cross(n, direction()));
        return {t, glm::cross(n, t), n};
    }

    shared::Bsdf bsdf()
    {
        shared::BsdfInputs m = tests::plastic(uniform(0.1f, 1));
        m.baseColor = colour();
        m.metallic = std::clamp(uniform(-1, 2), 0.0f, 1.0f);
        m.ior = uniform(1, 3);
        m.specularColor = colour();
        m.specular = uniform(0.1f, 1);
        return shared::makeBsdf(m);
    }

private:
    std::mt19937 random_{7};
};

vec3 above(vec3 v)
{
    return {v.x, v.y, std::abs(v.z)};
}

/// Rows 3, 6, 9, ... of a slice, a third of all of which light does not reach.
struct Slice {
    static constexpr uint32_t kRows = 3000;

    GlossRows rows;
    std::vector<vec3> expected = std::vector<vec3>(kRows, vec3(0));
    RowTriple wi, leaving;
    std::vector<float> weights = std::vector<float>(kRows);
};

void expectNear(const vec3& value, const vec3& expected, uint32_t row)
{
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(value[c], expected[c], 1e-4f * expected[c] + 1e-6f) << "row " << row;
}

Slice randomSlice(Draw& draw)
{
    Slice s;
    for (RowTriple* triple : {&s.wi, &s.leaving})
        for (std::vector<float>& v : *triple) v.resize(Slice::kRows);
    for (uint32_t row = 0; row < Slice::kRows; ++row) {
        const vec3 wi = draw.direction(), light = draw.colour();
        for (int c = 0; c < 3; ++c) {
            s.wi[static_cast<size_t>(c)][row] = wi[c];
            s.leaving[static_cast<size_t>(c)][row] = light[c];
        }
        s.weights[row] = std::max(draw.uniform(-1, 2), 0.0f);
        if (row % 3 != 0) continue;
        const shared::Bsdf bsdf = draw.bsdf();
        const vec3 wo = above(draw.direction());
        if (!isGloss(bsdf, wo)) continue;
        const glm::mat3 frame = draw.frame();
        s.rows.push(row, frame, glossOf(bsdf, shared::lobesAt(bsdf, wo), wo));
        s.expected[row] =
            shared::evalBsdf(bsdf, wo, shared::toLocal(frame, wi)) * light * s.weights[row];
    }
    return s;
}

/// To whole ranges, as many rows at a time as may be.
void add(Slice& s, uint32_t begin, uint32_t end)
{
    for (; begin < end; begin += GlossRows::kMost)
        s.rows.add({begin, std::min(begin + GlossRows::kMost, end)}, s.wi, s.leaving, s.weights);
}

TEST(Gloss, RowsGetWhatTheTextOfTheKernelsSays)
{
    Draw draw;
    Slice s = randomSlice(draw);
    ASSERT_GT(s.rows.size(), 900u);
    add(s, 0, Slice::kRows);
    double sum = 0;
    for (uint32_t row = 0; row < Slice::kRows; ++row) {
        expectNear(s.rows.sum(row), s.expected[row], row);
        sum += double(s.expected[row].x);
    }
    EXPECT_GT(sum, 10);  // there is light
}

TEST(Gloss, OnlyTheRowsOfARangeGetLightOrLoseIt)
{
    Draw draw;
    Slice s = randomSlice(draw);
    add(s, 500, 1700);
    s.rows.forget({900, 1001});
    for (uint32_t row = 0; row < Slice::kRows; ++row) {
        const bool has = row >= 500 && row < 1700 && !(row >= 900 && row < 1001);
        expectNear(s.rows.sum(row), has ? s.expected[row] : vec3(0), row);
    }
}

TEST(Gloss, LightsSendWhatTheTextOfTheKernelsSays)
{
    Draw draw;
    const Slice s = randomSlice(draw);
    for (int k = 0; k < 20; ++k) {
        LightSurface light;
        light.frame = draw.frame();
        // The geometric normal lies beside that of the frame.
        light.normal = glm::normalize(light.frame[2] + 0.3f * draw.direction());
        light.incident = above(draw.direction());
        light.bsdf = draw.bsdf();
        light.lobes = shared::lobesAt(light.bsdf, light.incident);
        ASSERT_TRUE(isGloss(light.bsdf, light.incident));
        const vec3 scale = draw.colour();
        RowTriple leaving = s.leaving;
        for (uint32_t row = 10; row < Slice::kRows; row += GlossRows::kMost)
            scatterTowards(light, scale, {row, std::min(row + GlossRows::kMost, Slice::kRows)},
                           s.wi, leaving);
        for (uint32_t row = 0; row < Slice::kRows; ++row) {
            const vec3 wi(s.wi[0][row], s.wi[1][row], s.wi[2][row]);
            const vec3 value(leaving[0][row], leaving[1][row], leaving[2][row]);
            const vec3 before(s.leaving[0][row], s.leaving[1][row], s.leaving[2][row]);
            expectNear(value, row < 10 ? before : scale * light.scattered(-wi), row);
        }
    }
}

/// From wherever their light comes, behind the horizon of their shading normal, too.
TEST(Gloss, LambertianLightsSendWhatTheTextOfTheKernelsSays)
{
    Draw draw;
    const Slice s = randomSlice(draw);
    double between = 0;
    for (int k = 0; k < 40; ++k) {
        LightSurface light;
        light.frame = draw.frame();
        light.normal = glm::normalize(light.frame[2] + 0.7f * draw.direction());
        light.incident = draw.direction();
        light.bsdf = shared::makeBsdf(tests::matte(draw.colour()));
        light.lobes = shared::lobesAt(light.bsdf, light.incident);
        const vec3 scale = draw.colour();
        RowTriple leaving = s.leaving;
        scatterDiffuse(light, scale, {0, Slice::kRows}, s.wi, leaving);
        for (uint32_t row = 0; row < Slice::kRows; ++row) {
            const vec3 out(-s.wi[0][row], -s.wi[1][row], -s.wi[2][row]);
            const bool faces = glm::dot(out, light.normal) > 0;
            const vec3 value(leaving[0][row], leaving[1][row], leaving[2][row]);
            expectNear(value, faces ? scale * light.scattered(out) : vec3(0), row);
            if (faces && glm::dot(out, light.frame[2]) < 0) between += double(value.x);
        }
    }
    EXPECT_GT(between, 10);
}

TEST(Gloss, WhatHasOtherLobesIsNotGlossy)
{
    const vec3 wo(0, 0, 1);
    const auto isOne = [&](const shared::BsdfInputs& m) {
        return isGloss(shared::makeBsdf(m), wo);
    };
    EXPECT_TRUE(isOne(tests::plastic(0.5f)));
    EXPECT_TRUE(isOne(tests::metal(0.25f)));
    EXPECT_FALSE(isOne(tests::matte()));
    EXPECT_FALSE(isOne(tests::metal(0)));
    EXPECT_FALSE(isOne(tests::glass(0.25f, tests::Wall::thin)));
    shared::BsdfInputs coated = tests::plastic(0.5f);
    coated.clearcoat = 1;
    EXPECT_FALSE(isOne(coated));
    EXPECT_FALSE(isGloss(shared::makeBsdf(tests::plastic(0.5f)), {1, 0, 0}));
}

}  // namespace
}  // namespace core::many_lights

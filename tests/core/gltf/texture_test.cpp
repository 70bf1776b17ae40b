// Texture look-ups of the shared text against the definition of each wrap mode and filter, in
// double (N18, N19).
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <glm/gtc/packing.hpp>

#include "core/trace/scene_view.h"
#include "shared/surface.h"

namespace {

/// The texel that integer coordinate i names, as glTF's (OpenGL's) wrap modes define it.
int wrapped(int i, int size, uint32_t mode)
{
    if (mode == shared::kWrapClamp) return std::clamp(i, 0, size - 1);
    const int period = mode == shared::kWrapMirror ? 2 * size : size;
    const int j = ((i % period) + period) % period;
    return j < size ? j : period - 1 - j;
}

struct Fixture {
    std::vector<core::Texel> texels;
    shared::TextureReference reference{};
    shared::SceneView scene{};

    Fixture(uint32_t width, uint32_t height, uint32_t wrapS, uint32_t wrapT, bool nearest)
    {
        std::mt19937 random(width * 31 + height);
        for (uint32_t i = 0; i < width * height; ++i) {
            const auto half = [&] {
                return glm::packHalf1x16(static_cast<float>(random() % 1000) / 1000.0f);
            };
            texels.push_back({half(), half(), half(), half()});
        }
        reference.width = width;
        reference.height = height;
        reference.flags = (wrapS << shared::kTextureWrapSShift) |
                          (wrapT << shared::kTextureWrapTShift) |
                          (nearest ? shared::kTextureNearest : 0u);
        scene.texels = &texels.front().r;
        scene.textureReferences = &reference;
    }

    double texel(int x, int y) const
    {
        return static_cast<double>(glm::unpackHalf1x16(
            texels[static_cast<size_t>(y) * reference.width + static_cast<size_t>(x)].g));
    }

    double expected(double u, double v) const
    {
        const int width = static_cast<int>(reference.width),
                  height = static_cast<int>(reference.height);
        const uint32_t s = reference.flags >> shared::kTextureWrapSShift & 3u,
                       t = reference.flags >> shared::kTextureWrapTShift & 3u;
        const bool nearest = (reference.flags & shared::kTextureNearest) != 0;
        const double x = u * width - (nearest ? 0.0 : 0.5), y = v * height - (nearest ? 0.0 : 0.5);
        const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
        const auto at = [&](int a, int b) {
            return texel(wrapped(a, width, s), wrapped(b, height, t));
        };
        if (nearest) return at(i, j);
        const double fx = x - i, fy = y - j;
        return (1 - fy) * ((1 - fx) * at(i, j) + fx * at(i + 1, j)) +
               fy * ((1 - fx) * at(i, j + 1) + fx * at(i + 1, j + 1));
    }
};

TEST(TextureLookUp, LooksUpAsDefined)
{
    std::mt19937 random(5);
    for (const bool nearest : {false, true}) {
        for (uint32_t s = 0; s < 3; ++s) {
            for (uint32_t t = 0; t < 3; ++t) {
                for (const glm::uvec2 size :
                     {glm::uvec2(1, 1), glm::uvec2(2, 5), glm::uvec2(16, 8)}) {
                    const Fixture f(size.x, size.y, s, t, nearest);
                    for (int k = 0; k < 400; ++k) {
                        // Multiples of 2^-10, off the borders of texels: exact in float, and so is
                        // their fold.
                        const double u =
                            (static_cast<double>(random() % 8192) - 4096 + 0.25) / 1024;
                        const double v =
                            (static_cast<double>(random() % 8192) - 4096 + 0.25) / 1024;
                        const glm::vec2 uv(static_cast<float>(u), static_cast<float>(v));
                        const double found =
                            static_cast<double>(shared::lookUpTexture(f.scene, 0, uv, uv).y);
                        ASSERT_NEAR(found, f.expected(u, v), 1e-5)
                            << "wrap " << s << t << " nearest " << nearest << " at " << u << ' '
                            << v;
                    }
                }
            }
        }
    }
}

TEST(TextureLookUp, StrangeCoordinatesReadSomeTexel)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();
    for (uint32_t wrap = 0; wrap < 3; ++wrap) {
        for (const bool nearest : {false, true}) {
            const Fixture f(7, 3, wrap, wrap, nearest);
            for (const float u :
                 {nan, infinity, -infinity, 1e9f, -1e9f, 3e38f, -1e-20f, 1e-45f, -1.0f, 1.0f}) {
                const float found = shared::lookUpTexture(f.scene, 0, {u, u}, {u, u}).y;
                EXPECT_TRUE(found >= 0 && found <= 1) << u;
            }
        }
    }
}

}  // namespace

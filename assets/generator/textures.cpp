// Images as functions of (u, v), and the shared-exponent format of Radiance.
#include "assets/generator/textures.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <glm/gtc/constants.hpp>

#include "core/base/check.h"
#include "core/image/image.h"

namespace assets {

namespace {

/// An 8-bit image of `side` x `side`; `color(u, v)` gives values in [0, 1] at texel centres, v from
/// the top.
void writeSquare(const std::filesystem::path& file, uint32_t side, uint32_t channels,
                 const std::function<glm::dvec4(double, double)>& color)
{
    std::vector<uint8_t> bytes;
    for (uint32_t y = 0; y < side; ++y)
        for (uint32_t x = 0; x < side; ++x) {
            const glm::dvec4 c = color((x + 0.5) / side, (y + 0.5) / side);
            for (uint32_t i = 0; i < channels; ++i)
                bytes.push_back(uint8_t(std::lround(255 * std::clamp(c[int(i)], 0.0, 1.0))));
        }
    core::writePngBytes(file, side, side, channels, bytes, {});
}

/// Red grows with u, blue with v, lines every eighth, and the corner u = v = 0 is yellow: every
/// flip or turn shows.
glm::dvec4 grid(double u, double v)
{
    if (u < 0.125 && v < 0.125) return {1, 0.9, 0, 1};
    const bool line = std::fmod(8 * u, 1.0) < 0.125 || std::fmod(8 * v, 1.0) < 0.125;
    return line ? glm::dvec4(0.15, 0.15, 0.15, 1)
                : glm::dvec4(0.2 + 0.7 * u, 0.5, 0.2 + 0.7 * v, 1);
}

glm::dvec4 checker(double u, double v)
{
    const bool light = (u < 0.5) == (v < 0.5);
    return light ? glm::dvec4(0.9, 0.88, 0.8, 1) : glm::dvec4(0.25, 0.3, 0.4, 1);
}

/// A lens-shaped leaf with a middle rib, transparent around it.
glm::dvec4 leaf(double u, double v)
{
    const double halfWidth = 0.42 * std::sin(glm::pi<double>() * v);
    const double side = std::abs(u - 0.5);
    if (side > halfWidth) return {0.1, 0.3, 0.05, 0};
    if (side < 0.02) return {0.55, 0.6, 0.25, 1};
    return {0.2 + 0.3 * side, 0.55 - 0.3 * side, 0.1, 1};
}

/// Tangent-space normals of round bumps, four by four, green upwards as glTF has it.
glm::dvec4 bumps(double u, double v)
{
    const glm::dvec2 p(2 * std::fmod(4 * u, 1.0) - 1, 1 - 2 * std::fmod(4 * v, 1.0));
    const double r = glm::length(p);
    const glm::dvec2 slope = r < 0.8 ? 0.8 * p : glm::dvec2(0);
    const glm::dvec3 n = glm::normalize(glm::dvec3(slope, 1));
    return {0.5 * n + 0.5, 1};
}

/// Roughness in green from 0.1 to 0.9 along u, metal (blue) in the lower half.
glm::dvec4 rough(double u, double v)
{
    return {0, 0.1 + 0.8 * u, v > 0.5 ? 1.0 : 0.0, 1};
}

/// Shared exponent and three mantissas of eight bits.
std::string encodeRgbe(glm::dvec3 c)
{
    const double largest = std::max({c.x, c.y, c.z});
    if (largest < 1e-32) return std::string(4, '\0');
    int exponent = 0;
    const double scale = 256 * std::frexp(largest, &exponent) / largest;
    std::string bytes;
    for (int i = 0; i < 3; ++i) bytes += char(uint8_t(scale * c[i]));
    return bytes + char(uint8_t(exponent + 128));
}

}  // namespace

void writeTextures(const std::filesystem::path& folder)
{
    std::filesystem::create_directories(folder);
    writeSquare(folder / "grid.png", 64, 3, grid);
    writeSquare(folder / "checker.png", 8, 3, checker);
    writeSquare(folder / "leaf.png", 64, 4, leaf);
    writeSquare(folder / "bumps.png", 64, 3, bumps);
    writeSquare(folder / "rough.png", 32, 3, rough);
}

void writeEnvironment(const std::filesystem::path& file, uint32_t width, uint32_t height,
                      const std::function<glm::dvec3(double, double)>& radiance)
{
    std::filesystem::create_directories(file.parent_path());
    std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " + std::to_string(height) +
                        " +X " + std::to_string(width) + "\n";
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            bytes += encodeRgbe(radiance((x + 0.5) / width, (y + 0.5) / height));
    std::ofstream stream(file, std::ios::binary);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) throw core::Error(file.string() + ": cannot be written");
}

}  // namespace assets

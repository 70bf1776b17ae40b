// See scene_pictures.h.
#include "app/pictures/scene_pictures.h"

#include <algorithm>
#include <span>

#include "core/image/display.h"

namespace app {

namespace fs = std::filesystem;

namespace {

constexpr uint64_t kMostBytes = 1u << 20;  // some 140 scenes
// Pixels are averaged as they are seen, so that one bright sample does not light its surroundings:
// each of a small picture's sides stands for so many before exposure and tone.
constexpr uint32_t kFiner = 4;

/// `image` between two corners, in fractions of it, as means over width x height boxes.
core::Image boxMeans(const core::Image& image, glm::dvec2 from, glm::dvec2 to, uint32_t width,
                     uint32_t height)
{
    core::Image out(width, height, 3);
    const auto pixel = [](double fraction, uint32_t count) {
        return std::min(static_cast<uint32_t>(std::max(fraction, 0.0) * count), count - 1);
    };
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const glm::dvec2 size(width, height);
            const glm::dvec2 low = glm::mix(from, to, glm::dvec2(x, y) / size);
            const glm::dvec2 high = glm::mix(from, to, glm::dvec2(x + 1, y + 1) / size);
            const uint32_t x0 = pixel(low.x, image.width), y0 = pixel(low.y, image.height);
            const uint32_t x1 = std::max(pixel(high.x, image.width), x0 + 1);
            const uint32_t y1 = std::max(pixel(high.y, image.height), y0 + 1);
            glm::vec3 sum(0);
            for (uint32_t v = y0; v < std::min(y1, image.height); ++v)
                for (uint32_t u = x0; u < std::min(x1, image.width); ++u)
                    sum += glm::vec3(image.at(u, v)[0], image.at(u, v)[1], image.at(u, v)[2]);
            sum /= static_cast<float>((x1 - x0) * (y1 - y0));
            std::copy_n(&sum.x, 3, out.at(x, y));
        }
    return out;
}

std::string keyOf(const fs::path& scene)
{
    std::error_code unknown;
    return fs::absolute(scene, unknown).lexically_normal().string();
}

std::span<const std::byte> bytesOf(const std::string& text)
{
    return std::as_bytes(std::span(text));
}

}  // namespace

SmallPicture smallPicture(const core::Image& radiance, const ViewParams& view)
{
    constexpr uint32_t kWide = kFiner * SmallPicture::kWidth,
                       kHigh = kFiner * SmallPicture::kHeight;
    const double proportion = static_cast<double>(radiance.width) / radiance.height;
    const double wanted = static_cast<double>(kWide) / kHigh;
    const glm::dvec2 half =
        0.5 * glm::min(glm::dvec2(1), {wanted / proportion, proportion / wanted});
    const core::Image fine = boxMeans(radiance, 0.5 - half, 0.5 + half, kWide, kHigh);
    shared::DisplaySettings settings{};
    settings.width = kWide;
    settings.height = kHigh;
    settings.show = shared::kShowRadiance;
    settings.exposure = view.exposure;
    settings.tone = static_cast<uint32_t>(view.tone);
    const std::vector<uint8_t> seen = core::displayImage(&fine, nullptr, settings);

    SmallPicture small;
    for (uint32_t y = 0; y < SmallPicture::kHeight; ++y)
        for (uint32_t x = 0; x < SmallPicture::kWidth; ++x)
            for (uint32_t c = 0; c < 3; ++c) {
                uint32_t sum = 0;
                for (uint32_t v = y * kFiner; v < (y + 1) * kFiner; ++v)
                    for (uint32_t u = x * kFiner; u < (x + 1) * kFiner; ++u)
                        sum += seen[4 * (size_t(v) * kWide + u) + c];
                constexpr uint32_t kCount = kFiner * kFiner;
                small.bytes.push_back(static_cast<uint8_t>((sum + kCount / 2) / kCount));
            }
    return small;
}

ScenePictures::ScenePictures(const fs::path& cacheFolder)
    : folder_(cacheFolder, "picture", kMostBytes)
{}

void ScenePictures::keep(const fs::path& scene, const SmallPicture& picture) const
{
    const std::string key = keyOf(scene);
    if (picture) folder_.write(bytesOf(key), std::as_bytes(std::span(picture.bytes)));
}

SmallPicture ScenePictures::find(const fs::path& scene) const
{
    const std::string key = keyOf(scene);
    const std::vector<std::byte> data = folder_.read(bytesOf(key));
    SmallPicture picture;
    if (data.size() != 3 * SmallPicture::kWidth * SmallPicture::kHeight) return picture;
    for (const std::byte b : data) picture.bytes.push_back(static_cast<uint8_t>(b));
    return picture;
}

}  // namespace app

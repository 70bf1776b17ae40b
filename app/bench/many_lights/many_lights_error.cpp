// See many_lights_error.h.
#include "app/bench/many_lights/many_lights_error.h"

#include <cmath>

#include "core/base/check.h"
#include "core/image/metrics.h"
#include "shared/tonemap.h"

namespace app::many_lights {

namespace {

std::array<float, 256> displayTable()
{
    std::array<float, 256> table{};
    for (size_t i = 0; i < table.size(); ++i)
        table[i] = std::pow(shared::srgbDecode(static_cast<float>(i) / 255), 1 / 2.2f);
    return table;
}

}  // namespace

glm::vec3 displayed(const glm::vec3& radiance, double exposure)
{
    static const std::array<float, 256> table = displayTable();
    const glm::vec3 linear = shared::expose(radiance, static_cast<float>(exposure));
    glm::vec3 result;
    for (int c = 0; c < 3; ++c)
        result[c] = table[static_cast<size_t>(std::lround(255 * shared::srgbEncode(linear[c])))];
    return result;
}

LightErrors errorsOf(std::span<const glm::vec3> picture, std::span<const glm::vec3> reference,
                     double exposure)
{
    CHECK(picture.size() == reference.size() && !picture.empty());
    LightErrors sum;
    for (size_t i = 0; i < picture.size(); ++i) {
        const glm::dvec3 seen(displayed(picture[i], exposure) - displayed(reference[i], exposure));
        const glm::dvec3 b(reference[i]), d = glm::dvec3(picture[i]) - b;
        sum.rmse8 += glm::dot(seen, seen);
        sum.rmse += glm::dot(d, d);
        const glm::dvec3 relative = d * d / (b * b + core::kRelMseFloor);
        sum.relMse += relative.x + relative.y + relative.z;
    }
    const double n = 3 * double(picture.size());
    return {std::sqrt(sum.rmse8 / n), std::sqrt(sum.rmse / n), sum.relMse / n};
}

double clippedShare(std::span<const glm::vec3> picture, double exposure)
{
    size_t clipped = 0;
    for (const glm::vec3& v : picture) {
        const glm::vec3 linear = shared::expose(v, static_cast<float>(exposure));
        for (int c = 0; c < 3; ++c) clipped += linear[c] > 1 ? 1u : 0u;
    }
    return picture.empty() ? 0 : double(clipped) / (3 * double(picture.size()));
}

}  // namespace app::many_lights

// Pictures of a part of the frame, each beside its difference to all lights. See
// many_lights_measure.h.
#include <algorithm>
#include <cmath>
#include <map>

#include "app/bench/many_lights/many_lights_error.h"
#include "app/bench/many_lights/many_lights_measure.h"
#include "core/base/check.h"
#include "core/image/image.h"

namespace app::many_lights {

namespace {

constexpr uint32_t kTile = 32;    // pixels, in which errors are summed to find a place to show
constexpr float kDifference = 8;  // by which differences are multiplied
constexpr uint32_t kSides[] = {128, 96, 64, 48, 32, 16};

/// The middle of the tile in which two pictures of the subset differ most.
glm::uvec2 worstPlace(const Subset& subset, glm::uvec2 size, std::span<const glm::vec3> a,
                      std::span<const glm::vec3> b, double exposure)
{
    std::map<std::pair<uint32_t, uint32_t>, float> tiles;
    for (size_t i = 0; i < subset.pixels.size(); ++i) {
        const glm::vec3 d = displayed(a[i], exposure) - displayed(b[i], exposure);
        tiles[{subset.pixels[i] % size.x / kTile, subset.pixels[i] / size.x / kTile}] +=
            glm::dot(d, d);
    }
    const auto worst = std::ranges::max_element(tiles, {}, [](const auto& t) { return t.second; });
    return {worst->first.first * kTile + kTile / 2, worst->first.second * kTile + kTile / 2};
}

/// A window around `place` that lies within a picture of that size.
glm::uvec2 cornerAround(glm::uvec2 place, glm::uvec2 window, glm::uvec2 size)
{
    const glm::ivec2 corner = glm::ivec2(place) - glm::ivec2(window / 2u);
    return glm::uvec2(glm::clamp(corner, glm::ivec2(0), glm::ivec2(size - window)));
}

core::Image partOf(const Subset& subset, std::span<const glm::vec3> values, uint32_t width,
                   glm::uvec2 corner, glm::uvec2 size)
{
    core::Image image(size.x, size.y, 3);
    for (size_t i = 0; i < subset.pixels.size(); ++i) {
        const glm::uvec2 at(subset.pixels[i] % width, subset.pixels[i] / width);
        if (glm::any(glm::lessThan(at, corner)) ||
            glm::any(glm::greaterThanEqual(at, corner + size)))
            continue;
        for (int c = 0; c < 3; ++c) image.at(at.x - corner.x, at.y - corner.y)[c] = values[i][c];
    }
    return image;
}

/// Grey where two displays agree, brighter or darker where the picture is.
std::vector<uint8_t> differenceBytes(const core::Image& picture, const core::Image& reference,
                                     double exposure)
{
    std::vector<uint8_t> bytes;
    for (size_t i = 0; i < picture.pixels.size(); i += 3) {
        const auto at = [i](const core::Image& image) {
            return glm::vec3(image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]);
        };
        const glm::vec3 d = displayed(at(picture), exposure) - displayed(at(reference), exposure);
        for (int c = 0; c < 3; ++c)
            bytes.push_back(static_cast<uint8_t>(
                std::lround(255 * glm::clamp(0.5f + kDifference * d[c], 0.0f, 1.0f))));
    }
    return bytes;
}

}  // namespace

/// Chooses the place, and lights it by the main methods; what a stop left out is not there.
void Measurement::takeShots(size_t index)
{
    const auto caseNamed = [this](const std::string& name) -> const Case* {
        for (const Case& c : cases_)
            if (c.method->name == name && c.clusters == o_.mainClusters) return &c;
        return nullptr;
    };
    const Case* full = caseNamed("full");
    if (full == nullptr || pictures_.empty()) return;
    const Case* other = caseNamed("matching") != nullptr ? caseNamed("matching") : full;
    const std::span<const glm::vec3> shown = pictures_[size_t(other - cases_.data())],
                                     compared = other == full
                                                    ? std::span<const glm::vec3>(reference_->values)
                                                    : pictures_[size_t(full - cases_.data())];
    const glm::uvec2 place = worstPlace(subset_, scene_.size, shown, compared, o_.exposure);
    const auto points = lit_->points(o_.params.sliceSize);
    for (const uint32_t side : kSides) {
        scene_.shotSize = glm::min(glm::uvec2(side), scene_.size);
        scene_.shotCorner = cornerAround(place, scene_.shotSize, scene_.size);
        shown_ = subsetAround(*points, lit_->perPixel(), scene_.size.x, scene_.shotCorner,
                              scene_.shotSize);
        if (shown_.receivers <= std::max<size_t>(subset_.receivers, 2 * o_.receivers)) break;
    }
    tools_.progress(about("pictures"));
    shownReference_ = lightsReference(*lit_, shown_, o_.scenes[index].at, referenceFile("-part"));
    if (!shownReference_) return;
    std::error_code error;
    std::filesystem::create_directories(o_.output / "pictures", error);
    std::vector<std::string> done;
    for (const Case& c : cases_) {
        if (c.clusters != o_.mainClusters || !c.method->packets ||
            c.method->sweep == Sweep::uniform || c.method->sweep == Sweep::highRate ||
            std::ranges::find(done, c.method->name) != done.end())
            continue;
        if (done.empty() && !addShot("reference", c.params, true)) return;
        if (!addShot(c.method->name, c.params, c.method->packets)) return;
        done.emplace_back(c.method->name);
    }
}

/// False: stopped.
bool Measurement::addShot(const std::string& name, const core::ManyLightsParams& params,
                          bool packets)
{
    namespace fs = std::filesystem;
    const bool isReference = name == "reference";
    std::optional<Lit> lit;
    if (!isReference) {
        tools_.progress(about("picture, " + name));
        lit = lit_->light(params, packets, lit_->lights(), shown_, o_.params.seed);
        if (!lit) return false;
    }
    const auto part = [this](std::span<const glm::vec3> values) {
        return partOf(shown_, values, scene_.size.x, scene_.shotCorner, scene_.shotSize);
    };
    const core::Image reference = part(shownReference_->values),
                      picture = isReference ? reference : part(lit->values);
    const core::Metadata metadata{{"Software", "rekindle bench manylights"}};
    const fs::path stem = fs::path("pictures") / (scene_.name + '-' + name);
    Shot shot{name, 0, stem.string() + ".png", {}};
    core::writePng(o_.output / shot.file, picture, static_cast<float>(o_.exposure),
                   static_cast<uint32_t>(Tone::linear), metadata);
    if (!isReference) {
        shot.rmse8 = errorsOf(lit->values, shownReference_->values, o_.exposure).rmse8;
        shot.difference = stem.string() + "-difference.png";
        core::writePngBytes(o_.output / shot.difference, picture.width, picture.height, 3,
                            differenceBytes(picture, reference, o_.exposure), metadata);
    }
    scene_.shots.push_back(shot);
    return true;
}

}  // namespace app::many_lights

// Pictures of the last frame, all as bright as each other, and the part of them where the noise of
// Discard shows most. See flight_measure.h.
#include <algorithm>
#include <cmath>

#include "app/bench/bench_clock.h"
#include "app/bench/flythrough/flight_measure.h"
#include "core/image/metrics.h"

namespace app::flight {

namespace {

constexpr uint32_t kMostAtOnce = 16;  // n of Discard in as much time

/// The upper left corner of the part in which `picture` is furthest from the reference: relative
/// squared error, at most one for each value, so that single bright pixels do not decide.
glm::uvec2 noisiest(const core::Image& picture, const core::Image& reference, glm::uvec2 part)
{
    const auto errorOf = [&](uint32_t x, uint32_t y) {
        double sum = 0;
        for (uint32_t c = 0; c < 3; ++c) {
            const auto r = static_cast<double>(reference.at(x, y)[c]),
                       d = static_cast<double>(picture.at(x, y)[c]) - r;
            sum += std::min(1.0, d * d / (r * r + 0.01));
        }
        return sum;
    };
    const uint32_t stride = std::max(1u, part.x / 4);
    double most = -1;
    glm::uvec2 best(0);
    for (uint32_t y0 = 0; y0 + part.y <= picture.height; y0 += stride)
        for (uint32_t x0 = 0; x0 + part.x <= picture.width; x0 += stride) {
            double sum = 0;
            for (uint32_t y = y0; y < y0 + part.y; ++y)
                for (uint32_t x = x0; x < x0 + part.x; ++x) sum += errorOf(x, y);
            if (sum > most) {
                most = sum;
                best = {x0, y0};
            }
        }
    return best;
}

core::Image partOf(const core::Image& picture, glm::uvec2 corner, glm::uvec2 size)
{
    core::Image part(size.x, size.y, picture.channels);
    for (uint32_t y = 0; y < size.y; ++y)
        std::copy_n(picture.at(corner.x, corner.y + y), size_t(size.x) * picture.channels,
                    part.at(0, y));
    return part;
}

}  // namespace

void Measurement::addShot(const std::string& name, uint32_t samples, const Landing& landing)
{
    namespace fs = std::filesystem;
    Shot shot{name, samples, landing.seconds, 0, {}, {}};
    shot.relMse =
        name == "reference"
            ? scene_.referenceRelMse
            : core::imageErrors(landing.picture, reference_->mean).relMse - scene_.referenceRelMse;
    const std::string stem =
        scene_.name + '-' + name + (samples > 1 ? '-' + std::to_string(samples) : "");
    shot.file = fs::path("pictures") / (stem + ".png");
    shot.part = fs::path("pictures") / (stem + "-part.png");
    const auto exposure = static_cast<float>(o_.exposure);
    const auto tone = static_cast<uint32_t>(Tone::agx);
    const core::Metadata metadata{{"Software", "rekindle bench flythrough"}};
    core::writePng(o_.output / shot.file, landing.picture, exposure, tone, metadata);
    core::writePng(o_.output / shot.part, partOf(landing.picture, corner_, part_), exposure, tone,
                   metadata);
    scene_.shots.push_back(shot);
}

/// After the cell that they show.
void Measurement::takeShots(const Cells& cells)
{
    std::error_code error;
    std::filesystem::create_directories(o_.output / "pictures", error);
    const Cell& discard = discard_.at(1);
    part_ = glm::max(scene_.size / 3u, glm::min(scene_.size, glm::uvec2(16)));
    corner_ = noisiest(discard.first, reference_->mean, part_);
    addShot("reference", 1, {reference_->mean, 0, 0});
    const std::string name(core::enumName(core::ReuseStrategy::discard));
    const double seconds = median(discard.seconds);
    addShot(name, 1, {discard.first, 0, seconds});
    // As many paths as fit into the time of the slowest that keeps samples.
    double longest = 0;
    for (const auto& [strategy, cell] : cells) longest = std::max(longest, median(cell.seconds));
    const auto n =
        static_cast<uint32_t>(std::clamp(std::round(longest / seconds), 1.0, double(kMostAtOnce)));
    if (n > 1) {
        const auto landing = fly(paramsOf(name), scene_.shownStep, 2, n);
        if (!landing) return;
        addShot(name, n, *landing);
    }
    for (const std::string& strategy : results_.strategies) {
        const auto cell = cells.find(strategy);
        if (cell != cells.end())
            addShot(strategy, 1, {cell->second.first, 0, median(cell->second.seconds)});
    }
}

}  // namespace app::flight

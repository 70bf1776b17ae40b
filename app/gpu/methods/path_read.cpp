// What comes back from the device: the film, its mean, first hits, statistics.
#include "app/gpu/methods/path_renderer.h"

#include <algorithm>

#include "core/base/time.h"

namespace gpu {

namespace {

constexpr uint32_t kBandTiles = 1u << 12;  // of first hits on their way back: 12 MiB

/// Three words per pixel, as aov.comp writes them, from `firstPixel` on.
void storeBand(const std::vector<glm::vec4>& words, size_t firstPixel, core::Aovs& aovs)
{
    for (size_t i = 0; i < words.size() / 3; ++i) {
        const glm::vec4 a = words[3 * i], b = words[3 * i + 1], c = words[3 * i + 2];
        const size_t p = firstPixel + i;
        aovs.depth.pixels[p] = a.x;
        for (int k = 0; k < 3; ++k) {
            aovs.normal.pixels[3 * p + size_t(k)] = a[k + 1];
            aovs.albedo.pixels[3 * p + size_t(k)] = b[k];
            aovs.ids.pixels[3 * p + size_t(k)] = c[k];
        }
    }
}

}  // namespace

/// Samples that a pixel has had: tiles of the round under way are ahead of the others.
uint64_t PathRenderer::pixelSamples(size_t pixel) const
{
    const size_t x = pixel % frame_.settings.imageWidth, y = pixel / frame_.settings.imageWidth;
    return samples_ + (y / 8 * frame_.tilesPerRow + x / 8 < nextTile_ ? roundSamples_ : 0);
}

core::Estimate PathRenderer::read(core::Reading what)
{
    CHECK(current_ != nullptr && samples_ <= ~0u);
    const auto start = core::Clock::now();
    const uint32_t width = frame_.settings.imageWidth, height = frame_.settings.imageHeight;
    core::Estimate estimate;
    estimate.mean = core::Image(width, height, 3);
    estimate.samples = samples_;
    estimate.counters = filmCounters_;
    if (what == core::Reading::everything) {
        estimate.variance = core::Image(width, height, 3);
        estimate.weight = core::Image(width, height, 1);
        readFilm(estimate);
    } else {
        readMean(estimate.mean);
    }
    stats_.readbackSeconds += core::secondsSince(start);
    return estimate;
}

void PathRenderer::readFilm(core::Estimate& estimate)
{
    const size_t pixels = estimate.weight.pixels.size();
    std::array<std::vector<glm::vec4>, 3> words;
    for (uint32_t i = 0; i < 3; ++i) {
        words[i].resize(pixels);
        film_[i].read(std::as_writable_bytes(std::span(words[i])));
    }
    for (size_t p = 0; p < pixels; ++p) {
        const double n = double(pixelSamples(p));
        estimate.weight.pixels[p] = static_cast<float>(n);
        if (n == 0) continue;
        const glm::dvec4 a = words[0][p], b = words[1][p], c = words[2][p];
        const glm::dvec3 mean = (glm::dvec3(a.x, a.y, a.z) - glm::dvec3(a.w, b.x, b.y)) / n;
        const glm::dvec3 squares = (glm::dvec3(b.z, b.w, c.x) - glm::dvec3(c.y, c.z, c.w)) / n;
        for (int k = 0; k < 3; ++k) {
            estimate.mean.pixels[3 * p + size_t(k)] = static_cast<float>(mean[k]);
            // As core::Film::varianceOfMean.
            if (n > 1)
                estimate.variance.pixels[3 * p + size_t(k)] =
                    static_cast<float>(std::max(squares[k] - mean[k] * mean[k], 0.0) / (n - 1));
        }
    }
}

/// The buffer that kernels write results of their own to: kept, and bound where they look for it.
const Buffer& PathRenderer::outputBuffer(uint64_t bytes)
{
    if (output_.bytes() < bytes) {
        for (Bindings& bindings : bindings_) bindings.unbind(shared::kBindOutput);
        output_ = {};
        output_ = Buffer(device_, "the results", bytes);
        bindAll(shared::kBindOutput, output_);
    }
    return output_;
}

void PathRenderer::readMean(core::Image& mean)
{
    const uint64_t pixels = mean.pixels.size() / 3;
    const Buffer& output = outputBuffer(pixels * sizeof(glm::vec3));
    constexpr uint32_t kMostGroups = 1u << 15;  // of one dispatch; every device takes twice that
    device_.submit(
        [&](VkCommandBuffer commands) {
            const auto groups =
                static_cast<uint32_t>((pixels + shared::kGroupSize - 1) / shared::kGroupSize);
            for (uint32_t first = 0; first < groups; first += kMostGroups) {
                const uint32_t count = std::min(kMostGroups, groups - first);
                dispatch(commands, mean_, bindings_[0],
                         {first, count, nextTile_, static_cast<uint32_t>(samples_), roundSamples_},
                         count * shared::kGroupSize);
            }
            barrier(commands);
        },
        "the mean");
    output.read(std::as_writable_bytes(std::span(mean.pixels)));
}

/// First hits are found in bands of rows, each in pieces that hold the device no longer than the
/// pace allows.
core::Aovs PathRenderer::aovs()
{
    CHECK(current_ != nullptr);
    const uint32_t width = frame_.settings.imageWidth, height = frame_.settings.imageHeight;
    core::Aovs aovs{core::Image(width, height, 1), core::Image(width, height, 3),
                    core::Image(width, height, 3), core::Image(width, height, 3)};
    const uint32_t tilesPerRow = frame_.tilesPerRow, tileRows = (height + 7) / 8;
    const uint32_t band = std::clamp(kBandTiles / tilesPerRow, 1u, tileRows);
    const Buffer& output =
        outputBuffer(uint64_t(width) * std::min(8 * band, height) * 3 * sizeof(glm::vec4));
    const Pipeline& aovKernel = kernel(&Kernels::aov);
    std::vector<glm::vec4> words;
    BatchPace pace;
    for (uint32_t row = 0; row < tileRows; row += band) {
        const uint32_t firstPixel = 8 * row * width,
                       pixels = std::min(8 * (row + band), height) * width - firstPixel;
        const uint32_t end = std::min(row + band, tileRows) * tilesPerRow;
        for (uint32_t tile = row * tilesPerRow; tile < end;) {
            const uint32_t most = (end - tile) * shared::kGroupSize;
            const uint32_t lanes = pace.lanes(pace_.dispatchSeconds, most);
            const shared::Batch batch{tile, lanes / shared::kGroupSize, firstPixel, 1, 0};
            pace.measured(lanes, device_.submit(
                                     [&](VkCommandBuffer commands) {
                                         dispatch(commands, aovKernel, bindings_[0], batch, lanes);
                                         barrier(commands);
                                     },
                                     workOf("first hits", batch)));
            tile += batch.tileCount;
        }
        words.resize(size_t(pixels) * 3);
        output.read(std::as_writable_bytes(std::span(words)));
        storeBand(words, firstPixel, aovs);
    }
    return aovs;
}

core::RenderStats PathRenderer::stats() const
{
    core::RenderStats stats = stats_;
    const uint64_t width = frame_.settings.imageWidth, height = frame_.settings.imageHeight;
    stats.paths = samples_ * width * height + uint64_t(nextTile_) * roundSamples_ * 64;
    stats.peakDeviceBytes = device_.peakBytes;
    return stats;
}

}  // namespace gpu

// What comes back from the device: the film, its mean, first hits, statistics.
#include "app/gpu/methods/path_renderer.h"

#include <algorithm>

namespace gpu {

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

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

void PathRenderer::readFilm(core::Film& film)
{
    const auto start = Clock::now();
    film.reset(frame_.settings.imageWidth, frame_.settings.imageHeight);
    if (samples() == 0) return;
    film.samples = samples_;
    film.counters = filmCounters_;
    const size_t pixels = film.sum.size();
    std::array<std::vector<glm::vec4>, 3> words;
    for (uint32_t i = 0; i < 3; ++i) {
        words[i].resize(pixels);
        film_[i].read(std::as_writable_bytes(std::span(words[i])));
    }
    for (size_t p = 0; p < pixels; ++p) {
        const glm::dvec4 a = words[0][p], b = words[1][p], c = words[2][p];
        film.sum[p] = glm::dvec3(a.x, a.y, a.z) - glm::dvec3(a.w, b.x, b.y);
        film.sumOfSquares[p] = glm::dvec3(b.z, b.w, c.x) - glm::dvec3(c.y, c.z, c.w);
    }
    stats_.readbackSeconds += since(start);
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
    CHECK(current_ != nullptr && samples_ <= ~0u);
    const auto start = Clock::now();
    mean = core::Image(frame_.settings.imageWidth, frame_.settings.imageHeight, 3);
    if (samples() == 0) return;
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
                         {first, count, 0, static_cast<uint32_t>(samples_), 0},
                         count * shared::kGroupSize);
            }
            barrier(commands);
        },
        "the mean");
    output.read(std::as_writable_bytes(std::span(mean.pixels)));
    stats_.readbackSeconds += since(start);
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
    stats.paths = samples() * frame_.settings.imageWidth * frame_.settings.imageHeight;
    stats.peakDeviceBytes = device_.peakBytes;
    return stats;
}

}  // namespace gpu

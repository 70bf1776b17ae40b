// See preview_shading.h.
#include "app/pictures/preview_shading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "app/pictures/edge_cuts.h"
#include "app/pictures/pixel_rays.h"
#include "core/base/parallel.h"
#include "shared/tonemap.h"

namespace app {

namespace {

constexpr float kDarkest = 0.15f;  // of a surface seen edge on
constexpr float kGrey = 0.1f;      // share of grey in reflectances: black things are seen, too
const glm::vec3 kEmptySpace(0.03f), kEmitter(1.5f);

glm::vec3 vectorAt(const core::Image& image, uint32_t x, uint32_t y)
{
    const float* v = image.at(x, y);
    return {v[0], v[1], v[2]};
}

/// What a lamp at the camera makes of the surface in a pixel.
glm::vec3 lit(const core::Aovs& aovs, const PixelRays& rays, uint32_t x, uint32_t y)
{
    const float facing = std::abs(glm::dot(vectorAt(aovs.normal, x, y), rays.direction(x, y)));
    return (kDarkest + (1 - kDarkest) * facing) *
           glm::mix(vectorAt(aovs.albedo, x, y), glm::vec3(0.5f), kGrey);
}

/// Whether pixels and those after them, in the four directions, show one surface, one byte each.
/// Rows have a pixel more on either side, and there is one row more above: what is beside the image
/// is like nothing.
class Links {
public:
    explicit Links(glm::uvec2 size) : size_(size), stride_(size.x + 2)
    {
        for (Bytes& of : alike_) of.resize(stride_ * (size_t(size.y) + 1));
    }

    /// `tell` says of `count` pixels from the index `first` on whether they are alike with those
    /// `offset` behind them.
    template <class Tell> void makeRow(uint32_t y, const Tell& tell)
    {
        const size_t first = size_t(y) * size_.x, at = index(0, y), w = size_.x;
        if (w == 0) return;
        tell(first, w, size_t(0), &alike_[kSelf][at]);
        tell(first, w - 1, size_t(1), &alike_[kRight][at]);
        if (y + 1 == size_.y) return;
        tell(first + 1, w - 1, w - 1, &alike_[kBelowLeft][at + 1]);
        tell(first, w, w, &alike_[kBelow][at]);
        tell(first, w - 1, w + 1, &alike_[kBelowRight][at]);
    }

    /// Bit 3 (dy + 1) + dx + 1 tells of the neighbour at (dx, dy).
    void bitsOfRow(uint32_t y, float* bits) const
    {
        const auto from = [&](Direction d, size_t back) {
            return alike_[d].data() + index(0, y) - back;
        };
        const uint8_t *self = from(kSelf, 0), *right = from(kRight, 0), *left = from(kRight, 1),
                      *belowLeft = from(kBelowLeft, 0), *below = from(kBelow, 0),
                      *belowRight = from(kBelowRight, 0),
                      *aboveRight = from(kBelowLeft, stride_ - 1), *above = from(kBelow, stride_),
                      *aboveLeft = from(kBelowRight, stride_ + 1);
        for (size_t x = 0; x < size_.x; ++x) {
            bits[x] = static_cast<float>(aboveLeft[x] | above[x] << 1 | aboveRight[x] << 2 |
                                         left[x] << 3 | self[x] << 4 | right[x] << 5 |
                                         belowLeft[x] << 6 | below[x] << 7 | belowRight[x] << 8);
        }
    }

private:
    enum Direction { kSelf, kRight, kBelowLeft, kBelow, kBelowRight, kDirections };
    using Bytes = std::vector<uint8_t>;

    size_t index(uint32_t x, uint32_t y) const { return (size_t(y) + 1) * stride_ + 1 + x; }

    glm::uvec2 size_;
    size_t stride_;
    std::array<Bytes, kDirections> alike_;
};

/// Which neighbours of each pixel are alike; see Links::makeRow.
template <class Tell> core::Image guideOf(glm::uvec2 size, const Tell& tell)
{
    constexpr size_t kRows = 16;
    core::Image guide(size.x, size.y, 1);
    if (guide.pixels.empty()) return guide;
    Links links(size);
    core::parallelFor(size.y, kRows, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) links.makeRow(static_cast<uint32_t>(y), tell);
    });
    core::parallelFor(size.y, kRows, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            links.bitsOfRow(static_cast<uint32_t>(y), guide.at(0, static_cast<uint32_t>(y)));
    });
    return guide;
}

/// What first hits tell of surfaces, a number to a plane, so that eight pairs are compared at a
/// time.
class Seen {
public:
    explicit Seen(const core::Aovs& aovs) : depth_(aovs.depth.pixels)
    {
        const size_t count = depth_.size();
        kind_.resize(count);
        for (auto& plane : normal_) plane.resize(count);
        core::parallelFor(count, 1u << 14, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                const float *ids = &aovs.ids.pixels[3 * i], *n = &aovs.normal.pixels[3 * i];
                kind_[i] = ids[2] < 0 ? ids[1] : -3 - ids[1];
                for (size_t c = 0; c < 3; ++c) normal_[c][i] = n[c];
            }
        });
    }

    void operator()(size_t first, size_t count, size_t offset, uint8_t* alike) const
    {
        const auto from = [first](const std::vector<float>& plane) { return plane.data() + first; };
        const float *d = from(depth_), *k = from(kind_), *nx = from(normal_[0]),
                    *ny = from(normal_[1]), *nz = from(normal_[2]);
        for (size_t i = 0; i < count; ++i) {
            const size_t j = i + offset;
            const float low = std::min(d[i], d[j]), high = std::max(d[i], d[j]),
                        turn = nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j];
            const int near = (high < 1.25f * low), level = (turn > 0.9f), one = (k[i] == k[j]);
            const int seen = (d[i] > 0), seenToo = (d[j] > 0);
            alike[i] = static_cast<uint8_t>(((seen | seenToo) ^ 1) |
                                            (seen & seenToo & near & level & one));
        }
    }

private:
    const std::vector<float>& depth_;
    std::vector<float> kind_;  // the material, and whether it emits
    std::array<std::vector<float>, 3> normal_;
};

void store(core::Image& image, uint32_t x, uint32_t y, glm::vec3 value)
{
    for (int c = 0; c < 3; ++c) image.at(x, y)[c] = value[c];
}

}  // namespace

bool fits(const core::Aovs& aovs, const core::Image& image)
{
    const auto same = [&](const core::Image& other, uint32_t channels) {
        return other.width == image.width && other.height == image.height &&
               other.channels == channels && !other.pixels.empty();
    };
    return same(aovs.depth, 1) && same(aovs.normal, 3) && same(aovs.albedo, 3) && same(aovs.ids, 3);
}

core::Image litFromCamera(const core::Aovs& aovs, const core::Camera& camera)
{
    core::Image image(aovs.depth.width, aovs.depth.height, 3);
    const PixelRays rays(camera, image.width, image.height);
    for (uint32_t y = 0; y < image.height; ++y)
        for (uint32_t x = 0; x < image.width; ++x) {
            const bool nothing = !(*aovs.depth.at(x, y) > 0);
            const bool emits = aovs.ids.at(x, y)[2] >= 0;
            store(image, x, y, nothing ? kEmptySpace : emits ? kEmitter : lit(aovs, rays, x, y));
        }
    return image;
}

void fillUnlit(core::Image& mean, const core::Aovs& aovs, const core::Camera& camera)
{
    double sum = 0;
    const size_t count = size_t(mean.width) * mean.height;
    for (size_t i = 0; i < count; ++i) {
        const float* p = &mean.pixels[3 * i];
        const float luminance = shared::luminance({p[0], p[1], p[2]});
        if (std::isfinite(luminance)) sum += static_cast<double>(luminance);
    }
    const auto level = static_cast<float>(sum / static_cast<double>(count));
    if (!(level > 0)) return;
    const PixelRays rays(camera, mean.width, mean.height);
    for (uint32_t y = 0; y < mean.height; ++y)
        for (uint32_t x = 0; x < mean.width; ++x)
            if (*aovs.depth.at(x, y) > 0 && vectorAt(mean, x, y) == glm::vec3(0))
                store(mean, x, y, level * lit(aovs, rays, x, y));
}

core::Image surfaceGuide(const core::Aovs& aovs)
{
    core::Image guide = guideOf({aovs.depth.width, aovs.depth.height}, Seen(aovs));
    addCuts(guide);
    return guide;
}

}  // namespace app

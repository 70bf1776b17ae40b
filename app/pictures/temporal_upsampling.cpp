// See temporal_upsampling.h.
#include "app/pictures/temporal_upsampling.h"

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "shared/tonemap.h"

namespace app {

namespace {

// Samples that what is kept may stand for. A point counts one in the middle of its pixel.
constexpr float kMost = 2;
constexpr float kLeast = 0.02f;   // what counts at least: light changes between points, too
constexpr float kReach = 1.25f;   // pixels from a point within which it counts more than that
constexpr float kCertain = 0.5f;  // and within which it alone tells what is there
// Of what is kept, as far as it differs from the mean of the light around: so much stays each time
// where that is noise, and so many standard deviations at most. Cutting it off at one leaves as
// little error, and is a tenth too dark where noise is as skewed as an exponential.
constexpr float kTrust = 0.85f, kSpread = 3;
constexpr float kTold = 2;  // how soon the light before is believed to tell detail from noise
constexpr float kSlopeOff = 1.5f;  // pixels by which one place may seem two on a slope

/// The smaller step of the two to the neighbours that show the same surface.
float slopeOf(float before, bool isBefore, float here, float after, bool isAfter)
{
    const float a = here - before, b = after - here;
    if (!isBefore || !isAfter) return isBefore ? a : isAfter ? b : 0;
    return std::abs(a) < std::abs(b) ? a : b;
}

glm::vec3 radianceAt(const core::Image& image, size_t pixel)
{
    const float* p = &image.pixels[3 * pixel];
    return {p[0], p[1], p[2]};
}

}  // namespace

/// A pixel of the small picture, at whose point `nearness` is known.
struct TemporalUpsampler::Sample {
    glm::vec3 radiance;
    float nearness;
    glm::vec2 slope;   // of nearness, from pixel to pixel
    float slack;       // of nearness, from how far a place may be off on that slope
    uint32_t surface;  // packSurface()
    uint32_t alike;    // as surfaceGuide() says
    float surprise;    // squared luminance that the light before was off by; negative: none was
    glm::vec3 mean;    // of the light around
    float trust;       // in what is kept, as far as it differs from that
    glm::vec3 reach;   // by which it may differ

    bool isLike(int dx, int dy) const { return ((alike >> (4 + 3 * dy + dx)) & 1) != 0; }
};

TemporalUpsampler::TemporalUpsampler() = default;
TemporalUpsampler::~TemporalUpsampler() = default;

void TemporalUpsampler::forget()
{
    places_.clear();
}

/// The pixels of one picture.
class TemporalUpsampler::Step {
public:
    Step(const TemporalUpsampler& of, const Seen& seen);

    /// Sample::surprise, and from those of the samples around its bounds.
    float surpriseAt(const Sample& sample) const;
    void findBounds(Sample& sample) const;

    void row(uint32_t y, SeenPlace* places, float* radiance) const;

private:
    struct Column {
        int pixel;   // of the small picture, in whose part of the film this is
        int beside;  // the one on the other side of it: -1, 1
        float away;  // from its point, pixels
    };
    /// A pixel of the full size: where it is on the film, and by what points around.
    struct Here {
        glm::vec3 direction;
        const Sample* own;
        int dx, dy;
        glm::vec2 away;  // from the point, pixels of the small picture
    };

    /// What is there, by a point that tells of it.
    struct Told {
        const Sample* sample = nullptr;
        float nearness = 0;
        Look look;
    };

    Column columnOf(uint32_t x, int full, int small, float shift) const;
    Told findOnEdge(const Here& here) const;
    bool isTold(const Sample& own, uint32_t surface) const;
    bool findUntold(const Here& here, const Look& told, SeenPlace& place) const;
    glm::vec3 between(const Here& here) const;
    SeenPlace make(const Here& here) const;

    SeenBefore before_;
    const std::vector<Sample>& samples_;
    glm::ivec2 full_, small_;
    glm::vec2 ratio_;              // of their sizes
    glm::vec2 shift_;              // pixels of the small picture
    std::vector<Column> columns_;  // of the full size
};

TemporalUpsampler::Step::Step(const TemporalUpsampler& of, const Seen& seen)
    : before_(of.before_, of.size_, of.camera_, seen.camera, of.count_), samples_(of.samples_),
      full_(of.size_), small_(seen.mean.width, seen.mean.height),
      ratio_(glm::vec2(full_) / glm::vec2(small_)),
      shift_(glm::vec2(seen.camera.shift) * glm::vec2(0.5f, -0.5f) * glm::vec2(small_))
{
    for (uint32_t x = 0; x < of.size_.x; ++x)
        columns_.push_back(columnOf(x, full_.x, small_.x, shift_.x));
}

TemporalUpsampler::Step::Column TemporalUpsampler::Step::columnOf(uint32_t x, int full, int small,
                                                                  float shift) const
{
    const float at =
        (static_cast<float>(x) + 0.5f) * static_cast<float>(small) / static_cast<float>(full) -
        shift - 0.5f;
    const int pixel = std::clamp(static_cast<int>(std::floor(at + 0.5f)), 0, small - 1);
    const float away = at - static_cast<float>(pixel);
    return {pixel, away < 0 ? -1 : 1, away};
}

/// Whether a pixel of the small picture or one beside it shows such a surface.
bool TemporalUpsampler::Step::isTold(const Sample& own, uint32_t surface) const
{
    const int i = static_cast<int>(&own - samples_.data()), x = i % small_.x, y = i / small_.x;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, small_.y - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, small_.x - 1); ++u)
            if (oneSurface(samples_[static_cast<size_t>(v * small_.x + u)].surface, surface))
                return true;
    return false;
}

/// Whether a surface that no point around tells of was seen before where these look: as near as
/// theirs, or nearer. Nothing moves in the scene, so what was seen of it is still there.
bool TemporalUpsampler::Step::findUntold(const Here& here, const Look& told, SeenPlace& place) const
{
    if (told.other == nullptr || isTold(*here.own, told.other->surface)) return false;
    const float nearness = before_.nearnessNow(told.other->nearness, here.direction);
    if (!(nearness >= 0)) return false;
    const Look seen = before_.lookUp(here.direction, nearness, told.other->surface, 0);
    if (!seen.picked) return false;
    place = {seen.light, nearness, told.other->surface};
    return true;
}

/// Where the points around show more than one surface: the nearest of them that was seen there
/// before, by chance where the pixels around show it in part; the farthest then. Where none was
/// there is no sample, and the look is that of the own one.
TemporalUpsampler::Step::Told TemporalUpsampler::Step::findOnEdge(const Here& here) const
{
    Told nearest, farthest;
    const int own = static_cast<int>(here.own - samples_.data());
    const glm::ivec2 at(own % small_.x, own / small_.x);
    for (int i = 0; i < 4; ++i) {
        const glm::ivec2 step((i & 1) * here.dx, (i >> 1) * here.dy), to = at + step;
        if (i > 0 && here.own->isLike(step.x, step.y)) continue;
        if (to.x < 0 || to.y < 0 || to.x >= small_.x || to.y >= small_.y) continue;
        const Sample& sample = here.own[step.y * small_.x + step.x];
        const float nearness =
            std::max(sample.nearness + glm::dot(sample.slope, here.away - glm::vec2(step)), 0.0f);
        if (nearest.sample != nullptr && nearness <= nearest.nearness) continue;
        const Look look = before_.lookUp(here.direction, nearness, sample.surface, sample.slack);
        if (i == 0) nearest.look = look;
        if (look.picked)
            nearest = {&sample, nearness, look};
        else if (look.weight > kFewestSeen &&
                 (farthest.sample == nullptr || nearness <= farthest.nearness))
            farthest = {&sample, nearness, look};
    }
    return nearest.sample == nullptr && farthest.sample != nullptr ? farthest : nearest;
}

/// Light between the points around that show the surface of the next one.
glm::vec3 TemporalUpsampler::Step::between(const Here& here) const
{
    const Sample& own = *here.own;
    const float tx = std::min(std::abs(here.away.x), 0.5f),
                ty = std::min(std::abs(here.away.y), 0.5f);
    const int down = here.dy * small_.x;
    const auto light = [&](int dx, int dy, int step) {
        return own.isLike(dx, dy) ? (&own)[step].radiance : own.radiance;
    };
    return (1 - ty) * ((1 - tx) * own.radiance + tx * light(here.dx, 0, here.dx)) +
           ty * ((1 - tx) * light(0, here.dy, down) + tx * light(here.dx, here.dy, down + here.dx));
}

SeenPlace TemporalUpsampler::Step::make(const Here& here) const
{
    const Sample& own = *here.own;
    const glm::vec2 pixels = here.away * ratio_;
    const float distance = glm::dot(pixels, pixels);
    const bool plain =
        own.isLike(here.dx, 0) && own.isLike(0, here.dy) && own.isLike(here.dx, here.dy);
    const bool certain = distance < kCertain * kCertain;
    const float nearness = std::max(own.nearness + glm::dot(own.slope, here.away), 0.0f);
    Told told;
    if (!before_.empty() && (plain || certain)) {
        told.look = before_.lookUp(here.direction, nearness, own.surface, own.slack);
        if (told.look.weight > kFewestSeen) told = {&own, nearness, told.look};
    } else if (!before_.empty()) {
        told = findOnEdge(here);
    }
    SeenPlace place;
    if (!certain && findUntold(here, told.look, place)) return place;
    const float fall = std::max(1 - distance / (kReach * kReach), 0.0f);
    const bool beyond = told.sample != nullptr && told.sample != &own;
    const float weight = beyond ? kLeast : std::max(kLeast, fall * fall);
    place.light = weight * glm::vec4(beyond ? told.sample->radiance : between(here), 1);
    place.nearness = nearness;
    place.surface = own.surface;
    if (told.sample == nullptr) return place;
    const Sample& chosen = *told.sample;
    place.nearness = told.nearness;
    place.surface = chosen.surface;
    const glm::vec4 old = told.look.light;
    const glm::vec3 off = glm::vec3(old) / old.w - chosen.mean,
                    kept =
                        chosen.mean + chosen.trust * glm::clamp(off, -chosen.reach, chosen.reach);
    place.light += std::min(old.w, kMost) * glm::vec4(kept, 1);
    return place;
}

float TemporalUpsampler::Step::surpriseAt(const Sample& sample) const
{
    const int i = static_cast<int>(&sample - samples_.data());
    const glm::vec2 at =
        (glm::vec2(i % small_.x, i / small_.x) + 0.5f + shift_) / glm::vec2(small_);
    const glm::vec3 direction = before_.direction({2 * at.x - 1, 1 - 2 * at.y});
    if (before_.empty()) return -1;
    const Look look = before_.lookUp(direction, sample.nearness, sample.surface, sample.slack);
    if (!(look.weight > kFewestSeen)) return -1;
    const float off = shared::luminance(sample.radiance - glm::vec3(look.light) / look.light.w);
    return off * off;
}

/// The spread of the light around is detail as far as the light before has it, too, and noise or
/// change for the rest: what is kept is trusted the more the better it foretells the points.
void TemporalUpsampler::Step::findBounds(Sample& sample) const
{
    glm::vec3 sum(0), squares(0);
    float count = 0, surprise = 0, surprises = 0;
    for (int k = 0; k < 9; ++k) {
        if (!sample.isLike(k % 3 - 1, k / 3 - 1)) continue;
        const Sample& other = (&sample)[(k / 3 - 1) * small_.x + k % 3 - 1];
        sum += other.radiance;
        squares += other.radiance * other.radiance;
        ++count;
        if (!(other.surprise >= 0)) continue;
        surprise += other.surprise;
        ++surprises;
    }
    const glm::vec3 mean = sum / count;
    const glm::vec3 deviation = glm::sqrt(glm::max(squares / count - mean * mean, glm::vec3(0)));
    const float spread = shared::luminance(deviation);
    const float wrong = surprises > 0 && spread > 0 ? surprise / (surprises * spread * spread) : 1;
    const float told = std::clamp(kTold * (1 - wrong), 0.0f, 1.0f);
    sample.mean = mean;
    sample.trust = kTrust + (1 - kTrust) * told;
    // One or two tell no spread.
    sample.reach = count < 3 ? glm::vec3(FLT_MAX) : kSpread * deviation;
}

void TemporalUpsampler::Step::row(uint32_t y, SeenPlace* places, float* radiance) const
{
    const Column row = columnOf(y, full_.y, small_.y, shift_.y);
    const glm::vec2 step = 2.0f / glm::vec2(full_);
    const float up = 1 - (static_cast<float>(y) + 0.5f) * step.y;
    const glm::vec3 begin = before_.direction({0.5f * step.x - 1, up}),
                    aside = before_.direction({1.5f * step.x - 1, up}) - begin;
    const Sample* first = samples_.data() + row.pixel * small_.x;
    Here here;
    here.dy = row.beside;
    for (size_t x = 0; x < columns_.size(); ++x) {
        const Column& column = columns_[x];
        here.direction = begin + static_cast<float>(x) * aside;
        here.own = first + column.pixel;
        here.dx = column.beside;
        here.away = {column.away, row.away};
        places[x] = make(here);
        const glm::vec3 shown = glm::vec3(places[x].light) / places[x].light.w;
        for (int c = 0; c < 3; ++c) radiance[3 * x + static_cast<size_t>(c)] = shown[c];
        // A number that is none is shown, and not kept.
        if (!(shown.x + shown.y + shown.z < INFINITY)) places[x].light = glm::vec4(0);
    }
}

glm::dvec2 TemporalUpsampler::shiftOf(uint64_t i, glm::uvec2 size)
{
    // The R2 sequence: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018
    const glm::dvec2 at(additive(i, 0.7548776662466927), additive(i, 0.5698402909980532));
    return (2.0 * at - 1.0) / glm::dvec2(size);
}

/// What the pixels of a small picture tell.
void TemporalUpsampler::findSamples(const Seen& seen)
{
    const int width = static_cast<int>(seen.mean.width),
              height = static_cast<int>(seen.mean.height);
    const FilmPoints points(seen.camera, {seen.mean.width, seen.mean.height});
    samples_.resize(static_cast<size_t>(width) * static_cast<size_t>(height));
    core::parallelFor(samples_.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Sample& s = samples_[i];
            s.radiance = radianceAt(seen.mean, i);
            s.nearness = points.nearness(seen.aovs, i);
            s.surface = packSurface(seen.aovs, i);
            s.alike = static_cast<uint32_t>(seen.guide.pixels[i]);
        }
    });
    const glm::vec2 perPixel = glm::vec2(width, height) / glm::vec2(size_);
    core::parallelFor(samples_.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Sample& s = samples_[i];
            const auto near = [&](int dx, int dy) {
                return s.isLike(dx, dy) ? (&s)[dy * width + dx].nearness : 0;
            };
            s.slope = {
                slopeOf(near(-1, 0), s.isLike(-1, 0), s.nearness, near(1, 0), s.isLike(1, 0)),
                slopeOf(near(0, -1), s.isLike(0, -1), s.nearness, near(0, 1), s.isLike(0, 1))};
            s.slack = kSlopeOff * glm::dot(glm::abs(s.slope), perPixel);
        }
    });
}

void TemporalUpsampler::begin(const core::Image& mean, const core::Aovs& aovs,
                              const core::Camera& camera, glm::uvec2 size)
{
    size_ = size;
    camera_ = camera;
    const FilmPoints points(camera, {mean.width, mean.height});
    places_.resize(static_cast<size_t>(size.x) * size.y);
    core::parallelFor(size.y, 8, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (size_t x = 0; x < size.x; ++x) {
                const size_t i = (2 * y + 1) * mean.height / (2 * size.y) * mean.width +
                                 (2 * x + 1) * mean.width / (2 * size.x);
                places_[y * size.x + x] = {kMost * glm::vec4(radianceAt(mean, i), 1),
                                           points.nearness(aovs, i), packSurface(aovs, i)};
            }
    });
}

core::Image TemporalUpsampler::add(const Seen& seen, glm::uvec2 size)
{
    CHECK(!seen.camera.orthographic);
    if (size != size_) forget();
    size_ = size;
    findSamples(seen);
    std::swap(before_, places_);
    const Step step(*this, seen);
    const auto ofSamples = [&](const auto& body) {
        core::parallelFor(samples_.size(), 1024, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) body(samples_[i]);
        });
    };
    ofSamples([&](Sample& s) { s.surprise = step.surpriseAt(s); });
    ofSamples([&](Sample& s) { step.findBounds(s); });
    places_.resize(static_cast<size_t>(size.x) * size.y);
    core::Image result(size.x, size.y, 3);
    core::parallelFor(size.y, 8, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            step.row(static_cast<uint32_t>(y), &places_[y * size.x],
                     result.at(0, static_cast<uint32_t>(y)));
    });
    camera_ = seen.camera;
    ++count_;
    return result;
}

}  // namespace app

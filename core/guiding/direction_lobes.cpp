#include "core/guiding/direction_lobes.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace core::guiding {

namespace {

constexpr int kFirstSteps = 6, kSteps = 2;  // of EM, for the first lessons and for later ones
constexpr int kBoundRounds = 4;
constexpr float kLeastValue = 1e-30f;  // what is darker would not survive fractions
constexpr size_t kMostLights = 4096;   // in one iteration; of more, every n-th

// Priors, in effective samples: of each lobe's probability, and of a mean cosine of zero.
constexpr double kMassPrior = 0.01, kWidthPrior = 0.1;
constexpr double kMostKappa = 1e4, kLeastKappa = 0.1;
constexpr float kFirstKappa = 5;

/// A number of each lobe, for a loop in which compilers find no vectors by themselves. Passed by
/// reference alone: how else it is passed depends on the processor that is compiled for.
using Eight = float __attribute__((vector_size(32)));
using EightInts = int32_t __attribute__((vector_size(32)));
using EightFloats = std::array<float, DirectionLobes::kCount>;
static_assert(sizeof(Eight) == sizeof(EightFloats));

void take(const EightFloats& numbers, Eight& v)
{
    std::memcpy(&v, numbers.data(), sizeof v);
}

EightFloats floats(const Eight& v)
{
    EightFloats numbers;
    std::memcpy(numbers.data(), &v, sizeof v);
    return numbers;
}

float largest(const Eight& v)
{
    const EightFloats f = floats(v);
    return std::max(std::max(std::max(f[0], f[1]), std::max(f[2], f[3])),
                    std::max(std::max(f[4], f[5]), std::max(f[6], f[7])));
}

float sum(const Eight& v)
{
    float all = 0;
    for (const float x : floats(v)) all += x;
    return all;
}

/// shared::expMinus of x, to the bit.
void toExpMinus(Eight& x)
{
    const Eight y = x * 1.442695041f;
    const EightInts n = __builtin_convertvector(y + 0.5f, EightInts);
    const Eight f = (__builtin_convertvector(n, Eight) - y) * 0.6931471806f;
    const Eight tail = 0.041666667f + f * (0.0083333333f + f * 0.0013888889f);
    const Eight p = 1.0f + f * (1.0f + f * (0.5f + f * (0.16666667f + f * tail)));
    const EightInts left = 127 - n, power = (left > 0 ? left : 0) << 23;
    Eight scale;
    std::memcpy(&scale, &power, sizeof scale);
    x = p * scale;
}

/// Directions all over the sphere, for lobes that nothing is known of.
glm::vec3 spread(size_t k)
{
    const float z = 1 - (2 * float(k) + 1) / float(DirectionLobes::kCount);
    const float turn = 2.399963f * float(k), across = std::sqrt(1 - z * z);
    return {across * std::cos(turn), across * std::sin(turn), z};
}

}  // namespace

void DirectionLobes::halve()
{
    for (Floats* sums : {&kept_.light, &kept_.x, &kept_.y, &kept_.z})
        for (float& s : *sums) s *= 0.5f;
    total_ *= 0.5;
    squares_ *= 0.5;
    count_ *= 0.5;
}

void DirectionLobes::fade(double factor)
{
    for (Floats* sums : {&kept_.light, &kept_.x, &kept_.y, &kept_.z})
        for (float& s : *sums) s *= float(factor);
}

/// The value above which lessons are cut: the mean times the root of their number, so that what
/// one path carries home by luck is not worth a lobe (E. Ionides, "Truncated Importance
/// Sampling", 2008). The mean is that of what has been cut, hence the rounds.
float DirectionLobes::bound(std::span<const Light> lights) const
{
    const double count = count_ + double(lights.size());
    auto most = std::numeric_limits<float>::max();
    for (int round = 0; round < kBoundRounds; ++round) {
        double sum = total_;
        for (const Light& light : lights) sum += double(std::min(light.value, most));
        most = std::min(most, float(sum / std::sqrt(count)));
    }
    return most;
}

/// What brought light, as far as it counts.
std::vector<DirectionLobes::Light> DirectionLobes::lightsOf(std::span<const Lesson> lessons)
{
    std::vector<Light> lights;
    for (const Lesson& lesson : lessons)
        if (lesson.pdf > 0 && lesson.value > kLeastValue)
            lights.push_back({lesson.direction, lesson.value});
    const size_t step = (lights.size() + kMostLights - 1) / kMostLights;
    if (step > 1) {
        for (size_t i = 0; i < lights.size(); i += step) lights[i / step] = lights[i];
        lights.resize((lights.size() + step - 1) / step);
    }
    const float most = bound(lights);
    for (Light& light : lights) {
        light.value = std::min(light.value, most);
        total_ += double(light.value);
        squares_ += double(light.value) * double(light.value);
        count_ += 1;
    }
    return lights;
}

/// First lobes: at lessons that are bright and far from each other (D. Arthur, S. Vassilvitskii,
/// "k-means++", 2007, with the numbers of a golden-ratio sequence).
void DirectionLobes::seed(std::span<const Light> lights)
{
    std::vector<float> far(lights.size(), 1);  // squared chord to the next lobe
    for (size_t k = 0; k < kCount; ++k) {
        double all = 0;
        for (size_t i = 0; i < lights.size(); ++i) all += double(far[i] * lights[i].value);
        double rest = all * std::fmod(0.5 + 0.6180339887 * double(k), 1.0);
        size_t pick = 0;
        for (; pick + 1 < lights.size(); ++pick) {
            rest -= double(far[pick] * lights[pick].value);
            if (rest < 0) break;
        }
        const glm::vec3 mean = all > 0 ? lights[pick].direction : spread(k);
        for (size_t i = 0; i < lights.size(); ++i) {
            const glm::vec3 chord = lights[i].direction - mean;
            far[i] = std::min(far[i], glm::dot(chord, chord));
        }
        lobes_.x[k] = mean.x;
        lobes_.y[k] = mean.y;
        lobes_.z[k] = mean.z;
        lobes_.kappa[k] = kFirstKappa;
        lobes_.peak[k] = 1;
    }
}

/// Adds each lesson's light to the lobes in proportion to their densities there.
void DirectionLobes::expect(std::span<const Light> lights, Sums& sums) const
{
    // All lobes at once, in registers.
    Eight lobeX, lobeY, lobeZ, width, peak, all, allX, allY, allZ;
    take(lobes_.x, lobeX);
    take(lobes_.y, lobeY);
    take(lobes_.z, lobeZ);
    take(lobes_.kappa, width);
    width *= -0.5f;
    take(lobes_.peak, peak);
    take(sums.light, all);
    take(sums.x, allX);
    take(sums.y, allY);
    take(sums.z, allZ);
    for (const Light& light : lights) {
        const glm::vec3 w = light.direction;
        const Eight x = lobeX - w.x, y = lobeY - w.y, z = lobeZ - w.z;
        const Eight power = width * (x * x + y * y + z * z);
        // The largest becomes one: a direction far from every lobe belongs to the nearest.
        Eight density = largest(power) - power;
        toExpMinus(density);
        density *= peak;
        const Eight part = light.value / sum(density) * density;
        all += part;
        allX += part * w.x;
        allY += part * w.y;
        allZ += part * w.z;
    }
    sums = {floats(all), floats(allX), floats(allY), floats(allZ)};
}

/// The likeliest lobes for these sums, given the priors.
void DirectionLobes::maximise(const Sums& sums)
{
    double all = 0;
    for (const float light : sums.light) all += double(light);
    const double effective = total_ * total_ / squares_, scale = effective / all;
    const double masses = effective + double(kCount) * kMassPrior;
    for (size_t k = 0; k < kCount; ++k) {
        const double own = scale * double(sums.light[k]);
        const glm::dvec3 mean = scale * glm::dvec3(sums.x[k], sums.y[k], sums.z[k]);
        const double length = glm::length(mean);
        if (length > 1e-6 * own && length > 0) {
            lobes_.x[k] = float(mean.x / length);
            lobes_.y[k] = float(mean.y / length);
            lobes_.z[k] = float(mean.z / length);
        }
        // A. Banerjee et al., "Clustering on the Unit Hypersphere using von Mises-Fisher
        // Distributions" (2005)
        const double r = std::min(length / (own + kWidthPrior), 1.0 - 1e-7);
        const double kappa = r * (3 - r * r) / (1 - r * r);
        const double mass = (own + kMassPrior) / masses;
        lobes_.kappa[k] = float(std::clamp(kappa, kLeastKappa, kMostKappa));
        lobes_.mass[k] = float(mass);
        lobes_.peak[k] = float(mass) * shared::peakOfLobe(lobes_.kappa[k]);
    }
}

void DirectionLobes::learn(std::span<const Lesson> lessons)
{
    const bool isFirst = !knowsLight();
    const std::vector<Light> lights = lightsOf(lessons);
    if (lights.empty()) return;
    if (isFirst) seed(lights);
    Sums sums;
    for (int step = 0; step < (isFirst ? kFirstSteps : kSteps); ++step) {
        sums = kept_;
        expect(lights, sums);
        maximise(sums);
    }
    kept_ = sums;
}

void DirectionLobes::write(std::span<glm::vec4> words) const
{
    for (glm::vec4& word : words) word = glm::vec4(0);
    if (!knowsLight()) return;
    for (size_t k = 0; k < kCount; ++k) {
        const auto put = [&](uint32_t first, float value) {
            words[first + k / 4][int(k % 4)] = value;
        };
        put(shared::kLobeX, lobes_.x[k]);
        put(shared::kLobeY, lobes_.y[k]);
        put(shared::kLobeZ, lobes_.z[k]);
        put(shared::kLobeWidth, 0.5f * lobes_.kappa[k]);
        put(shared::kLobePeak, lobes_.peak[k]);
        put(shared::kLobeMass, lobes_.mass[k]);
    }
}

}  // namespace core::guiding

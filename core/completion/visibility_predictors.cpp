// See visibility_predictors.h.
#include "core/completion/visibility_predictors.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/completion/dense.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr uint32_t kListed = 64;  // neighbours that are found once and for all

void setTo(std::span<uint64_t> words, uint32_t i, bool value)
{
    if (value) setBit(words, i);
}

/// Middle and extent of rows, by which places become numbers around 1.
struct Normalized {
    vec3 middle{0};
    float scale = 1;

    explicit Normalized(std::span<const vec3> places)
    {
        vec3 low = places[0], high = places[0];
        for (const vec3& p : places) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        middle = 0.5f * (low + high);
        const float extent = glm::length(high - low);
        if (extent > 0) scale = 2 / extent;
    }
    std::array<double, 4> operator()(const vec3& p) const
    {
        const vec3 x = (p - middle) * scale;
        return {double(x.x), double(x.y), double(x.z), 1};
    }
};

}  // namespace

NearRows::NearRows(std::span<const vec3> places) : places_(places)
{
    const auto count = static_cast<uint32_t>(places.size());
    listed_ = std::min(kListed, count > 0 ? count - 1 : 0);
    near_.reserve(size_t(listed_) * count);
    std::vector<std::pair<float, uint32_t>> others;
    for (uint32_t i = 0; i < count; ++i) {
        others.clear();
        for (uint32_t k = 0; k < count; ++k)
            if (k != i) others.emplace_back(distance2(i, k), k);
        const auto end = others.begin() + listed_;
        std::nth_element(others.begin(), end, others.end());
        std::sort(others.begin(), end);
        for (auto it = others.begin(); it != end; ++it) near_.push_back(it->second);
    }
}

float NearRows::distance2(uint32_t a, uint32_t b) const
{
    const vec3 d = places_[a] - places_[b];
    return glm::dot(d, d);
}

NearTraced NearRows::find(uint32_t row, std::span<const uint64_t> traced) const
{
    NearTraced found;
    for (uint32_t k = 0; k < listed_ && found.count < kNear; ++k) {
        const uint32_t other = near_[size_t(row) * listed_ + k];
        if (getBit(traced, other)) found.row[found.count++] = other;
    }
    if (found.count == kNear || listed_ + 1 == places_.size()) return found;
    std::array<std::pair<float, uint32_t>, kNear> best;
    found.count = 0;
    forEachBit(traced, [&](uint32_t other) {
        if (other == row) return;
        std::pair<float, uint32_t> entry{distance2(row, other), other};
        for (uint32_t k = 0; k < found.count; ++k)
            if (entry < best[k]) std::swap(entry, best[k]);
        if (found.count < kNear) best[found.count++] = entry;
    });
    for (uint32_t k = 0; k < found.count; ++k) found.row[k] = best[k].second;
    return found;
}

void predictLinear(std::span<const vec3> places, const KnownColumn& known,
                   std::span<const uint64_t> wanted, std::span<uint64_t> predicted)
{
    constexpr size_t kTerms = 4;
    std::ranges::fill(predicted, 0);
    if (places.empty()) return;
    const Normalized at(places);
    Matrix normal(kTerms, kTerms), right(kTerms, 1);
    double rows = 0;
    forEachBit(known.traced, [&](uint32_t i) {
        const std::array<double, kTerms> x = at(places[i]);
        const double y = getBit(known.visible, i) ? 1 : -1;
        for (size_t a = 0; a < kTerms; ++a) {
            right(a, 0) += x[a] * y;
            for (size_t b = 0; b < kTerms; ++b) normal(a, b) += x[a] * x[b];
        }
        ++rows;
    });
    // Rows on a plane leave one direction open, in which the function stays constant.
    const Matrix plane = product(pseudoInverse(normal, 1e-8 * rows), right);
    forEachBit(wanted, [&](uint32_t i) {
        const std::array<double, kTerms> x = at(places[i]);
        double y = 0;
        for (size_t a = 0; a < kTerms; ++a) y += plane(a, 0) * x[a];
        setTo(predicted, i, y > 0);
    });
}

void predictByVote(std::span<const NearTraced> near, const KnownColumn& known,
                   std::span<const uint64_t> wanted, std::span<uint64_t> predicted)
{
    std::ranges::fill(predicted, 0);
    forEachBit(wanted, [&](uint32_t i) {
        uint32_t votes = 0;
        for (uint32_t k = 0; k < near[i].count; ++k)
            votes += getBit(known.visible, near[i].row[k]) ? 1u : 0u;
        setTo(predicted, i, 2 * votes > near[i].count);
    });
}

void predictByBayes(std::span<const NearTraced> near, const KnownColumn& known,
                    std::span<const SimilarColumn> similar, std::span<const uint64_t> wanted,
                    std::span<uint64_t> predicted)
{
    constexpr size_t kFeatures = 2 * size_t(kNear);
    CHECK(similar.size() <= kNear);
    // Calls f(feature, bit) for what there is of a row.
    const auto features = [&](uint32_t i, auto&& f) {
        for (uint32_t k = 0; k < near[i].count; ++k)
            f(size_t(k), size_t(getBit(known.visible, near[i].row[k])));
        for (size_t k = 0; k < similar.size(); ++k)
            if (getBit(similar[k].matters, i)) f(kNear + k, size_t(getBit(similar[k].labels, i)));
    };
    // How often each answer came with each truth; Laplace's one more, so that nothing is certain.
    std::array<double, 2> truths{1, 1};
    std::array<std::array<std::array<double, 2>, 2>, kFeatures> counts;  // feature, truth, answer
    for (auto& feature : counts) feature = {{{1, 1}, {1, 1}}};
    forEachBit(known.traced, [&](uint32_t i) {
        const auto truth = size_t(getBit(known.visible, i));
        ++truths[truth];
        features(i, [&](size_t k, size_t bit) { ++counts[k][truth][bit]; });
    });
    std::array<std::array<double, 2>, kFeatures> evidence;
    for (size_t k = 0; k < kFeatures; ++k)
        for (size_t bit = 0; bit < 2; ++bit) {
            const auto likelihood = [&](size_t truth) {
                return counts[k][truth][bit] / (counts[k][truth][0] + counts[k][truth][1]);
            };
            evidence[k][bit] = std::log(likelihood(1) / likelihood(0));
        }
    const double prior = std::log(truths[1] / truths[0]);
    std::ranges::fill(predicted, 0);
    forEachBit(wanted, [&](uint32_t i) {
        double odds = prior;
        features(i, [&](size_t k, size_t bit) { odds += evidence[k][bit]; });
        setTo(predicted, i, odds > 0);
    });
}

}  // namespace core::many_lights

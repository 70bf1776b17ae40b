#include "core/methods/iteration_pictures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core {

using guiding::CombineBy, guiding::GroupStatistic, guiding::PixelSums;

namespace {

constexpr uint32_t kTile = 8;
constexpr size_t kMostIterations = GroupStatistic::kMost;

/// Sums of a channel in a film that is `count` samples deep there.
PixelSums sumsOf(const Estimate& film, size_t channel, double count)
{
    const double mean = double(film.mean.pixels[channel]);
    const double variance = double(film.variance.pixels[channel]);
    return {count, mean * count, (variance * std::max(count - 1, 0.0) + mean * mean) * count};
}

PixelSums operator-(const PixelSums& a, const PixelSums& b)
{
    // What one of two floats lacks would be less than nothing.
    return {a.count - b.count, std::max(a.sum - b.sum, 0.0), std::max(a.squares - b.squares, 0.0)};
}

/// Samples of an iteration, or of its half, that tell what it is worth: its noise is not known from
/// one, and the inverse of the variance of fewer than four has no mean, so that a pixel that is
/// quiet by chance would take all the weight.
uint64_t leastSamples(const GuidedParams& params)
{
    if (params.combine == Combine::samples) return 0;
    const bool inverts =
        params.combine == Combine::meanInverseVariance || params.combineOver == CombineOver::pixel;
    return inverts ? 4 : 2;
}

CombineBy combineBy(Combine combine)
{
    CHECK(combine != Combine::trial);
    return static_cast<CombineBy>(combine);  // the same in the same order
}

}  // namespace

void IterationPictures::begin(const GuidedParams& params)
{
    *this = {};
    params_ = params;
}

bool IterationPictures::isOn() const
{
    if (params_.training == 0) return false;
    if (params_.combine == Combine::trial) return !ended_.empty();
    return params_.combine != Combine::samples || params_.combineLast > 0;
}

bool IterationPictures::takesNotes() const
{
    return isOn() && params_.combine != Combine::trial;
}

/// Halves of an iteration take turns in blocks of 1, 1, 1, 1, 2, 2, 4, 4, ... samples, so that they
/// are equal whenever its samples are a power of two, and never far from it.
uint64_t IterationPictures::nextPart(uint64_t samples) const
{
    if (!takesNotes() || params_.combineFrom == CombineFrom::own)
        return std::numeric_limits<uint64_t>::max();
    const uint64_t in = samples - first_;
    if (in < 4) return samples + 1;
    const uint64_t power = std::bit_floor(in), middle = power + power / 2;
    return first_ + (in < middle ? middle : 2 * power);
}

uint64_t IterationPictures::isSecond(uint64_t samplesBefore) const
{
    if (params_.combineFrom == CombineFrom::own) return 0;
    const uint64_t in = samplesBefore - first_;
    if (in < 4) return in % 2;
    const uint64_t power = std::bit_floor(in);
    return in >= power + power / 2 ? 1 : 0;
}

void IterationPictures::note(const Estimate& film, bool ends)
{
    if (!takesNotes()) return;
    const size_t channels = film.mean.pixels.size();
    CHECK(film.samples >= samples_ && film.variance.pixels.size() == channels);
    sum_.resize(channels);
    squares_.resize(channels);
    Sums& half = present_[isSecond(samples_)];
    half.sum.resize(channels);
    half.squares.resize(channels);
    for (size_t i = 0; i < channels; ++i) {
        const PixelSums all = sumsOf(film, i, double(film.samples));
        const PixelSums own = all - PixelSums{double(samples_), sum_[i], squares_[i]};
        half.sum[i] += float(own.sum);
        half.squares[i] += float(own.squares);
        sum_[i] = all.sum;
        squares_[i] = all.squares;
    }
    half.samples += film.samples - samples_;
    samples_ = film.samples;
    if (!ends) return;
    if (ended_.size() + 1 == kMostIterations) ended_.erase(ended_.begin());
    ended_.push_back(std::move(present_));
    present_ = {};
    first_ = samples_;
}

void IterationPictures::discount(const Estimate& film, double weight)
{
    if (params_.training == 0 || params_.combine != Combine::trial) return;
    CHECK(ended_.empty() && film.samples > 0 && weight > 0);
    Sums& past = ended_.emplace_back()[0];
    past.samples = film.samples;
    past.sum.resize(film.mean.pixels.size());
    past.squares.resize(film.mean.pixels.size());
    for (size_t i = 0; i < past.sum.size(); ++i) {
        const PixelSums sums = sumsOf(film, i, double(film.samples));
        past.sum[i] = float(sums.sum);
        past.squares[i] = float(sums.squares);
    }
    weight_ = weight;
}

/// The past with its weight, and what came since.
Estimate IterationPictures::discounted(Estimate film) const
{
    const Sums& past = ended_.front()[0];
    const auto variance = [](const PixelSums& s) {
        return s.count > 1 ? s.varianceOfMean() * s.count : 0.0;
    };
    const size_t pixels = film.weight.pixels.size();
    parallelFor(pixels, 4096, [&](size_t begin, size_t end) {
        for (size_t i = 3 * begin; i < 3 * end; ++i) {
            const PixelSums first{double(past.samples), double(past.sum[i]),
                                  double(past.squares[i])};
            const PixelSums all = sumsOf(film, i, double(film.weight.pixels[i / 3]));
            const PixelSums rest = all - first;
            const double weights = weight_ * first.count + rest.count;
            const double squares = weight_ * weight_ * first.count;
            film.mean.pixels[i] = float((weight_ * first.sum + rest.sum) / weights);
            // Of a single sample the noise is not known: as that of all.
            const double ofFirst = variance(first.count > 1 ? first : all);
            const double ofRest = variance(rest.count > 1 ? rest : all);
            film.variance.pixels[i] =
                float((squares * ofFirst + rest.count * ofRest) / (weights * weights));
        }
    });
    for (float& weight : film.weight.pixels) {
        const double first = double(past.samples), rest = double(weight) - first;
        const double weights = weight_ * first + rest;
        weight = float(weights * weights / (weight_ * weight_ * first + rest));
    }
    return film;
}

/// The first of the ended iterations that is in the picture, when the present one has so many
/// samples: the one that it is to replace stays until it has as many.
size_t IterationPictures::firstInPicture(uint64_t present) const
{
    if (params_.combineLast == 0 || ended_.empty()) return 0;
    const Iteration& last = ended_.back();
    const size_t others =
        params_.combineLast - (present >= last[0].samples + last[1].samples ? 1u : 0u);
    return ended_.size() - std::min(others, ended_.size());
}

/// Weights and means of one picture.
class IterationPictures::Mixer {
public:
    Mixer(const IterationPictures& of, const Estimate& film) : of_(of), film_(film)
    {
        const uint64_t inPresent = film.samples - of.first_;
        first_ = of.firstInPicture(inPresent);
        count_ = of.ended_.size() - first_ + 1;
        crossed_ = of.params_.combineFrom == CombineFrom::crossed;
        const uint64_t least = leastSamples(of.params_);
        for (size_t k = 0; k < count_; ++k)
            for (size_t h = 0; h < 2; ++h) {
                const bool isPresent = k + 1 == count_;
                const uint64_t samples =
                    isPresent ? of.present_[h].samples +
                                    (h == of.isSecond(of.samples_) ? film.samples - of.samples_ : 0)
                              : of.ended_[first_ + k][h].samples;
                counts_[h][k] = samples < least ? 0 : 1;
            }
    }

    size_t count() const { return count_; }
    GroupStatistic statistic() const { return {combineBy(of_.params_.combine), count_}; }
    size_t halves() const { return crossed_ ? 2 : 1; }

    /// The iterations' sums of a channel in one half.
    std::span<const PixelSums> sums(size_t half, size_t channel,
                                    std::array<PixelSums, kMostIterations>& out) const
    {
        for (size_t k = 0; k + 1 < count_; ++k)
            out[k] = ofHalf(of_.ended_[first_ + k][half], channel);
        PixelSums& last = out[count_ - 1];
        last = ofHalf(of_.present_[half], channel);
        if (half == of_.isSecond(of_.samples_)) {
            PixelSums before{double(of_.samples_), 0, 0};
            if (!of_.sum_.empty())
                before = {before.count, of_.sum_[channel], of_.squares_[channel]};
            last += sumsOf(film_, channel, double(film_.weight.pixels[channel / 3])) - before;
        }
        return {out.data(), count_};
    }

    void add(size_t channel, std::array<GroupStatistic, 2>& groups) const
    {
        std::array<PixelSums, kMostIterations> pixel;
        for (size_t h = 0; h < halves(); ++h) {
            sums(h, channel, pixel);
            // What does not tell its noise does not keep the others from telling theirs.
            for (size_t k = 0; k < count_; ++k)
                if (counts_[h][k] == 0) pixel[k] = {2, 1, 1};
            groups[h].add({pixel.data(), count_});
        }
    }

    /// Weights of the iterations for each half's values.
    void weights(const std::array<GroupStatistic, 2>& groups,
                 std::array<std::array<double, kMostIterations>, 2>& out) const
    {
        for (size_t h = 0; h < halves(); ++h) {
            auto& weights = out[crossed_ ? 1 - h : 0];
            groups[h].weights({weights.data(), count_});
            for (size_t k = 0; k < count_; ++k) weights[k] *= counts_[h][k];
        }
    }

    /// Mean, its variance, and what divides the variance of one sample, of a channel.
    void mix(size_t channel, const std::array<std::array<double, kMostIterations>, 2>& weights,
             double& mean, double& variance, double& effective) const
    {
        std::array<std::array<PixelSums, kMostIterations>, 2> pixels;
        std::array<double, 2> samples{};
        double deviations = 0, freedom = 0;  // of all samples about the mean of their iteration
        for (size_t h = 0; h < halves(); ++h) {
            sums(h, channel, pixels[h]);
            for (size_t k = 0; k < count_; ++k) {
                const PixelSums& p = pixels[h][k];
                samples[h] += p.count;
                if (!(p.count > 1)) continue;
                deviations += p.varianceOfMean() * p.count * (p.count - 1);
                freedom += p.count - 1;
            }
        }
        const double usual = freedom > 0 ? deviations / freedom : 0;
        mean = variance = 0;
        double inverse = 0;
        for (size_t h = 0; h < halves(); ++h) {
            if (!(samples[h] > 0)) continue;
            double all = 0, own = 0;
            for (size_t k = 0; k < count_; ++k)
                if (pixels[h][k].count > 0) {
                    all += weights[h][k];
                    own += pixels[h][k].count;
                }
            const double part = samples[h] / (samples[0] + samples[1]);
            for (size_t k = 0; k < count_; ++k) {
                const PixelSums& p = pixels[h][k];
                if (!(p.count > 0)) continue;
                // By samples where none of those that tell their noise have any.
                const double w = part * (all > 0 ? weights[h][k] / all : p.count / own);
                mean += w * p.mean();
                variance += w * w * (p.count > 1 ? p.varianceOfMean() : usual);
                inverse += w * w / p.count;
            }
        }
        effective = inverse > 0 ? 1 / inverse : 0;
    }

private:
    static PixelSums ofHalf(const Sums& half, size_t channel)
    {
        if (half.samples == 0) return {};
        return {double(half.samples), double(half.sum[channel]), double(half.squares[channel])};
    }

    const IterationPictures& of_;
    const Estimate& film_;
    size_t first_ = 0, count_ = 0;
    bool crossed_ = false;
    std::array<std::array<double, kMostIterations>, 2> counts_{};  // 1: it has a weight
};

Estimate IterationPictures::picture(Estimate film) const
{
    if (!isOn()) return film;
    if (params_.combine == Combine::trial) return discounted(std::move(film));
    const Mixer mixer(*this, film);
    const uint32_t width = film.mean.width, height = film.mean.height;
    using Groups = std::array<GroupStatistic, 2>;
    const auto over = params_.combineOver;
    const uint32_t side = over == CombineOver::pixel ? 1 : kTile;
    const uint32_t rows = (height + side - 1) / side, columns = (width + side - 1) / side;
    const auto eachChannel = [&](uint32_t row, uint32_t column, const auto& take) {
        for (uint32_t y = row * side; y < std::min((row + 1) * side, height); ++y)
            for (uint32_t x = column * side; x < std::min((column + 1) * side, width); ++x)
                for (size_t c = 0; c < 3; ++c) take(3 * (size_t(y) * width + x) + c);
    };
    const Groups none{mixer.statistic(), mixer.statistic()};
    std::vector<Groups> ofRows(rows, none);
    if (over == CombineOver::picture)
        parallelFor(rows, 1, [&](size_t begin, size_t end) {
            for (size_t row = begin; row < end; ++row)
                for (uint32_t column = 0; column < columns; ++column)
                    eachChannel(uint32_t(row), column,
                                [&](size_t channel) { mixer.add(channel, ofRows[row]); });
        });
    Groups all = none;
    for (const Groups& row : ofRows)
        for (size_t h = 0; h < 2; ++h) all[h] += row[h];

    Estimate result = film;
    parallelFor(rows, 1, [&](size_t begin, size_t end) {
        std::array<std::array<double, kMostIterations>, 2> weights{};
        mixer.weights(all, weights);
        for (size_t row = begin; row < end; ++row)
            for (uint32_t column = 0; column < columns; ++column) {
                if (over != CombineOver::picture) {
                    Groups own = none;
                    eachChannel(uint32_t(row), column,
                                [&](size_t channel) { mixer.add(channel, own); });
                    mixer.weights(own, weights);
                }
                eachChannel(uint32_t(row), column, [&](size_t channel) {
                    double mean, variance, effective;
                    mixer.mix(channel, weights, mean, variance, effective);
                    result.mean.pixels[channel] = float(mean);
                    result.variance.pixels[channel] = float(variance);
                    result.weight.pixels[channel / 3] = float(effective);
                });
            }
    });
    return result;
}

}  // namespace core

// See visibility_prediction.h.
#include "core/completion/visibility_prediction.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/completion/row_weights.h"
#include "core/completion/tracer.h"

namespace core::many_lights {

namespace {

using glm::vec3;

constexpr size_t kPredictors = 3;
constexpr size_t kTogether = 64;  // columns whose rays fill packets together

class Prediction {
public:
    Prediction(VisibilityOracle& oracle, const SlicePlaces& places,
               const PredictionSettings& settings, uint64_t seed, const std::stop_token& stop,
               CompletedSlice& out)
        : places_(places), settings_(settings), stop_(stop), out_(out),
          rows_(static_cast<uint32_t>(places.rows.size())),
          columns_(static_cast<uint32_t>(places.columns.size())),
          tracer_(oracle, rows_, true, out.stats), random_(seed), nearRows_(places.rows),
          near_(rows_), traced_(rows_, columns_), seen_(rows_, columns_), labels_(rows_, columns_),
          asked_(rows_, columns_), wanted_(wordsFor(rows_))
    {
        for (BitMatrix& p : predicted_) p.reset(rows_, columns_);
    }

    bool run();

private:
    void begin();
    bool findSimilar();
    bool trace();
    void findNear(uint32_t j);
    void predict(uint32_t j);
    bool judge(uint32_t j);
    void finish();

    KnownColumn known(uint32_t j) const { return {traced_.column(j), seen_.column(j)}; }
    /// Rows of a column that matter and have not been traced.
    std::span<const uint64_t> untraced(uint32_t j)
    {
        for (size_t w = 0; w < wanted_.size(); ++w)
            wanted_[w] = tracer_.matters(j)[w] & ~std::as_const(traced_).column(j)[w];
        return wanted_;
    }

    const SlicePlaces& places_;
    const PredictionSettings& settings_;
    const std::stop_token& stop_;
    CompletedSlice& out_;
    uint32_t rows_, columns_;
    Tracer tracer_;
    Pcg32 random_;
    NearRows nearRows_;
    std::vector<NearTraced> near_;  // of one column
    std::vector<uint32_t> active_;
    std::vector<std::array<uint32_t, kNear>> similar_;  // columns, by column
    uint32_t similarCount_ = 0;                         // of each
    BitMatrix traced_, seen_;                           // seen: truth where traced, else 0
    BitMatrix labels_;                                  // truth or prediction
    BitMatrix asked_;                                   // rows that the last round traced
    std::array<BitMatrix, kPredictors> predicted_;
    Words wanted_;
};

/// Columns without a row that matters are done.
void Prediction::begin()
{
    CompletionStats& stats = out_.stats;
    stats.entries += uint64_t(rows_) * columns_;
    stats.columns += columns_;
    for (uint32_t j = 0; j < columns_; ++j) {
        const uint32_t count = countBits(tracer_.matters(j));
        stats.active += count;
        if (count > 0) active_.push_back(j);
    }
    stats.inactive += columns_ - static_cast<uint32_t>(active_.size());
}

/// The nearest other columns of each, ties as they come. False when a stop came first.
bool Prediction::findSimilar()
{
    similar_.resize(columns_);
    if (active_.size() < 2) return true;
    similarCount_ = std::min(kNear, static_cast<uint32_t>(active_.size()) - 1);
    std::vector<std::pair<float, uint32_t>> others(active_.size());
    for (const uint32_t j : active_) {
        if (stop_.stop_requested()) return false;
        for (size_t k = 0; k < active_.size(); ++k) {
            const vec3 d = places_.columns[active_[k]] - places_.columns[j];
            others[k] = {active_[k] == j ? -1.0f : glm::dot(d, d), active_[k]};
        }
        std::partial_sort(others.begin(), others.begin() + similarCount_ + 1, others.end());
        for (uint32_t k = 0; k < similarCount_; ++k) similar_[j][k] = others[k + 1].second;
    }
    return true;
}

/// Another part of the rows of every active column.
bool Prediction::trace()
{
    std::vector<TraceRequest> requests;
    for (size_t from = 0; from < active_.size(); from += kTogether) {
        const size_t to = std::min(from + kTogether, active_.size());
        requests.clear();
        for (size_t k = from; k < to; ++k) {
            const uint32_t j = active_[k];
            const double share = settings_.rate * countBits(tracer_.matters(j));
            const std::span<uint64_t> asked = asked_.column(j);
            std::ranges::fill(asked, 0);
            drawUniform(static_cast<uint32_t>(std::ceil(share)), untraced(j), random_, asked);
            requests.push_back({j, asked.data(), seen_.column(j).data()});
        }
        tracer_.trace(requests);
        if (stop_.stop_requested()) return false;
        for (size_t k = from; k < to; ++k)
            for (size_t w = 0; w < wanted_.size(); ++w)
                traced_.column(active_[k])[w] |= asked_.column(active_[k])[w];
    }
    return true;
}

void Prediction::findNear(uint32_t j)
{
    const std::span<const uint64_t> traced = std::as_const(traced_).column(j);
    forEachBit(tracer_.matters(j), [&](uint32_t i) { near_[i] = nearRows_.find(i, traced); });
}

/// In all ways, from what was known of other columns before the round.
void Prediction::predict(uint32_t j)
{
    findNear(j);
    std::array<SimilarColumn, kNear> similar;
    for (uint32_t k = 0; k < similarCount_; ++k)
        similar[k] = {tracer_.matters(similar_[j][k]),
                      std::as_const(labels_).column(similar_[j][k])};
    const std::span<const uint64_t> wanted = untraced(j);
    predictLinear(places_.rows, known(j), wanted, predicted_[0].column(j));
    predictByBayes(near_, known(j), {similar.data(), similarCount_}, wanted,
                   predicted_[1].column(j));
    predictByVote(near_, known(j), wanted, predicted_[2].column(j));
}

/// Keeps the labels of the way that erred least in the rows just traced; whether that is good
/// enough.
bool Prediction::judge(uint32_t j)
{
    const auto asked = std::as_const(asked_).column(j), seen = std::as_const(seen_).column(j),
               traced = std::as_const(traced_).column(j);
    size_t best = 0;
    uint32_t fewest = ~0u;
    for (size_t p = 0; p < kPredictors; ++p) {
        const auto predicted = std::as_const(predicted_[p]).column(j);
        uint32_t wrong = 0;
        for (size_t w = 0; w < asked.size(); ++w)
            wrong += static_cast<uint32_t>(std::popcount((predicted[w] ^ seen[w]) & asked[w]));
        if (wrong >= fewest) continue;
        fewest = wrong;
        best = p;
    }
    for (size_t w = 0; w < asked.size(); ++w)
        labels_.column(j)[w] =
            seen[w] | (std::as_const(predicted_[best]).column(j)[w] & ~traced[w]);
    return double(fewest) <= settings_.error * double(countBits(asked));
}

bool Prediction::run()
{
    begin();
    if (!findSimilar() || !trace()) return false;
    for (const uint32_t j : active_) {  // labels to begin with
        if (stop_.stop_requested()) return false;
        findNear(j);
        predictByVote(near_, known(j), untraced(j), labels_.column(j));
        for (size_t w = 0; w < wanted_.size(); ++w) labels_.column(j)[w] |= seen_.column(j)[w];
    }
    for (uint32_t round = 0;; ++round) {
        std::erase_if(active_, [&](uint32_t j) { return countBits(untraced(j)) == 0; });
        if (round == settings_.rounds || active_.empty()) break;
        for (const uint32_t j : active_) {
            if (stop_.stop_requested()) return false;
            predict(j);
        }
        if (!trace()) return false;
        std::erase_if(active_, [&](uint32_t j) { return judge(j); });
    }
    finish();
    return true;
}

void Prediction::finish()
{
    CompletionStats& stats = out_.stats;
    stats.authorRays += stats.rays;
    stats.repaired += static_cast<uint32_t>(active_.size());
    for (uint32_t j = 0; j < columns_; ++j) {
        const uint32_t matter = countBits(tracer_.matters(j)),
                       traced = countBits(traced_.column(j));
        if (matter == 0) continue;
        stats.full += traced == matter ? 1u : 0u;
        ++stats.rated;
        stats.rates += double(traced) / matter;
    }
    stats.matched += stats.columns - stats.inactive - stats.full - stats.repaired;
    out_.visible = std::move(labels_);
}

}  // namespace

bool predictVisibility(VisibilityOracle& oracle, const SlicePlaces& places,
                       const PredictionSettings& settings, uint64_t seed,
                       const std::stop_token& stop, CompletedSlice& out)
{
    const Clock::time_point start = Clock::now();
    out.coefficients.clear();
    out.residual.clear();
    out.stats = {};
    const bool done = Prediction(oracle, places, settings, seed, stop, out).run();
    out.stats.seconds = secondsSince(start);
    return done;
}

}  // namespace core::many_lights

// See column_clusters.h.
#include "core/many_lights/column_clusters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/parallel.h"

namespace core::many_lights {

namespace {

/// Below this part of the square of its length a cluster's cost is the rounding of it.
constexpr double kNothing = 1e-5;
/// One of so many clusters is for lights that no row sees.
constexpr uint32_t kUnseenShare = 32;
/// Of all weight, what brightness alone decides.
constexpr double kFloor = 0.05;

struct Centre {
    uint32_t column;
    float weight;
};

/// Cost of column j with all others, for every j.
std::vector<double> costsWithAll(const ReducedMatrix& matrix, std::span<const uint32_t> columns)
{
    std::vector<float> sum(matrix.column(0).size());
    double norms = 0;
    for (const uint32_t j : columns) {
        const std::span<const float> column = matrix.column(j);
        for (size_t i = 0; i < sum.size(); ++i) sum[i] += column[i];
        norms += double(matrix.norm(j));
    }
    std::vector<double> costs(columns.size());
    for (size_t k = 0; k < columns.size(); ++k) {
        const double length = double(matrix.norm(columns[k])) * norms;
        const double cost = length - double(innerProduct(matrix.column(columns[k]), sum));
        costs[k] = cost > kNothing * length ? cost : 0;
    }
    return costs;
}

/// Draws until there are `count` different centres, or hope of more is gone.
std::vector<Centre> drawCentres(std::span<const uint32_t> columns, std::span<const double> costs,
                                uint32_t count, Pcg32& random)
{
    std::vector<double> cumulated(costs.size());
    std::partial_sum(costs.begin(), costs.end(), cumulated.begin());
    const double total = cumulated.empty() ? 0 : cumulated.back();
    if (!(total > 0)) return {{columns[0], 1}};
    std::vector<Centre> centres;
    std::vector<uint32_t> place(columns.size(), ~0u);
    for (uint64_t draws = 0; centres.size() < count && draws < 16 * uint64_t(count); ++draws) {
        auto at = std::ranges::upper_bound(cumulated, random() * total);
        if (at == cumulated.end()) --at;
        const auto k = static_cast<size_t>(at - cumulated.begin());
        if (!(costs[k] > 0)) continue;
        if (place[k] == ~0u) {
            place[k] = static_cast<uint32_t>(centres.size());
            centres.push_back({columns[k], 0});
        }
        centres[place[k]].weight += static_cast<float>(total / costs[k]);
    }
    return centres;
}

uint32_t nearestCentre(const ReducedMatrix& matrix, std::span<const Centre> centres, uint32_t j)
{
    uint32_t best = 0;
    float least = std::numeric_limits<float>::infinity();
    for (uint32_t c = 0; c < centres.size(); ++c) {
        const uint32_t i = centres[c].column;
        const float inner = innerProduct(matrix.column(i), matrix.column(j));
        // Its own centre costs nothing, whatever rounding says.
        const float cost =
            i == j ? -1.0f
                   : centres[c].weight * std::max(0.0f, matrix.norm(i) * matrix.norm(j) - inner);
        if (cost < least) {
            least = cost;
            best = c;
        }
    }
    return best;
}

float inverse(float norm)
{
    return norm > 0 ? 1 / norm : 0;
}

/// A cluster that waits to be split.
struct Waiting {
    double cost;
    uint32_t range;

    friend bool operator<(const Waiting& a, const Waiting& b)
    {
        return a.cost < b.cost || (a.cost == b.cost && a.range > b.range);
    }
};

class Splitter {
public:
    Splitter(const ReducedMatrix& matrix, ColumnClusters& clusters)
        : matrix_(matrix), clusters_(clusters)
    {}

    void run(uint32_t count, const std::stop_token& stop)
    {
        for (uint32_t r = 0; r < clusters_.ranges.size() && !stop.stop_requested(); ++r) push(r);
        while (clusters_.ranges.size() < count && !heap_.empty() && !stop.stop_requested()) {
            std::pop_heap(heap_.begin(), heap_.end());
            const uint32_t r = heap_.back().range;
            heap_.pop_back();
            const IndexRange range = clusters_.ranges[r];
            const uint32_t middle = split(range);
            clusters_.ranges[r].end = middle;
            clusters_.ranges.push_back({middle, range.end});
            push(r);
            push(static_cast<uint32_t>(clusters_.ranges.size() - 1));
        }
        std::ranges::sort(clusters_.ranges, {}, &IndexRange::begin);
    }

private:
    void push(uint32_t r)
    {
        const double cost = costOf(clusters_.ranges[r]);
        if (cost <= 0) return;
        heap_.push_back({cost, r});
        std::push_heap(heap_.begin(), heap_.end());
    }

    /// Over all pairs, twice.
    double costOf(const IndexRange& range)
    {
        if (range.size() < 2) return 0;
        line_.assign(matrix_.column(0).size(), 0.0f);
        double norms = 0;
        for (const uint32_t j : clusters_.of(range)) {
            const std::span<const float> column = matrix_.column(j);
            for (size_t i = 0; i < line_.size(); ++i) line_[i] += column[i];
            norms += double(matrix_.norm(j));
        }
        const double cost = norms * norms - double(innerProduct(line_, line_));
        return cost > kNothing * norms * norms ? cost : 0;
    }

    /// The longest column and the one that costs most with it.
    std::pair<uint32_t, uint32_t> ends(std::span<const uint32_t> members) const
    {
        const uint32_t a =
            *std::ranges::max_element(members, {}, [this](uint32_t j) { return matrix_.norm(j); });
        const uint32_t b = *std::ranges::max_element(members, {}, [this, a](uint32_t j) {
            return matrix_.norm(a) * matrix_.norm(j) -
                   innerProduct(matrix_.column(a), matrix_.column(j));
        });
        return {a, b};
    }

    uint32_t split(const IndexRange& range)
    {
        const std::span<uint32_t> members = clusters_.of(range);
        const auto [a, b] = ends(members);
        const std::span<const float> columnA = matrix_.column(a), columnB = matrix_.column(b);
        line_.resize(columnA.size());
        const float scaleA = inverse(matrix_.norm(a)), scaleB = inverse(matrix_.norm(b));
        for (size_t i = 0; i < line_.size(); ++i)
            line_[i] = scaleA * columnA[i] - scaleB * columnB[i];
        projected_.resize(members.size());
        for (size_t k = 0; k < members.size(); ++k)
            projected_[k] = {inverse(matrix_.norm(members[k])) *
                                 innerProduct(matrix_.column(members[k]), line_),
                             members[k]};
        const auto [low, high] = std::ranges::minmax_element(projected_);
        const float middle = 0.5f * (low->first + high->first);
        const auto second = std::stable_partition(projected_.begin(), projected_.end(),
                                                  [&](const auto& p) { return p.first < middle; });
        auto left = static_cast<size_t>(second - projected_.begin());
        if (left == 0 || left == projected_.size()) left = projected_.size() / 2;
        for (size_t k = 0; k < members.size(); ++k) members[k] = projected_[k].second;
        return range.begin + static_cast<uint32_t>(left);
    }

    const ReducedMatrix& matrix_;
    ColumnClusters& clusters_;
    std::vector<Waiting> heap_;
    std::vector<float> line_;
    std::vector<std::pair<float, uint32_t>> projected_;
};

double sumOf(std::span<const uint32_t> members, std::span<const float> weights)
{
    double sum = 0;
    for (const uint32_t j : members) sum += double(weights[j]);
    return sum;
}

}  // namespace

ColumnClusters sampleClusters(const ReducedMatrix& matrix, uint32_t count, Pcg32& random,
                              const std::stop_token& stop)
{
    std::vector<uint32_t> columns;
    for (uint32_t j = 0; j < matrix.columns(); ++j)
        if (matrix.norm(j) > 0) columns.push_back(j);
    ColumnClusters clusters;
    if (columns.empty()) return clusters;
    const std::vector<Centre> centres =
        drawCentres(columns, costsWithAll(matrix, columns), std::max(count, 1u), random);
    std::vector<uint32_t> owner(columns.size());
    const bool whole = parallelFor(
        columns.size(), 64,
        [&](size_t begin, size_t end) {
            for (size_t k = begin; k < end; ++k)
                owner[k] = nearestCentre(matrix, centres, columns[k]);
        },
        stop);
    if (!whole) return clusters;
    std::vector<std::vector<uint32_t>> lists(centres.size());
    for (size_t k = 0; k < columns.size(); ++k) lists[owner[k]].push_back(columns[k]);
    for (const std::vector<uint32_t>& list : lists) {
        if (list.empty()) continue;
        const auto begin = static_cast<uint32_t>(clusters.members.size());
        clusters.members.insert(clusters.members.end(), list.begin(), list.end());
        clusters.ranges.push_back({begin, static_cast<uint32_t>(clusters.members.size())});
    }
    return clusters;
}

void splitClusters(const ReducedMatrix& matrix, uint32_t count, ColumnClusters& clusters,
                   const std::stop_token& stop)
{
    Splitter(matrix, clusters).run(count, stop);
}

std::vector<float> representativeWeights(const ReducedMatrix& matrix,
                                         std::span<const VirtualLight> lights)
{
    double norms = 0, importance = 0;
    for (uint32_t j = 0; j < lights.size(); ++j) {
        norms += double(matrix.norm(j));
        importance += double(lights[j].importance);
    }
    // Where nothing is seen at all brightness decides alone.
    const double share = norms > 0 ? kFloor * norms / importance : 1;
    std::vector<float> weights(lights.size());
    for (uint32_t j = 0; j < lights.size(); ++j)
        weights[j] = matrix.norm(j) + static_cast<float>(share * double(lights[j].importance));
    return weights;
}

UnseenLights unseenLights(const ReducedMatrix& matrix, uint32_t clusters)
{
    UnseenLights unseen;
    for (uint32_t j = 0; j < matrix.columns(); ++j)
        if (!(matrix.norm(j) > 0)) unseen.lights.push_back(j);
    const size_t most = std::max(1u, clusters / kUnseenShare);
    unseen.clusters = static_cast<uint32_t>(std::min(unseen.lights.size(), most));
    return unseen;
}

void allLights(uint32_t lights, std::vector<LightCluster>& out)
{
    out.clear();
    for (uint32_t j = 0; j < lights; ++j) out.push_back({shared::kNone, j, 1});
}

void drawRepresentatives(const ColumnClusters& clusters, std::span<const float> weights,
                         Pcg32& random, std::vector<LightCluster>& out)
{
    for (const IndexRange& range : clusters.ranges)
        drawSystematic(clusters.of(range), weights, 1, random, out);
}

void drawSystematic(std::span<const uint32_t> members, std::span<const float> weights,
                    uint32_t count, Pcg32& random, std::vector<LightCluster>& out)
{
    if (members.empty()) return;
    if (members.size() <= count) {
        for (const uint32_t j : members) out.push_back({shared::kNone, j, 1});
        return;
    }
    const double step = sumOf(members, weights) / count;
    double next = random() * step, passed = 0;
    uint32_t drawn = 0;
    for (const uint32_t j : members) {
        passed += double(weights[j]);
        for (; next < passed && drawn < count; ++drawn, next += step)
            out.push_back({shared::kNone, j, static_cast<float>(step / double(weights[j]))});
    }
    // Rounding may leave the last one undrawn.
    if (drawn < count)
        out.push_back({shared::kNone, members.back(),
                       static_cast<float>(step / double(weights[members.back()]))});
}

}  // namespace core::many_lights

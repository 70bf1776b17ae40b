// See report_data.h.
#include "app/lab/report_data.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/run_lab.h"

namespace app::lab {

namespace {

struct Look {
    const char* method;
    const char* label;
    const char* style;
};

constexpr Look kLooks[] = {{"discard", "Discard", "m-discard"},
                           {"full", "Full", "m-full"},
                           {"reweighting", "Reweighting", "m-reweighting"},
                           {"reweighting-normalised", "Rew. self-n.", "m-reweighting"},
                           {"rejection", "Rejection", "m-rejection"},
                           {"ris", "RIS of old", "m-ris"},
                           {"augmentation", "Augmentation", "m-augmentation"},
                           {"rejection-augmentation", "Rej-Aug", "m-rejaug"},
                           {"ra", "R-A", "m-ra"},
                           {"ra-thinned", "R-A thinned", "m-thinned"},
                           {"mis", "MIS", "m-mis"}};

const Look* lookOf(const std::string& method)
{
    const auto found = std::find_if(std::begin(kLooks), std::end(kLooks),
                                    [&](const Look& look) { return method == look.method; });
    return found == std::end(kLooks) ? nullptr : found;
}

size_t orderOf(const std::string& method)
{
    size_t i = 0;
    for (const Method& m : methods()) {
        if (method == m.id) break;
        ++i;
    }
    return i;
}

/// A method that takes part in every table, whatever its n.
bool anyRatio(const std::string& method)
{
    const size_t i = orderOf(method);
    return method == "full" || method == "augmentation" ||
           (i < methods().size() && !methods()[i].fresh);
}

double ratioOf(const Cell& cell)
{
    return cell.oldSamples ? static_cast<double>(cell.newSamples) / cell.oldSamples : 0;
}

bool sameRatio(double a, double b)
{
    return std::abs(a - b) < 1e-9;
}

Column columnOf(const Cell& cell)
{
    return {cell.method, cell.beta, cell.method == "ra" ? cell.candidates : 0};
}

}  // namespace

std::string Column::label() const
{
    const Look* look = lookOf(method);
    std::string text = look ? look->label : method;
    if (method == "ra" && candidates) text.append(" ").append(std::to_string(candidates));
    if (beta == Beta::ideal) text += ", β ideal";
    if (beta == Beta::own && method != "reweighting-normalised") text += ", β own";
    return text;
}

std::string Column::name() const
{
    const size_t i = orderOf(method);
    return i < methods().size() ? methods()[i].name : method;
}

std::string Column::style() const
{
    const Look* look = lookOf(method);
    return look ? look->style : "m-other";
}

CellTable::CellTable(const LabResults& results, double ratio) : ratio_(ratio)
{
    std::set<Row> known;
    std::set<Column> columns;
    for (const Cell& cell : results.cells) {
        const bool exact = sameRatio(ratioOf(cell), ratio);
        if (!exact && !anyRatio(cell.method)) continue;
        const Row row{cell.pair, cell.function};
        if (known.insert(row).second) rows_.push_back(row);
        const Column column = columnOf(cell);
        columns.insert(column);
        const Cell*& entry = cells_[{row, column}];
        if (!entry || exact) entry = &cell;
    }
    columns_.assign(columns.begin(), columns.end());
    std::stable_sort(columns_.begin(), columns_.end(), [](const Column& a, const Column& b) {
        return orderOf(a.method) < orderOf(b.method);
    });
}

bool CellTable::has(const Column& column) const
{
    return std::find(columns_.begin(), columns_.end(), column) != columns_.end();
}

const Cell* CellTable::find(const Row& row, const Column& column) const
{
    const auto found = cells_.find({row, column});
    return found == cells_.end() ? nullptr : found->second;
}

std::vector<double> ratios(const LabResults& results)
{
    std::vector<double> found;
    for (const Cell& cell : results.cells) {
        const double ratio = ratioOf(cell);
        if (anyRatio(cell.method) || ratio == 0) continue;
        if (std::none_of(found.begin(), found.end(), [&](double r) { return sameRatio(r, ratio); }))
            found.push_back(ratio);
    }
    std::sort(found.rbegin(), found.rend());
    return found;
}

/// Old samples alone cannot know what lies where the old density vanishes.
static bool missesSupport(const Cell& cell)
{
    const Pair* pair = findPair(cell.pair);
    return pair && (pair->p.low() < pair->q.low() || pair->p.high() > pair->q.high());
}

bool isBiased(const Cell& cell)
{
    const size_t i = orderOf(cell.method);
    if (i < methods().size() && !methods()[i].unbiased) return true;
    if (cell.beta == Beta::own) return true;
    // A function may be so symmetric that what is missed equals what is counted twice, by
    // coincidence.
    if (i < methods().size() && !methods()[i].fresh && missesSupport(cell)) return true;
    return std::isfinite(cell.expectedMean) &&
           std::abs(cell.expectedMean - cell.truth) > 1e-6 * std::abs(cell.truth);
}

bool isInfinite(const Cell& cell)
{
    return std::isinf(cell.expectedVariance);
}

bool costsMore(const Cell& cell, double n)
{
    // Where the number of rays is random, its mean over the trials wanders.
    const double trials = static_cast<double>(std::max<uint64_t>(cell.trials, 1));
    return cell.rays > 1.1 * n + 5 * std::sqrt(n / trials);
}

std::string fewerTrials(const LabResults& results)
{
    uint64_t fewest = results.trials;
    for (const Cell& cell : results.cells) fewest = std::min(fewest, cell.trials);
    if (fewest == results.trials) return {};
    return " (" + std::to_string(fewest) + " where augmentation draws more than " +
           std::to_string(kMuchAugmentation - 1) + " new samples for each old one)";
}

int compareVariance(const Cell& a, const Cell& b)
{
    const bool known = !std::isnan(a.expectedVariance) && !std::isnan(b.expectedVariance);
    if (known) {
        if (isInfinite(a) || isInfinite(b)) return int(isInfinite(a)) - int(isInfinite(b));
        // Quadrature of a variance that is zero leaves a rounding of the square of the truth.
        const double slack =
            1e-6 * std::max(a.expectedVariance, b.expectedVariance) + 1e-9 * a.truth * a.truth;
        const double difference = a.expectedVariance - b.expectedVariance;
        return std::abs(difference) <= slack ? 0 : difference < 0 ? -1 : 1;
    }
    const double difference = a.variance - b.variance;
    const double error = std::hypot(a.varianceError, b.varianceError);
    return !(std::abs(difference) > 3 * error) ? 0 : difference < 0 ? -1 : 1;
}

double decidingVariance(const Cell& cell)
{
    return std::isnan(cell.expectedVariance) ? cell.variance : cell.expectedVariance;
}

double varianceRatio(const Cell& a, const Cell& b)
{
    if (compareVariance(a, b) == 0) return 1;
    const double first = decidingVariance(a), second = decidingVariance(b);
    return std::isinf(second) ? 0 : first / second;
}

Worth worthOf(const CellTable& table, const Column& column, const std::vector<Row>& rows)
{
    Worth worth;
    std::vector<double> ratios;
    for (const Row& row : rows) {
        const Cell *cell = table.find(row, column), *discard = table.find(row, {"discard"});
        if (!cell || !discard || isBiased(*cell) || isBiased(*discard)) continue;
        worth.withinBudget = worth.withinBudget && !table.exceedsBudget(*cell);
        const double ratio = varianceRatio(*cell, *discard);
        if (!std::isnan(ratio)) ratios.push_back(ratio);
    }
    worth.rows = ratios.size();
    if (ratios.empty()) return worth;
    std::sort(ratios.begin(), ratios.end());
    const double low = ratios[(ratios.size() - 1) / 2], high = ratios[ratios.size() / 2];
    worth.median = low == high ? low : (low + high) / 2;
    return worth;
}

std::vector<Column> winners(const CellTable& table, const Row& row, const std::vector<Beta>& betas)
{
    std::vector<std::pair<Column, const Cell*>> fit;
    for (const Column& column : table.columns()) {
        const Cell* cell = table.find(row, column);
        if (!cell || isBiased(*cell) || isInfinite(*cell) || table.exceedsBudget(*cell)) continue;
        if (column.method != "discard" &&
            std::find(betas.begin(), betas.end(), column.beta) == betas.end())
            continue;
        fit.emplace_back(column, cell);
    }
    std::vector<Column> best;
    for (const auto& [column, cell] : fit)
        if (std::none_of(fit.begin(), fit.end(), [&, mine = cell](const auto& other) {
                return compareVariance(*other.second, *mine) < 0;
            }))
            best.push_back(column);
    return best;
}

Duel duel(const CellTable& table, const Column& a, const Column& b, Judge judge)
{
    Duel result;
    for (const Row& row : table.rows()) {
        const Cell *first = table.find(row, a), *second = table.find(row, b);
        if (!first || !second) continue;
        if (judge == Judge::unbiased && (isBiased(*first) || isBiased(*second))) continue;
        const int order = compareVariance(*first, *second);
        (order < 0 ? result.wins : order > 0 ? result.losses : result.ties).push_back(row);
    }
    return result;
}

double varianceDeviation(const Cell& cell)
{
    if (!std::isfinite(cell.expectedVariance)) return kUnknown;
    const double difference = cell.variance - cell.expectedVariance;
    // A method without variance is either right to rounding or certainly wrong.
    if (std::abs(difference) <= 1e-9 * cell.truth * cell.truth) return 0;
    return cell.varianceError > 0 ? difference / cell.varianceError : kInfinite;
}

Verdict verdict(const LabResults& results)
{
    Verdict v;
    v.cells = results.cells.size();
    for (const Cell& cell : results.cells) {
        const double z = std::abs(cell.z());
        if (isInfinite(cell)) ++v.infinite;
        if (isBiased(cell)) {
            ++v.biased;
            if (z > kMeanBound) ++v.biasedSeen;
        } else if (!isInfinite(cell)) {
            ++v.meansJudged;
            v.largestZ = std::max(v.largestZ, z);
            if (!(z <= kMeanBound)) v.meansOff.push_back(&cell);
        }
        const double deviation = std::abs(varianceDeviation(cell));
        if (std::isnan(deviation)) continue;
        ++v.variancesJudged;
        if (deviation > kVarianceBound) v.variancesOff.push_back(&cell);
    }
    return v;
}

}  // namespace app::lab

// What the cells show, as data: who wins a row, who beats whom in how many rows, which cells
// contradict their expectation. Used by the report and by its tests.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/lab/results.h"

namespace app::lab {

/// Bounds of the laboratory: |z| of a mean, standard errors of a variance, both for families of
/// about a thousand cells.
inline constexpr double kMeanBound = 4.5, kVarianceBound = 5;

/// The number of candidates that stands for R-A where only one can be shown.
inline constexpr uint32_t kUsualCandidates = 4;

/// A way to estimate: a method, what it subtracts, its candidates.
struct Column {
    std::string method;
    Beta beta = Beta::none;
    uint32_t candidates = 0;  // of R-A; of thinned R-A they follow from the pair

    friend auto operator<=>(const Column&, const Column&) = default;
    /// "R-A 4", "MIS, β ideal": short enough for the head of a column.
    std::string label() const;
    /// "Reweighting-Augmentation": the method in full.
    std::string name() const;
    /// The class of its colour in the style sheet.
    std::string style() const;
};

/// A line of the table: one function under one change of density.
struct Row {
    std::string pair, function;

    friend auto operator<=>(const Row&, const Row&) = default;
};

/// More new evaluations of f per trial than `n`, beyond chance and the rounding of sample counts.
bool costsMore(const Cell& cell, double n);

/// The cells with one number of new samples per old sample, as a table.
class CellTable {
public:
    /// `ratio` is n/N. Methods that draw nothing new, or need not draw n, belong to every ratio.
    CellTable(const LabResults& results, double ratio);

    const std::vector<Row>& rows() const { return rows_; }           // as they came
    const std::vector<Column>& columns() const { return columns_; }  // in the order of methods()
    double ratio() const { return ratio_; }
    /// Whether a cell of the table spends more rays than its row allows.
    bool exceedsBudget(const Cell& cell) const { return costsMore(cell, ratio_ * cell.oldSamples); }
    bool has(const Column& column) const;

    /// Null where the method was not run: its needs are not met.
    const Cell* find(const Row& row, const Column& column) const;

private:
    double ratio_;
    std::vector<Row> rows_;
    std::vector<Column> columns_;
    std::map<std::pair<Row, Column>, const Cell*> cells_;
};

/// The ratios n/N that the cells hold, largest first.
std::vector<double> ratios(const LabResults& results);

/// Whether the mean is expected to miss the truth: the method is biased, its needs are not met, or
/// the expected mean says so.
bool isBiased(const Cell& cell);
/// Provably infinite: what was measured means nothing.
bool isInfinite(const Cell& cell);

/// What follows the number of trials: "", or " (25000 where ...)" if some cells have fewer.
std::string fewerTrials(const LabResults& results);

/// -1, 0, 1 as the N Var of a is less than, indistinguishable from, or more than that of b.
/// Expected values decide where both are known, else measured ones and their errors.
int compareVariance(const Cell& a, const Cell& b);

/// The decidingVariance of a over that of b: 1 where they cannot be told apart, 0 and infinite
/// where only one of them has none or an infinite one.
double varianceRatio(const Cell& a, const Cell& b);

/// N Var to compare by: the expected one where there is one, else as measured.
double decidingVariance(const Cell& cell);

/// What a method is worth on several rows: the median of its ratios to Discard.
struct Worth {
    double median = kUnknown;
    size_t rows = 0;           // in which both are unbiased
    bool withinBudget = true;  // in all of them
};
Worth worthOf(const CellTable& table, const Column& column, const std::vector<Row>& rows);

/// The unbiased columns with no more than n rays that no other such column beats; only columns with
/// a correction in `betas` take part, and Discard, which has nothing to correct.
std::vector<Column> winners(const CellTable& table, const Row& row, const std::vector<Beta>& betas);

/// One column against another, row by row.
struct Duel {
    std::vector<Row> wins, ties, losses;
    size_t rows() const { return wins.size() + ties.size() + losses.size(); }
};
enum class Judge { unbiased, evenBiased };
/// Rows in which both were run and, unless told otherwise, both are unbiased.
Duel duel(const CellTable& table, const Column& a, const Column& b, Judge judge = Judge::unbiased);

/// Cells whose mean or variance is not as expected, and how many were looked at.
struct Verdict {
    size_t cells = 0;
    size_t infinite = 0;     // exempt: no finite variance
    size_t biased = 0;       // known to be biased
    size_t biasedSeen = 0;   // of these, with |z| above the bound
    size_t meansJudged = 0;  // unbiased and finite
    std::vector<const Cell*> meansOff;
    size_t variancesJudged = 0;
    std::vector<const Cell*> variancesOff;
    double largestZ = 0;  // of the judged means
};
Verdict verdict(const LabResults& results);

/// Standard errors between measured and expected N Var; NaN where there is no finite expectation.
double varianceDeviation(const Cell& cell);

}  // namespace app::lab

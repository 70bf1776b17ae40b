// Completion by matching: the loop over blocks of columns, and what becomes of one column.
#include "core/completion/matching.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace core::many_lights {

namespace {

constexpr uint64_t kWindow = 32;  // columns after which bailing out is considered
constexpr size_t kMostCandidates = 255;
constexpr double kNear =
    0.2;  // share of sampled rows in which a column may differ from the nearest
// Rows by light, of those at the rates: of a column of mean brightness, the dimmest, the brightest.
constexpr double kMeanLight = 0.5, kDimmest = 0.125, kBrightest = 3;
constexpr uint32_t kFewestByLight = 8;
// Brightness, of the mean's, from which a match is traced at the borders of its shadows: what is
// found there of dimmer columns takes up to a tenth of all rays and would hardly be seen.
constexpr double kBordersFrom = 1;

size_t blockSize(const CompletionParams& params, size_t columns)
{
    return params.twoPhase ? columns : std::min<size_t>(std::max(params.block, 1u), columns);
}

}  // namespace

MatchingOctant::MatchingOctant(Tracer& tracer, std::span<const uint32_t> columns,
                               const CompletionParams& params, uint64_t seed, CompletedSlice& out)
    : Octant(tracer, columns, params, seed, blockSize(params, columns.size()), out),
      blockSize_(blockSize(params, columns.size())), basis_(rows_), samples_(tracer.all().size()),
      checks_(samples_.size()), apart_(samples_.size()), scratch_(samples_.size()),
      rest_(samples_.size()), eligible_(samples_.size()), memory_(samples_.size())
{
    if (params.seedConstant) basis_.push(tracer.all(), tracer.all());
}

void MatchingOctant::run()
{
    for (size_t at = 0; at < columns_.size();) {
        // Where nothing is known a column has nothing to be compared with.
        const size_t most = basis_.size() == 0 && !params_.twoPhase ? 1 : blockSize_;
        const size_t count = std::min(most, columns_.size() - at);
        runBlock(columns_.subspan(at, count));
        at += count;
        if (!bailsOut()) continue;
        for (; at < columns_.size(); ++at) {
            block_.begin(columns_.subspan(at, 1));
            block_.fetch(0, tracer_.all());
            noteFull(0);
            ++stats_.bailedOut;
        }
    }
    finish(basis_.size());
}

void MatchingOctant::runBlock(std::span<const uint32_t> columns)
{
    block_.begin(columns);
    if (basis_.size() == 0 && !params_.twoPhase) {
        traceFully(0);
        windowTraced_ = 0;  // with nothing to match, that tells nothing of the columns to come
        return;
    }
    drawRows();
    if (params_.joint)
        for (size_t w = 0; w < rest_.size(); ++w) rest_[w] = samples_[w] | checks_[w];
    else
        rest_ = samples_;
    block_.fetchAll(rest_, apart_);
    basis_.select(samples_, checks_);
    if (params_.twoPhase) traceRepresentatives();
    for (size_t c = 0; c < block_.size(); ++c) completeColumn(c);
}

void MatchingOctant::drawRows()
{
    block_.unionOfMatters(eligible_);
    std::ranges::fill(samples_, 0);
    std::ranges::fill(checks_, 0);
    std::ranges::fill(apart_, 0);
    rowFactor_ = rowFactor();
    drawn_ = byLight(sampleCount());
    checked_ = byLight(checkCount());
    drawSamples(drawn_, eligible_, samples_);
    for (size_t w = 0; w < eligible_.size(); ++w) eligible_[w] &= ~samples_[w];
    if (params_.joint && checked_ > 0) {
        drawUniform(checked_, eligible_, random_, checks_);
        for (size_t w = 0; w < eligible_.size(); ++w) eligible_[w] &= ~checks_[w];
    }
    if (params_.residualRate > 0) {
        const auto count = static_cast<uint32_t>(std::ceil(double(params_.residualRate) * rows_));
        apartProbability_ = drawUniform(count, eligible_, random_, apart_);
    }
}

/// What the number of rows at the rates is multiplied by. A wrong bit counts as much as its column
/// is bright: where all columns are sampled alike, few bright ones make most of the error, and most
/// rows are spent on columns whose errors nobody would see. The variance of the error is least for
/// a given number of rows when these are in proportion to the light. In two phases an octant is one
/// block, whose columns have nothing in common.
double MatchingOctant::rowFactor() const
{
    if (!params_.rowsByLight || params_.twoPhase) return 1;
    double brightest = 0;
    for (size_t c = 0; c < block_.size(); ++c) {
        const std::optional<float> brightness = tracer_.brightness(block_.column(c));
        if (!brightness) return 1;
        brightest = std::max(brightest, double(*brightness));
    }
    return std::clamp(kMeanLight * brightest, kDimmest, kBrightest);
}

uint32_t MatchingOctant::byLight(uint32_t rows) const
{
    if (rows >= rows_) return rows;  // a rate of 1 is exact
    return std::max(static_cast<uint32_t>(std::lround(rowFactor_ * rows)),
                    std::min(rows, kFewestByLight));
}

/// Of a column, over the mean of the columns; 1 where it is not known.
double MatchingOctant::brightness(size_t c) const
{
    return double(tracer_.brightness(block_.column(c)).value_or(1.0f));
}

/// How far repair trusts a column's candidate: the less, the brighter the column is. One that all
/// sampled rows agree with has been probed by these.
RepairTrust MatchingOctant::trust(size_t c, bool matched) const
{
    return {.stray = double(params_.stray) / std::max(brightness(c), 1e-6),
            .probes = matched ? 0 : brightness(c)};
}

/// Of the columns that agree on the sampled rows, the first is traced in full, all of them at once.
void MatchingOctant::traceRepresentatives()
{
    std::vector<size_t> which;
    const uint32_t before = basis_.size();
    for (size_t c = 0; c < block_.size(); ++c) {
        if (isTraced(c)) continue;
        basis_.makeKey(block_.visible(c), block_.traced(c), key_);
        basis_.match(key_, fewestRows(), candidates_);
        if (!candidates_.empty()) continue;
        which.push_back(c);
        basis_.push(block_.visible(c), block_.traced(c));
    }
    block_.fetchRest(which);
    for (uint32_t k = 0; k < which.size(); ++k)
        basis_.fill({before + k, false}, block_.visible(which[k]), block_.traced(which[k]));
}

void MatchingOctant::completeColumn(size_t c)
{
    const uint32_t active = countBits(block_.matters(c)), sampled = countBits(block_.traced(c));
    windowActive_ += active;
    windowSampled_ += sampled;
    ++windowColumns_;
    keyed_ = false;
    if (sampled == active) {  // nothing is left to predict; such a column costs no comparison later
        noteFull(c);
        return;
    }
    if (sampled < fewestRows()) return traceFully(c);
    basis_.makeKey(block_.visible(c), block_.traced(c), key_);
    keyed_ = true;
    basis_.match(key_, fewestRows(), candidates_);
    if (candidates_.empty()) {
        if (params_.joint && checked_ > 0 && basis_.matchesSamples(key_)) raiseRate();
        return unmatched(c);
    }
    const Candidate candidate = choose(c);
    if (!verify(c, candidate)) {
        raiseRate();
        return traceFully(c);
    }
    take(c, candidate);
}

/// Rows that are still to verify a match. Matched jointly, rows of verification have been traced
/// with the others; but a block draws for all of its columns, and one that shares few rows with the
/// candidate has compared few, which may prove too little.
uint32_t MatchingOctant::checksLeft(size_t c, Candidate candidate) const
{
    if (!params_.joint || checked_ == 0) return checked_;
    const auto traced = block_.traced(c), known = basis_.known(candidate.index);
    uint32_t compared = 0;
    for (size_t w = 0; w < known.size(); ++w)
        compared += static_cast<uint32_t>(std::popcount(traced[w] & known[w]));
    const uint32_t wanted = drawn_ + checked_;
    return wanted > compared ? wanted - compared : 0;
}

/// Compares a match with further rows after it has been chosen, as the paper does.
bool MatchingOctant::verify(size_t c, Candidate candidate)
{
    const uint32_t count = checksLeft(c, candidate);
    if (count == 0) return true;
    const auto bits = basis_.bits(candidate.index), known = basis_.known(candidate.index);
    fetchChecks(c, count, known, checks_);
    const auto visible = block_.visible(c);
    uint64_t wrong = 0;
    for (size_t w = 0; w < checks_.size(); ++w) {
        const uint64_t predicted = candidate.complement ? ~bits[w] : bits[w];
        wrong |= (predicted ^ visible[w]) & known[w] & checks_[w];
    }
    return wrong == 0;
}

Candidate MatchingOctant::choose(size_t c)
{
    if (candidates_.size() == 1) return candidates_[0];
    ++stats_.ambiguous;
    if (params_.disambiguate) return ask(c);
    return candidates_[drawBelow(static_cast<uint32_t>(candidates_.size()), random_)];
}

/// Traces rows on which candidates disagree until one is left, or those left agree wherever all
/// are known: then the one that is known in the most rows.
Candidate MatchingOctant::ask(size_t c)
{
    if (candidates_.size() > kMostCandidates) candidates_.resize(kMostCandidates);
    while (candidates_.size() > 1) {
        const std::optional<uint32_t> row = dividingRow(c);
        if (!row) break;
        const bool lit = block_.fetchRow(c, *row);
        std::erase_if(candidates_, [&](const Candidate& candidate) {
            return (getBit(basis_.bits(candidate.index), *row) != candidate.complement) != lit;
        });
    }
    const auto unknown = [&](const Candidate& candidate) {
        const auto known = basis_.known(candidate.index), matters = block_.matters(c);
        uint32_t count = 0;
        for (size_t w = 0; w < known.size(); ++w)
            count += static_cast<uint32_t>(std::popcount(matters[w] & ~known[w]));
        return count;
    };
    return *std::ranges::min_element(candidates_, {}, unknown);
}

/// The row, not yet traced and known to all candidates, that divides them most evenly; one of
/// several at random.
std::optional<uint32_t> MatchingOctant::dividingRow(size_t c)
{
    const auto matters = block_.matters(c), traced = block_.traced(c);
    for (size_t w = 0; w < rest_.size(); ++w) rest_[w] = matters[w] & ~traced[w];
    if (candidates_.size() <= 3) return anyRow(keepDivided(rest_));
    counts_.begin(rest_, static_cast<uint32_t>(candidates_.size()));
    for (const Candidate& candidate : candidates_) {
        counts_.keep(basis_.known(candidate.index));
        counts_.add(basis_.bits(candidate.index), candidate.complement);
    }
    return anyRow(counts_.mostEven());
}

/// Leaves those of `rows` that two or three candidates know and that divide them, all of which do
/// so equally well.
std::span<const uint64_t> MatchingOctant::keepDivided(Words& rows)
{
    const Candidate& first = candidates_.front();
    std::ranges::fill(scratch_, 0);
    const auto bits = basis_.bits(first.index);
    for (const Candidate& other : std::span(candidates_).subspan(1)) {
        const auto otherBits = basis_.bits(other.index);
        const uint64_t flip = other.complement != first.complement ? ~uint64_t(0) : 0;
        for (size_t w = 0; w < rows.size(); ++w) scratch_[w] |= bits[w] ^ otherBits[w] ^ flip;
    }
    for (size_t w = 0; w < rows.size(); ++w) rows[w] &= scratch_[w];
    for (const Candidate& candidate : candidates_) {
        const auto known = basis_.known(candidate.index);
        for (size_t w = 0; w < rows.size(); ++w) rows[w] &= known[w];
    }
    return rows;
}

std::optional<uint32_t> MatchingOctant::anyRow(std::span<const uint64_t> rows)
{
    const uint32_t found = countBits(rows);
    if (found == 0) return std::nullopt;
    return rowOfNumber(rows, drawBelow(found, random_));
}

/// Completes a column by a candidate that agrees with it. Rows that the candidate does not know
/// are traced, and both know them from then on.
void MatchingOctant::take(size_t c, Candidate candidate)
{
    const auto known = basis_.known(candidate.index), matters = block_.matters(c);
    uint64_t unknown = 0;
    for (size_t w = 0; w < rest_.size(); ++w) {
        rest_[w] = matters[w] & ~known[w];
        unknown |= rest_[w];
    }
    if (unknown != 0) {
        block_.fetch(c, rest_);
        basis_.fill(candidate, block_.visible(c), rest_);
    }
    if (params_.onMismatch == OnMismatch::repair && brightness(c) >= kBordersFrom) {
        const RepairOutcome outcome =
            repairColumn(block_, c, basis_, candidate, trust(c, true), random_, memory_);
        if (outcome == RepairOutcome::hopeless) return traceFully(c);
        if (outcome == RepairOutcome::differs) return completeRepaired(c);
    } else {
        predict(block_, c, basis_, candidate);
    }
    noteMatched(c, drawn_);
    noteResidual(c);
}

/// What was set aside for the residual and predicted wrongly.
void MatchingOctant::noteResidual(size_t c)
{
    if (params_.residualRate <= 0) return;
    const auto rows = block_.residual(c), truth = block_.residualBits(c);
    const auto visible = block_.visible(c);
    for (size_t w = 0; w < rows.size(); ++w) scratch_[w] = (truth[w] ^ visible[w]) & rows[w];
    const auto weight = static_cast<float>(1 / apartProbability_);
    forEachBit(scratch_, [&](uint32_t i) {
        out_.residual.push_back({i, block_.column(c), getBit(truth, i) ? weight : -weight});
    });
}

/// A column that agrees with none.
void MatchingOctant::unmatched(size_t c)
{
    if (params_.onMismatch == OnMismatch::full) return traceFully(c);
    const auto nearest = basis_.nearest(key_, fewestRows());
    if (!nearest || nearest->differ > kNear * nearest->common) return traceFully(c);
    if (params_.onMismatch == OnMismatch::recursion)
        recurseColumn(block_, c, basis_, nearest->candidate, memory_);
    else if (repairColumn(block_, c, basis_, nearest->candidate, trust(c, false), random_,
                          memory_) == RepairOutcome::hopeless)
        return traceFully(c);
    completeRepaired(c);
}

/// Counts and learns a column that was predicted by one that it is not.
void MatchingOctant::completeRepaired(size_t c)
{
    noteRepaired(c);
    noteResidual(c);
    learn(c);
}

void MatchingOctant::traceFully(size_t c)
{
    fetchAll(c);
    append(c);
}

/// Makes a completed column part of the basis, unless an equal one is or it is too small.
void MatchingOctant::append(size_t c)
{
    const std::span<const uint64_t> bits = block_.visible(c), known = block_.matters(c);
    if (countBits(known) <= params_.smallSlice) return;
    if (const auto equal = basis_.findEqual(bits, known, keyed_ ? &key_ : nullptr))
        basis_.fill(*equal, bits, known);
    else
        basis_.push(bits, known);
}

/// Makes a column that was traced in part a known one.
void MatchingOctant::learn(size_t c)
{
    if (params_.adaptiveRows) weights_.addRuns(block_.visible(c), block_.matters(c));
    append(c);
}

/// What sampling leaves open decides: bright columns, which come first, may be sampled in most of
/// their rows, and tell nothing by that of those to come.
bool MatchingOctant::bailsOut()
{
    if (params_.bailOut >= 1 || windowColumns_ < kWindow) return false;
    const bool hopeless = double(windowTraced_ - windowSampled_) >
                          double(params_.bailOut) * double(windowActive_ - windowSampled_);
    windowColumns_ = windowTraced_ = windowActive_ = windowSampled_ = 0;
    return hopeless;
}

}  // namespace core::many_lights

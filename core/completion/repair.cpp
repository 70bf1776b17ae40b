// Repair of predicted columns.
#include "core/completion/repair.h"

#include <algorithm>
#include <bit>

#include "core/completion/row_weights.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kPatch = 16;  // rows
constexpr uint32_t kPatchesPerWord = 64 / kPatch;
constexpr double kHopeless = 0.6;  // share of a column's rows

/// The rows begin <= i < end of word w.
uint64_t rangeInWord(uint32_t begin, uint32_t end, size_t w)
{
    return wordOfRows(end, w) & ~wordOfRows(begin, w);
}

/// One column and its candidate, for both ways of repair.
struct Prediction {
    Prediction(Block& b, size_t column, const Basis& basis, Candidate candidate,
               RepairMemory& memory)
        : block(b), c(column), visible(b.visible(column)), traced(b.traced(column)),
          common(memory.common), bits(memory.bits)
    {
        const auto matters = b.matters(column), known = basis.known(candidate.index);
        const auto source = basis.bits(candidate.index);
        const uint64_t flip = candidate.complement ? ~uint64_t(0) : 0;
        uint64_t anyWrong = 0, anyUnknown = 0, lit = 0, dark = 0;
        uint64_t* __restrict toCommon = common.data();
        uint64_t* __restrict toBits = bits.data();
        for (size_t w = 0, words = visible.size(); w < words; ++w) {
            const uint64_t both = matters[w] & known[w], predicted = (source[w] ^ flip) & both;
            toCommon[w] = both;
            toBits[w] = predicted;
            anyUnknown |= matters[w] & ~known[w];
            anyWrong |= (visible[w] ^ predicted) & traced[w] & both;
            lit |= predicted;
            dark |= both & ~predicted;
        }
        complete = anyUnknown == 0;
        evident = anyWrong == 0 && (lit == 0 || dark == 0);
    }

    size_t words() const { return bits.size(); }
    /// Traced rows that are not as predicted.
    uint64_t wrong(size_t w) const { return (visible[w] ^ bits[w]) & traced[w] & common[w]; }
    /// Writes what is predicted to the rows that have not been traced.
    void write() const
    {
        const std::span<uint64_t> to = block.visible(c);
        for (size_t w = 0; w < to.size(); ++w) to[w] |= bits[w] & ~traced[w];
    }

    Block& block;
    size_t c;
    std::span<const uint64_t> visible, traced;
    std::span<uint64_t> common, bits;  // RepairMemory's
    bool complete;                     // the candidate knows all rows that matter
    bool evident;                      // all light or all shadow, and every traced row agrees
};

/// Traces the rows that matter and that the candidate does not know, and those of `ask`.
void fetchUnknown(const Prediction& p, Words& ask)
{
    const auto matters = p.block.matters(p.c);
    for (size_t w = 0; w < ask.size(); ++w) ask[w] |= matters[w] & ~p.common[w];
    p.block.fetch(p.c, ask);
}

/// Collects in `ask` what recursion traces of the rows begin..end.
void recurse(const Prediction& p, uint32_t begin, uint32_t end, Words& ask)
{
    uint64_t traced = 0, wrong = 0;
    for (size_t w = begin / 64; w < wordsFor(end); ++w) {
        const uint64_t range = rangeInWord(begin, end, w);
        traced |= p.traced[w] & range;
        wrong |= p.wrong(w) & range;
    }
    if (wrong == 0 && traced != 0) return;
    const uint32_t patches = (end - begin + kPatch - 1) / kPatch;
    if (wrong == 0 || patches == 1) {
        for (size_t w = begin / 64; w < wordsFor(end); ++w) ask[w] |= rangeInWord(begin, end, w);
        return;
    }
    const uint32_t middle = begin + kPatch * (patches / 2);
    recurse(p, begin, middle, ask);
    recurse(p, middle, end, ask);
}

/// All rows of the patches of which a row is set.
uint64_t wholePatches(uint64_t rows)
{
    constexpr uint64_t kLow = 0x7fff7fff7fff7fff, kTop = ~kLow;
    const uint64_t tops = (((rows & kLow) + kLow) | rows) & kTop;
    return tops | (tops - (tops >> 15));
}

/// Word w of `rows`, and the rows of the patches next to them.
uint64_t withNeighbours(const Words& rows, size_t w)
{
    const uint64_t here = rows[w];
    const uint64_t before = w > 0 ? rows[w - 1] >> (64 - kPatch) : 0;
    const uint64_t behind = w + 1 < rows.size() ? rows[w + 1] << (64 - kPatch) : 0;
    return here | here << kPatch | here >> kPatch | before | behind;
}

class Repair {
public:
    Repair(const Prediction& prediction, RepairTrust trust, Pcg32& random, RepairMemory& memory)
        : p_(prediction), trust_(trust), random_(random),
          most_(kHopeless * countBits(p_.block.matters(p_.c))), memory_(memory)
    {
        std::ranges::fill(memory_.asked, 0);
        std::ranges::fill(memory_.ask, 0);
    }

    RepairOutcome run()
    {
        markBorders();
        if (strays()) return RepairOutcome::hopeless;
        if (countBits(memory_.ask) > most_)
            return wrongRows() > 0 ? RepairOutcome::hopeless : RepairOutcome::agrees;
        markWrong(1);
        if (!spread()) return RepairOutcome::hopeless;
        if (trust_.probes > 0 && !probe()) return RepairOutcome::hopeless;
        return wrongRows() > 0 ? RepairOutcome::differs : RepairOutcome::agrees;
    }

private:
    /// Traces what is marked, and the neighbours of what turns out wrong. False: it becomes most of
    /// the column.
    bool spread()
    {
        while (fetch()) {
            if (countBits(p_.block.traced(p_.c)) > most_) return false;
            markWrong(2);
        }
        return true;
    }

    /// Looks for what repair was not led to. False: there is too much of it.
    bool probe()
    {
        const auto findsWrong = [&](bool everywhere) {
            const uint32_t before = wrongRows();
            askProbes(everywhere);
            return fetch() && wrongRows() > before;
        };
        if (findsWrong(false)) {
            if (strays()) return false;
            markWrong(2);
            if (!spread()) return false;
        }
        return !findsWrong(true);
    }

    /// Asks for a row, not yet traced, of patches drawn at random; unless `everywhere`, of those of
    /// which no row has been traced.
    void askProbes(bool everywhere)
    {
        for (uint32_t w = 0; w < p_.words(); ++w) {
            const uint64_t traced = p_.common[w] & p_.traced[w];
            const uint64_t left = p_.common[w] & ~(everywhere ? traced : wholePatches(traced));
            if (left == 0) continue;
            for (uint32_t k = 0; k < kPatchesPerWord; ++k) {
                const uint64_t rows = left & rowsOf(k);
                if (rows == 0) continue;
                if (double(random_()) >= trust_.probes) continue;
                const uint32_t chosen =
                    drawBelow(static_cast<uint32_t>(std::popcount(rows)), random_);
                memory_.ask[w] |= uint64_t(1) << placeOfBit(rows, chosen);
                waiting_ = true;
            }
        }
    }

    uint32_t wrongRows() const
    {
        uint32_t count = 0;
        for (size_t w = 0; w < p_.words(); ++w)
            count += static_cast<uint32_t>(std::popcount(p_.wrong(w)));
        return count;
    }

    /// The rows of a patch of a word.
    static uint64_t rowsOf(uint32_t patch)
    {
        return ((uint64_t(1) << kPatch) - 1) << (kPatch * patch);
    }

    /// Asks for whole patches of word w, each once.
    void mark(size_t w, uint64_t patches)
    {
        const uint64_t fresh = patches & ~memory_.asked[w];
        memory_.asked[w] |= fresh;
        memory_.ask[w] |= fresh;
        waiting_ = waiting_ || fresh != 0;
    }

    /// Patches where the candidate changes, inside or against the patch before.
    void markBorders()
    {
        constexpr uint64_t kAll = ~uint64_t(0);
        Last last;
        for (size_t w = 0; w < p_.words(); ++w) {
            const uint64_t lit = wholePatches(p_.bits[w]),
                           dark = wholePatches(p_.common[w] & ~p_.bits[w]);
            if ((lit | dark) != kAll) {
                markBordersOneByOne(w, lit, dark, last);
                continue;
            }
            const uint64_t litBefore = lit << kPatch | (last.lit ? rowsOf(0) : 0),
                           darkBefore = dark << kPatch | (last.dark ? rowsOf(0) : 0);
            uint64_t change = (lit ^ litBefore) | (dark ^ darkBefore);
            if (!last.lit && !last.dark) change &= ~rowsOf(0);
            if ((change & rowsOf(0)) != 0) mark(last.word, last.rows);
            mark(w, (lit & dark) | change | change >> kPatch);
            constexpr uint32_t kEnd = kPatchesPerWord - 1;
            last = {(lit & rowsOf(kEnd)) != 0, (dark & rowsOf(kEnd)) != 0, w, rowsOf(kEnd)};
        }
    }

    /// The last patch with rows that matter: what it shows, and where it lies.
    struct Last {
        bool lit = false, dark = false;
        size_t word = 0;
        uint64_t rows = 0;
    };

    /// The same in a word some of whose patches show nothing.
    void markBordersOneByOne(size_t w, uint64_t lit, uint64_t dark, Last& last)
    {
        for (uint32_t k = 0; k < kPatchesPerWord; ++k) {
            const uint64_t rows = rowsOf(k);
            const bool isLit = (lit & rows) != 0, isDark = (dark & rows) != 0;
            if (!isLit && !isDark) continue;
            if (isLit && isDark) mark(w, rows);
            if ((last.lit || last.dark) && (isLit != last.lit || isDark != last.dark)) {
                mark(last.word, last.rows);
                mark(w, rows);
            }
            last = {isLit, isDark, w, rows};
        }
    }

    /// Whether too many of the traced rows are not as predicted, of patches neither marked nor
    /// beside one that is.
    bool strays() const
    {
        if (wrongRows() == 0) return false;
        uint32_t traced = 0, wrong = 0;
        for (size_t w = 0; w < p_.words(); ++w) {
            const uint64_t away = ~withNeighbours(memory_.asked, w);
            traced += static_cast<uint32_t>(std::popcount(p_.traced[w] & p_.common[w] & away));
            wrong += static_cast<uint32_t>(std::popcount(p_.wrong(w) & away));
        }
        return wrong > trust_.stray * traced;
    }

    /// Patches with traced rows that were predicted wrongly, and those around.
    void markWrong(int reach)
    {
        Words& wrong = memory_.wrong;
        uint64_t any = 0;
        for (size_t w = 0; w < wrong.size(); ++w) any |= wrong[w] = p_.wrong(w);
        if (any == 0) return;
        for (uint64_t& word : wrong) word = wholePatches(word);
        for (; reach > 0; --reach) {
            memory_.near.swap(wrong);
            for (size_t w = 0; w < wrong.size(); ++w) wrong[w] = withNeighbours(memory_.near, w);
        }
        for (size_t w = 0; w < wrong.size(); ++w) mark(w, wrong[w]);
    }

    bool fetch()
    {
        if (!waiting_) return false;
        p_.block.fetch(p_.c, memory_.ask);
        std::ranges::fill(memory_.ask, 0);
        waiting_ = false;
        return true;
    }

    const Prediction& p_;
    RepairTrust trust_;
    Pcg32& random_;
    double most_;  // rows traced before a column is given up
    RepairMemory& memory_;
    bool waiting_ = false;
};

}  // namespace

void predict(Block& block, size_t c, const Basis& basis, Candidate candidate)
{
    const auto bits = basis.bits(candidate.index), known = basis.known(candidate.index);
    const auto matters = block.matters(c), traced = block.traced(c);
    const auto visible = block.visible(c);
    const uint64_t flip = candidate.complement ? ~uint64_t(0) : 0;
    for (size_t w = 0; w < visible.size(); ++w)
        visible[w] |= (bits[w] ^ flip) & known[w] & matters[w] & ~traced[w];
}

void recurseColumn(Block& block, size_t c, const Basis& basis, Candidate candidate,
                   RepairMemory& memory)
{
    const Prediction p(block, c, basis, candidate, memory);
    std::ranges::fill(memory.ask, 0);
    recurse(p, 0, static_cast<uint32_t>(64 * p.words()), memory.ask);
    fetchUnknown(p, memory.ask);
    predict(block, c, basis, candidate);
}

RepairOutcome repairColumn(Block& block, size_t c, const Basis& basis, Candidate candidate,
                           RepairTrust trust, Pcg32& random, RepairMemory& memory)
{
    const Prediction p(block, c, basis, candidate, memory);
    if (!p.complete) {
        std::ranges::fill(memory.ask, 0);
        fetchUnknown(p, memory.ask);
    }
    const RepairOutcome outcome = p.evident && trust.probes <= 0
                                      ? RepairOutcome::agrees
                                      : Repair(p, trust, random, memory).run();
    if (outcome != RepairOutcome::hopeless) p.write();
    return outcome;
}

}  // namespace core::many_lights

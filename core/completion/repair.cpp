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
        for (size_t w = 0; w < visible.size(); ++w) {
            common[w] = matters[w] & known[w];
            bits[w] = (source[w] ^ flip) & common[w];
        }
    }

    size_t words() const { return bits.size(); }
    /// Traced rows that are not as predicted.
    uint64_t wrong(size_t w) const { return (visible[w] ^ bits[w]) & traced[w] & common[w]; }

    Block& block;
    size_t c;
    std::span<const uint64_t> visible, traced;
    std::span<uint64_t> common, bits;  // RepairMemory's
};

/// Traces the rows that matter and that the candidate does not know, and those of `ask`.
void fetchUnknown(const Prediction& p, Words& ask)
{
    const auto matters = p.block.matters(p.c);
    uint64_t any = 0;
    for (size_t w = 0; w < ask.size(); ++w) any |= (ask[w] |= matters[w] & ~p.common[w]);
    if (any != 0) p.block.fetch(p.c, ask);
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

/// What a patch of the candidate shows, in the rows that matter.
enum class Patch : uint8_t { empty, dark, lit, mixed };

class Repair {
public:
    Repair(const Prediction& prediction, RepairTrust trust, Pcg32& random, RepairMemory& memory)
        : p_(prediction), trust_(trust), random_(random),
          most_(kHopeless * countBits(p_.block.matters(p_.c))),
          patches_(kPatchesPerWord * static_cast<uint32_t>(p_.words())), asked_(memory.asked),
          spread_(memory.spread), ask_(memory.ask)
    {
        asked_.assign(patches_, 0);
        spread_.assign(patches_, 0);
        std::ranges::fill(ask_, 0);
    }

    RepairOutcome run()
    {
        markBorders();
        if (strays()) return RepairOutcome::hopeless;
        if (countBits(ask_) > most_)
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
        for (uint32_t k = 0; k < patches_; ++k) {
            const uint32_t w = k / kPatchesPerWord;
            const uint64_t patch = p_.common[w] & rowsOf(k);
            uint64_t rows = patch & ~p_.traced[w];
            if (rows == 0 || (rows != patch && !everywhere)) continue;
            if (double(random_()) >= trust_.probes) continue;
            for (uint32_t skip = drawBelow(static_cast<uint32_t>(std::popcount(rows)), random_);
                 skip > 0; --skip)
                rows &= rows - 1;
            ask_[w] |= rows & (~rows + 1);
            waiting_ = true;
        }
    }

    uint32_t wrongRows() const
    {
        uint32_t count = 0;
        for (size_t w = 0; w < p_.words(); ++w)
            count += static_cast<uint32_t>(std::popcount(p_.wrong(w)));
        return count;
    }

    static uint64_t rowsOf(uint32_t patch)
    {
        return ((uint64_t(1) << kPatch) - 1) << (kPatch * (patch % kPatchesPerWord));
    }

    void mark(uint32_t patch)
    {
        if (asked_[patch] != 0) return;
        asked_[patch] = 1;
        ask_[patch / kPatchesPerWord] |= rowsOf(patch);
        waiting_ = true;
    }
    void markAround(uint32_t patch, uint32_t reach)
    {
        const uint32_t first = patch > reach ? patch - reach : 0;
        for (uint32_t k = first; k <= std::min(patch + reach, patches_ - 1); ++k) mark(k);
    }

    /// Patches where the candidate changes, inside or against the patch before.
    void markBorders()
    {
        Patch last = Patch::empty;
        uint32_t lastIndex = 0;
        for (uint32_t w = 0; w < p_.words(); ++w) {
            const Patch whole = look(p_.common[w], p_.bits[w]);
            if (whole == Patch::empty) continue;
            if (whole == last && whole != Patch::mixed) {  // as most words are
                lastIndex = lastPatch(w);
                continue;
            }
            for (uint32_t k = kPatchesPerWord * w; k < kPatchesPerWord * (w + 1); ++k) {
                const Patch here = look(p_.common[w] & rowsOf(k), p_.bits[w] & rowsOf(k));
                if (here == Patch::empty) continue;
                if (here == Patch::mixed) mark(k);
                if (last != Patch::empty && last != here) {
                    mark(lastIndex);
                    mark(k);
                }
                last = here;
                lastIndex = k;
            }
        }
    }

    /// Whether too many of the traced rows are not as predicted, of patches neither marked nor
    /// beside one that is.
    bool strays() const
    {
        if (wrongRows() == 0) return false;
        uint32_t traced = 0, wrong = 0;
        for (uint32_t k = 0; k < patches_; ++k) {
            const bool near = asked_[k] != 0 || (k > 0 && asked_[k - 1] != 0) ||
                              (k + 1 < patches_ && asked_[k + 1] != 0);
            if (near) continue;
            const uint32_t w = k / kPatchesPerWord;
            const uint64_t rows = rowsOf(k);
            traced += static_cast<uint32_t>(std::popcount(p_.traced[w] & p_.common[w] & rows));
            wrong += static_cast<uint32_t>(std::popcount(p_.wrong(w) & rows));
        }
        return wrong > trust_.stray * traced;
    }

    static Patch look(uint64_t rows, uint64_t lit)
    {
        if (rows == 0) return Patch::empty;
        return lit == 0 ? Patch::dark : lit == rows ? Patch::lit : Patch::mixed;
    }
    uint32_t lastPatch(uint32_t w) const
    {
        return kPatchesPerWord * w +
               static_cast<uint32_t>(63 - std::countl_zero(p_.common[w])) / kPatch;
    }

    /// Patches around traced rows that were predicted wrongly, each once.
    void markWrong(uint32_t reach)
    {
        for (uint32_t w = 0; w < p_.words(); ++w) {
            const uint64_t wrong = p_.wrong(w);
            if (wrong == 0) continue;
            for (uint32_t k = kPatchesPerWord * w; k < kPatchesPerWord * (w + 1); ++k) {
                if (spread_[k] >= reach || (wrong & rowsOf(k)) == 0) continue;
                spread_[k] = static_cast<uint8_t>(reach);
                markAround(k, reach);
            }
        }
    }

    bool fetch()
    {
        if (!waiting_) return false;
        p_.block.fetch(p_.c, ask_);
        std::ranges::fill(ask_, 0);
        waiting_ = false;
        return true;
    }

    const Prediction& p_;
    RepairTrust trust_;
    Pcg32& random_;
    double most_;  // rows traced before a column is given up
    uint32_t patches_;
    std::vector<uint8_t>&asked_, &spread_;
    Words& ask_;
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
    std::ranges::fill(memory.ask, 0);
    fetchUnknown(p, memory.ask);
    const RepairOutcome outcome = Repair(p, trust, random, memory).run();
    if (outcome != RepairOutcome::hopeless) predict(block, c, basis, candidate);
    return outcome;
}

}  // namespace core::many_lights

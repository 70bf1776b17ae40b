// Repair of predicted columns.
#include "core/completion/repair.h"

#include <algorithm>
#include <bit>

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
    Prediction(Block& b, size_t column, const Basis& basis, Candidate candidate)
        : block(b), c(column), visible(b.visible(column)), traced(b.traced(column)),
          common(visible.size()), bits(visible.size())
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
    Words common;  // rows that matter and that the candidate knows
    Words bits;    // what it predicts there
};

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
    explicit Repair(Prediction& prediction)
        : p_(prediction), patches_(kPatchesPerWord * static_cast<uint32_t>(p_.words())),
          asked_(patches_), spread_(patches_), ask_(p_.words())
    {}

    RepairOutcome run(double stray)
    {
        const uint32_t active = countBits(p_.block.matters(p_.c));
        markBorders();
        if (wrongAwayFromBorders() > stray) return RepairOutcome::hopeless;
        markWrong(1);
        while (fetch()) {
            if (countBits(p_.block.traced(p_.c)) > kHopeless * active)
                return RepairOutcome::hopeless;
            markWrong(2);
        }
        bool differs = false;
        for (size_t w = 0; w < p_.words(); ++w) differs |= p_.wrong(w) != 0;
        return differs ? RepairOutcome::differs : RepairOutcome::agrees;
    }

private:
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

    /// Share of the traced rows that are not as predicted, of patches neither marked nor beside one
    /// that is.
    double wrongAwayFromBorders() const
    {
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
        return traced > 0 ? double(wrong) / traced : 0;
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

    Prediction& p_;
    uint32_t patches_;
    std::vector<uint8_t> asked_, spread_;
    Words ask_;
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

void recurseColumn(Block& block, size_t c, const Basis& basis, Candidate candidate)
{
    const Prediction p(block, c, basis, candidate);
    Words ask(p.words());
    recurse(p, 0, static_cast<uint32_t>(64 * p.words()), ask);
    for (size_t w = 0; w < ask.size(); ++w) ask[w] |= ~p.common[w];
    block.fetch(c, ask);
    predict(block, c, basis, candidate);
}

RepairOutcome repairColumn(Block& block, size_t c, const Basis& basis, Candidate candidate,
                           double stray)
{
    Prediction p(block, c, basis, candidate);
    Words unknown(p.words());
    for (size_t w = 0; w < unknown.size(); ++w) unknown[w] = ~p.common[w];
    block.fetch(c, unknown);
    const RepairOutcome outcome = Repair(p).run(stray);
    if (outcome != RepairOutcome::hopeless) predict(block, c, basis, candidate);
    return outcome;
}

}  // namespace core::many_lights

// See row_counts.h. Loops over words are functions of their own, with a promise that what is
// written lies nowhere else: without it compilers do not make vectors of them.
#include "core/completion/row_counts.h"

#include <bit>

namespace core::many_lights {

namespace {

uint64_t allOnes(bool when)
{
    return when ? ~uint64_t(0) : 0;
}

void andWith(size_t words, const uint64_t* a, uint64_t* __restrict b)
{
    for (size_t w = 0; w < words; ++w) b[w] &= a[w];
}

void flip(size_t words, const uint64_t* a, uint64_t ones, uint64_t* __restrict b)
{
    for (size_t w = 0; w < words; ++w) b[w] = a[w] ^ ones;
}

void addDigit(size_t words, uint64_t* __restrict digit, uint64_t* __restrict carry)
{
    for (size_t w = 0; w < words; ++w) {
        const uint64_t sum = digit[w] ^ carry[w];
        carry[w] &= digit[w];
        digit[w] = sum;
    }
}

/// A digit of a constant, whose bits there are all `from`, less a number.
void subtractDigit(size_t words, uint64_t from, const uint64_t* number,
                   uint64_t* __restrict difference, uint64_t* __restrict borrow)
{
    for (size_t w = 0; w < words; ++w) {
        difference[w] = from ^ number[w] ^ borrow[w];
        borrow[w] = (~from & (number[w] | borrow[w])) | (number[w] & borrow[w]);
    }
}

/// Where a < b, from the highest digit downwards.
void compareDigit(size_t words, const uint64_t* a, const uint64_t* b, uint64_t* __restrict equal,
                  uint64_t* __restrict less)
{
    for (size_t w = 0; w < words; ++w) {
        less[w] |= equal[w] & ~a[w] & b[w];
        equal[w] &= ~(a[w] ^ b[w]);
    }
}

void copyWhere(size_t words, const uint64_t* where, const uint64_t* a, uint64_t* __restrict b)
{
    for (size_t w = 0; w < words; ++w) b[w] ^= (a[w] ^ b[w]) & where[w];
}

uint64_t anyOfBoth(size_t words, const uint64_t* a, const uint64_t* b)
{
    uint64_t any = 0;
    for (size_t w = 0; w < words; ++w) any |= a[w] & b[w];
    return any;
}

}  // namespace

void RowCounts::begin(std::span<const uint64_t> open, uint32_t most)
{
    words_ = open.size();
    added_ = 0;
    digits_.assign(words_ * static_cast<size_t>(std::bit_width(most)), 0);
    open_.assign(open.begin(), open.end());
    carry_.resize(words_);
}

void RowCounts::keep(std::span<const uint64_t> rows)
{
    andWith(words_, rows.data(), open_.data());
}

void RowCounts::add(std::span<const uint64_t> rows, bool others)
{
    flip(words_, rows.data(), allOnes(others), carry_.data());
    ++added_;
    const auto reached = static_cast<size_t>(std::bit_width(added_));
    for (size_t d = 0; d < reached; ++d) addDigit(words_, digit(d), carry_.data());
}

std::span<const uint64_t> RowCounts::mostEven()
{
    foldHalves();
    bool any = false;
    for (auto d = static_cast<size_t>(std::bit_width(added_)); d-- > 0;) {
        if (anyOfBoth(words_, open_.data(), digit(d)) == 0) continue;
        andWith(words_, digit(d), open_.data());
        any = true;
    }
    return any ? std::span<const uint64_t>(open_) : std::span<const uint64_t>();
}

/// Replaces each number by the lesser of it and what it lacks of `added_`.
void RowCounts::foldHalves()
{
    const auto digits = static_cast<size_t>(std::bit_width(added_));
    lacks_.resize(digits_.size());
    carry_.assign(words_, 0);  // here what is borrowed
    for (size_t d = 0; d < digits; ++d)
        subtractDigit(words_, allOnes((added_ >> d & 1) != 0), digit(d), lack(d), carry_.data());
    less_.assign(words_, 0);
    equal_.assign(words_, ~uint64_t(0));
    for (size_t d = digits; d-- > 0;)
        compareDigit(words_, lack(d), digit(d), equal_.data(), less_.data());
    for (size_t d = 0; d < digits; ++d) copyWhere(words_, less_.data(), lack(d), digit(d));
}

}  // namespace core::many_lights

// Operations on rows of bits in words of 64, as BitMatrix stores its columns.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#if defined(__BMI2__) || defined(__AVX__)
#include <immintrin.h>
#endif

namespace core::many_lights {

using Words = std::vector<uint64_t>;

/// Words of 64 bits that hold one bit for each of so many rows.
constexpr uint32_t wordsFor(uint32_t rows)
{
    return (rows + 63) / 64;
}

/// The bits of `word` where `mask` is set, packed into the low bits.
inline uint64_t extractBits(uint64_t word, uint64_t mask)
{
#ifdef __BMI2__
    return _pext_u64(word, mask);
#else
    uint64_t packed = 0;
    for (uint64_t place = 1; mask != 0; mask &= mask - 1, place <<= 1)
        if ((word & mask & (~mask + 1)) != 0) packed |= place;
    return packed;
#endif
}

/// Where bit number k of those set in a word lies: k below their number.
inline uint32_t placeOfBit(uint64_t word, uint32_t k)
{
#ifdef __BMI2__
    return static_cast<uint32_t>(std::countr_zero(_pdep_u64(uint64_t(1) << k, word)));
#else
    for (; k > 0; --k) word &= word - 1;
    return static_cast<uint32_t>(std::countr_zero(word));
#endif
}

/// Word i of a column in which all of so many rows are set.
constexpr uint64_t wordOfRows(uint32_t rows, size_t i)
{
    if (size_t(rows) >= 64 * (i + 1)) return ~uint64_t(0);
    return size_t(rows) <= 64 * i ? 0 : (uint64_t(1) << (rows - 64 * i)) - 1;
}

inline uint32_t countBits(std::span<const uint64_t> words)
{
    uint32_t count = 0;
    for (const uint64_t word : words) count += static_cast<uint32_t>(std::popcount(word));
    return count;
}

inline bool getBit(std::span<const uint64_t> words, uint32_t i)
{
    return ((words[i / 64] >> (i % 64)) & 1) != 0;
}
inline void setBit(std::span<uint64_t> words, uint32_t i)
{
    words[i / 64] |= uint64_t(1) << (i % 64);
}

/// Calls f(i) for every set bit i, in ascending order.
template <class F> void forEachBit(std::span<const uint64_t> words, F&& f)
{
    for (size_t w = 0; w < words.size(); ++w)
        for (uint64_t rest = words[w]; rest != 0; rest &= rest - 1)
            f(static_cast<uint32_t>(64 * w) + static_cast<uint32_t>(std::countr_zero(rest)));
}

/// The row of set bit number k, below countBits(words).
inline uint32_t rowOfNumber(std::span<const uint64_t> words, uint32_t k)
{
    size_t w = 0;
    for (uint32_t here; (here = static_cast<uint32_t>(std::popcount(words[w]))) <= k; ++w)
        k -= here;
    return static_cast<uint32_t>(64 * w) + placeOfBit(words[w], k);
}

/// 0 or 1 for each of the rows.
inline void bitsToFloats(std::span<const uint64_t> words, std::span<float> values)
{
    for (size_t w = 0; w < words.size(); ++w) {
        const size_t first = 64 * w, count = std::min<size_t>(64, values.size() - first);
        for (size_t b = 0; b < count; ++b)
            values[first + b] = static_cast<float>((words[w] >> b) & 1);
    }
}

/// The opposite: a bit for each value above 0.
inline void positiveToBits(std::span<const float> values, std::span<uint64_t> words)
{
    for (size_t w = 0; w < words.size(); ++w) {
        const size_t count = std::min<size_t>(64, values.size() - 64 * w);
        const float* value = values.data() + 64 * w;
        uint64_t word = 0;
        size_t i = 0;
#ifdef __AVX__
        for (; i + 8 <= count; i += 8) {
            const __m256 positive =
                _mm256_cmp_ps(_mm256_loadu_ps(value + i), _mm256_setzero_ps(), _CMP_GT_OQ);
            word |= uint64_t(static_cast<uint32_t>(_mm256_movemask_ps(positive))) << i;
        }
#endif
        for (; i < count; ++i) word |= uint64_t(value[i] > 0 ? 1 : 0) << i;
        words[w] = word;
    }
}

/// Clears the values whose bit is 0.
inline void maskValues(std::span<const uint64_t> words, std::span<float> values)
{
    const auto mask = [](uint32_t word, float* __restrict value, uint32_t count) {
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t keep = 0u - (word >> i & 1);
            value[i] = std::bit_cast<float>(std::bit_cast<uint32_t>(value[i]) & keep);
        }
    };
    constexpr size_t kHalf = 32;  // of a word: as wide as a value
    for (size_t first = 0; first < values.size(); first += kHalf) {
        const auto word = static_cast<uint32_t>(words[first / 64] >> first % 64);
        const size_t count = std::min(kHalf, values.size() - first);
        if (count == kHalf)
            mask(word, values.data() + first, kHalf);
        else
            mask(word, values.data() + first, static_cast<uint32_t>(count));
    }
}

/// Appends the bits that masks select from words to a packed sequence, from its bit `at` on, and
/// returns where it ends. What lies behind `at` is zero beforehand.
inline uint32_t packBits(std::span<const uint64_t> words, std::span<const uint64_t> mask,
                         uint64_t* packed, uint32_t at = 0)
{
    for (size_t w = 0; w < mask.size(); ++w) {
        if (mask[w] == 0) continue;
        const uint64_t bits = extractBits(words[w], mask[w]);
        const auto count = static_cast<uint32_t>(std::popcount(mask[w]));
        const uint32_t shift = at % 64;
        packed[at / 64] |= bits << shift;
        if (shift + count > 64) packed[at / 64 + 1] |= bits >> (64 - shift);
        at += count;
    }
    return at;
}

}  // namespace core::many_lights

// Synthetic visibility matrices.
#include "tests/support/methods/visibility_matrices.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include <glm/glm.hpp>

#include "core/completion/bits.h"

namespace tests {

using core::Pcg32;
using core::many_lights::TraceRequest;
namespace many_lights = core::many_lights;

void MatrixOracle::trace(std::span<const TraceRequest> requests)
{
    ++calls_;
    for (const TraceRequest& request : requests) {
        const auto truth = truth_.column(request.column);
        const auto asked = asked_.column(request.column);
        const uint64_t* matters = this->matters(request.column);
        for (size_t w = 0; w < truth.size(); ++w) {
            const uint64_t rows = request.rows[w];
            const uint64_t exist = many_lights::wordOfRows(truth_.rows(), w);
            if ((rows & ~exist) != 0 || (rows & asked[w]) != 0 ||
                (request.visible[w] & rows) != 0 || (matters != nullptr && (rows & ~matters[w])))
                ADD_FAILURE() << "column " << request.column << ", word " << w << ": asked for "
                              << std::hex << rows << ", asked before " << asked[w];
            asked[w] |= rows;
            request.visible[w] |= truth[w] & rows;
            rays_ += static_cast<uint64_t>(std::popcount(rows));
        }
    }
}

const uint64_t* MatrixOracle::matters(uint32_t column) const
{
    return matters_ != nullptr ? matters_->column(column).data() : nullptr;
}

namespace {

uint32_t below(uint32_t end, Pcg32& random)
{
    return std::min(static_cast<uint32_t>(random() * end), end - 1);
}

void copyColumn(const BitMatrix& from, uint32_t j, BitMatrix& to, uint32_t k, bool complement)
{
    const auto source = from.column(j);
    const auto target = to.column(k);
    for (size_t w = 0; w < source.size(); ++w)
        target[w] = (complement ? ~source[w] : source[w]) & many_lights::wordOfRows(from.rows(), w);
}

}  // namespace

core::many_lights::Words randomRows(uint32_t rows, double p, core::Pcg32& random)
{
    core::many_lights::Words words(core::many_lights::wordsFor(rows));
    for (uint32_t i = 0; i < rows; ++i)
        if (random() < p) core::many_lights::setBit(words, i);
    return words;
}

BitMatrix randomMatrix(uint32_t rows, uint32_t columns, double p, Pcg32& random)
{
    BitMatrix matrix(rows, columns);
    for (uint32_t j = 0; j < columns; ++j)
        for (uint32_t i = 0; i < rows; ++i) matrix.set(i, j, random() < p);
    return matrix;
}

BitMatrix dictionaryMatrix(uint32_t rows, uint32_t columns, uint32_t distinct, Pcg32& random)
{
    const BitMatrix dictionary = randomMatrix(rows, distinct, 0.5, random);
    std::vector<uint32_t> entries(columns);
    for (uint32_t j = 0; j < columns; ++j) entries[j] = j < distinct ? j : below(distinct, random);
    for (uint32_t j = columns; j > 1; --j) std::swap(entries[j - 1], entries[below(j, random)]);
    BitMatrix matrix(rows, columns);
    for (uint32_t j = 0; j < columns; ++j)
        copyColumn(dictionary, entries[j], matrix, j, random() < 0.5);
    return matrix;
}

BitMatrix sumsMatrix(uint32_t rows, uint32_t columns, uint32_t rank, Pcg32& random)
{
    const BitMatrix generators = randomMatrix(rows, rank, 0.5, random);
    BitMatrix matrix(rows, columns);
    for (uint32_t j = 0; j < columns; ++j)
        for (uint32_t k = 0; k < rank; ++k) {
            if (random() < 0.5) continue;
            for (size_t w = 0; w < matrix.wordsPerColumn(); ++w)
                matrix.column(j)[w] ^= generators.column(k)[w];
        }
    return matrix;
}

BitMatrix edgesMatrix(uint32_t rows, uint32_t columns, Pcg32& random)
{
    BitMatrix matrix(rows, columns);
    for (uint32_t j = 0; j < columns; ++j) {
        const uint32_t edge = below(rows + 1, random);
        for (uint32_t i = edge; i < rows; ++i) matrix.set(i, j, true);
    }
    return matrix;
}

BitMatrix spheresMatrix(uint32_t side, uint32_t columns, uint32_t spheres, double radius,
                        double patch, Pcg32& random)
{
    std::vector<glm::dvec3> centres;
    for (uint32_t s = 0; s < spheres; ++s)
        centres.push_back({random(), random(), 0.2 + 0.4 * random()});
    BitMatrix matrix(side * side, columns);
    for (uint32_t j = 0; j < columns; ++j) {
        const glm::dvec3 light{random(), random(), 1};
        for (uint32_t i = 0; i < side * side; ++i) {
            const glm::dvec3 x{0.5 + patch * ((i % side + 0.5) / side - 0.5),
                               0.5 + patch * ((i / side + 0.5) / side - 0.5), 0};
            const glm::dvec3 d = light - x;
            const bool lit = std::ranges::none_of(centres, [&](const glm::dvec3& centre) {
                const double t = std::clamp(glm::dot(centre - x, d) / glm::dot(d, d), 0.0, 1.0);
                return glm::distance(x + t * d, centre) < radius;
            });
            matrix.set(i, j, lit);
        }
    }
    return matrix;
}

BitMatrix foliageMatrix(uint32_t rows, uint32_t columns, double run, Pcg32& random)
{
    BitMatrix matrix(rows, columns);
    for (uint32_t j = 0; j < columns; ++j) {
        bool lit = random() < 0.5;
        for (uint32_t i = 0; i < rows; ++i) {
            if (random() < 1 / run) lit = !lit;
            matrix.set(i, j, lit);
        }
    }
    return matrix;
}

BitMatrix facingMask(uint32_t rows, uint32_t columns, double share, Pcg32& random)
{
    BitMatrix matrix(rows, columns);
    const auto length = static_cast<uint32_t>(std::lround(share * rows));
    for (uint32_t j = 0; j < columns; ++j) {
        const uint32_t begin = below(rows, random);
        for (uint32_t i = 0; i < length; ++i) matrix.set((begin + i) % rows, j, true);
    }
    return matrix;
}

double bitError(const BitMatrix& truth, const BitMatrix& found, const BitMatrix* matters)
{
    uint64_t wrong = 0, asked = 0;
    for (uint32_t j = 0; j < truth.columns(); ++j)
        for (size_t w = 0; w < truth.wordsPerColumn(); ++w) {
            const uint64_t mask = matters != nullptr ? matters->column(j)[w]
                                                     : many_lights::wordOfRows(truth.rows(), w);
            asked += static_cast<uint64_t>(std::popcount(mask));
            wrong += static_cast<uint64_t>(
                std::popcount((truth.column(j)[w] ^ found.column(j)[w]) & mask));
        }
    return asked > 0 ? double(wrong) / double(asked) : 0;
}

uint32_t distinctColumns(const BitMatrix& matrix)
{
    std::set<std::vector<uint64_t>> seen;
    for (uint32_t j = 0; j < matrix.columns(); ++j) {
        const auto column = matrix.column(j);
        std::vector<uint64_t> words(column.begin(), column.end());
        if (!words.empty() && (words[0] & 1) != 0)
            for (size_t w = 0; w < words.size(); ++w)
                words[w] = ~words[w] & many_lights::wordOfRows(matrix.rows(), w);
        seen.insert(words);
    }
    return static_cast<uint32_t>(seen.size());
}

}  // namespace tests

#include "core/guiding/direction_grid.h"

#include <cmath>

namespace core::guiding {

/// The cell meant by one that lies next to the square: each side of the square meets itself, turned
/// about its middle, because the octahedron's lower half is folded outwards.
static glm::ivec2 wrapped(glm::ivec2 cell)
{
    constexpr int n = int(shared::kGuideSide);
    if (cell.x < 0 || cell.x >= n) {
        cell = {cell.x < 0 ? -1 - cell.x : 2 * n - 1 - cell.x, n - 1 - cell.y};
    }
    if (cell.y < 0 || cell.y >= n) {
        cell = {n - 1 - cell.x, cell.y < 0 ? -1 - cell.y : 2 * n - 1 - cell.y};
    }
    return cell;
}

void DirectionGrid::halve()
{
    total_ *= 0.5;
    for (float& c : cells_) c *= 0.5f;
}

void DirectionGrid::learn(std::span<const Lesson> lessons)
{
    for (const Lesson& lesson : lessons) {
        if (lesson.pdf > 0 && lesson.value > 0)
            deposit(shared::guideSquare(lesson.direction), lesson.value);
    }
}

/// A value in the direction of a point of the square, spread over the four nearest cells: what
/// moving it about by up to half a cell would give on average.
void DirectionGrid::deposit(glm::vec2 square, float value)
{
    const glm::vec2 p = square * float(shared::kGuideSide) - 0.5f;
    const glm::vec2 corner = glm::floor(p);
    const glm::vec2 f = p - corner;
    for (int k = 0; k < 4; ++k) {
        const glm::ivec2 step(k & 1, k >> 1);
        const glm::ivec2 cell = wrapped(glm::ivec2(corner) + step);
        const float weight = (step.x == 1 ? f.x : 1 - f.x) * (step.y == 1 ? f.y : 1 - f.y);
        cells_[size_t(cell.y) * shared::kGuideSide + size_t(cell.x)] += weight * value;
    }
    total_ += double(value);
}

void DirectionGrid::write(std::span<glm::vec4> words, bool moments) const
{
    const auto massOf = [moments](float c) { return moments ? std::sqrt(double(c)) : double(c); };
    double sum = 0;
    for (const float c : cells_) sum += massOf(c);
    const double scale = sum > 0 ? 1 / sum : 0;
    std::array<double, kCells> masses;  // in Morton order; of ever coarser levels
    for (uint32_t y = 0; y < shared::kGuideSide; ++y)
        for (uint32_t x = 0; x < shared::kGuideSide; ++x) {
            masses[shared::guideCell({x, y})] =
                scale * massOf(cells_[size_t(y) * shared::kGuideSide + x]);
        }
    size_t first = shared::kGuideFinest;
    for (size_t count = kCells / 4;; count /= 4) {
        for (size_t i = 0; i < count; ++i) {
            double all = 0;
            for (size_t k = 0; k < 4; ++k) {
                words[first + i][int(k)] = float(masses[4 * i + k]);
                all += masses[4 * i + k];
            }
            masses[i] = all;
        }
        if (count == 1) return;
        first -= count / 4;
    }
}

}  // namespace core::guiding

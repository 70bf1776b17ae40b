#include "core/guiding/guide_leaf.h"

namespace core::guiding {

namespace {

/// A leaf whose guide has been tested by fewer records is not guided.
constexpr double kLeastTested = 64;

float finiteOrZero(float x)
{
    return x > 0 && x < 1e30f ? x : 0;
}

/// The cell meant by one that lies next to the square: each side of the square meets itself, turned
/// about its middle, because the octahedron's lower half is folded outwards.
glm::ivec2 wrapped(glm::ivec2 cell)
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

}  // namespace

Lesson lessonOf(const shared::GuideRecord& record, float final, const GuideTables& tables)
{
    const shared::GuideView guide = tables.view();
    Lesson lesson;
    lesson.position = record.position;
    lesson.leaf = shared::findGuideLeaf(guide, record.position, record.place & 7u);
    lesson.sharp = float(record.place >> 3u) / 255.0f;
    if (record.beta > 0) {
        lesson.value = finiteOrZero((final - record.after) / record.beta);
        lesson.reflected = finiteOrZero((final - record.before) / record.beta);
    }
    if (!(record.pdf > 0)) return lesson;
    lesson.pdf = record.pdf;
    lesson.bsdfPdf = record.bsdfPdf;
    const glm::vec3 wi = shared::unpackOct(record.direction);
    lesson.square = shared::guideSquare(wi);
    lesson.guidePdf =
        shared::pdfGuide(guide, shared::GuideLeaf{0, tables.leaves[lesson.leaf].x, 1, 0}, wi);
    return lesson;
}

void LearningLeaf::halve()
{
    visits *= 0.5;
    reflected *= 0.5;
    for (double& m : moments) m *= 0.5;
    tested *= 0.5;
    total *= 0.5;
    for (float& c : cells) c *= 0.5f;
}

void LearningLeaf::learn(std::span<const Lesson> lessons, double decay, const GuideOptions& options)
{
    for (double& m : moments) m *= decay;
    tested *= decay;
    const bool hasGuide = total > 0;
    for (const Lesson& lesson : lessons) {
        visits += 1;
        reflected += double(lesson.reflected);
        if (hasGuide) test(lesson);
    }
    for (const Lesson& lesson : lessons)
        if (lesson.pdf > 0 && lesson.value > 0) deposit(lesson.square, lesson.value);
    choose(options);
}

void LearningLeaf::test(const Lesson& lesson)
{
    tested += 1;
    if (!(lesson.pdf > 0 && lesson.value > 0)) return;
    const double bsdf = double(lesson.bsdfPdf), smooth = 1.0 - double(lesson.sharp);
    const double squares = double(lesson.value) * double(lesson.value) * double(lesson.pdf);
    for (size_t k = 0; k < kGuideShares.size(); ++k) {
        const double guide = (1.0 - kGuideShares[k]) * smooth;
        const double pdf = (1.0 - guide) * bsdf + guide * double(lesson.guidePdf);
        if (pdf > 0) moments[k] += squares / pdf;
    }
}

/// The share with the least second moment, if that is enough of a gain.
void LearningLeaf::choose(const GuideOptions& options)
{
    share = 1;
    if (!(total > 0)) return;
    if (options.fixedShare > 0) {
        share = options.fixedShare;
        return;
    }
    if (tested < kLeastTested) return;
    size_t best = 0;
    for (size_t k = 1; k < kGuideShares.size(); ++k) {
        // Shares are given with two digits; a limit of .12 allows .12
        if (kGuideShares[k] > double(options.leastShare) - 1e-3 && moments[k] < moments[best])
            best = k;
    }
    if (moments[0] > double(options.gate) * moments[best]) share = float(kGuideShares[best]);
}

void LearningLeaf::deposit(glm::vec2 square, float value)
{
    const glm::vec2 p = square * float(shared::kGuideSide) - 0.5f;
    const glm::vec2 corner = glm::floor(p);
    const glm::vec2 f = p - corner;
    for (int k = 0; k < 4; ++k) {
        const glm::ivec2 step(k & 1, k >> 1);
        const glm::ivec2 cell = wrapped(glm::ivec2(corner) + step);
        const float weight = (step.x == 1 ? f.x : 1 - f.x) * (step.y == 1 ? f.y : 1 - f.y);
        cells[size_t(cell.y) * shared::kGuideSide + size_t(cell.x)] += weight * value;
    }
    total += double(value);
}

void LearningLeaf::writeQuads(std::span<glm::vec4> quads) const
{
    double sum = 0;
    for (const float c : cells) sum += double(c);
    const double scale = sum > 0 ? 1 / sum : 0;
    std::array<double, kGuideCells> masses;  // in Morton order; of ever coarser levels
    for (uint32_t y = 0; y < shared::kGuideSide; ++y)
        for (uint32_t x = 0; x < shared::kGuideSide; ++x) {
            masses[shared::guideCell({x, y})] =
                scale * double(cells[size_t(y) * shared::kGuideSide + x]);
        }
    size_t first = shared::kGuideFinest;
    for (size_t count = kGuideCells / 4;; count /= 4) {
        for (size_t i = 0; i < count; ++i) {
            double all = 0;
            for (size_t k = 0; k < 4; ++k) {
                quads[first + i][int(k)] = float(masses[4 * i + k]);
                all += masses[4 * i + k];
            }
            masses[i] = all;
        }
        if (count == 1) return;
        first -= count / 4;
    }
}

}  // namespace core::guiding

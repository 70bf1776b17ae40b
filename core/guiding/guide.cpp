// One iteration: records find their leaves, leaves take them in order, those with too many are cut.
#include "core/guiding/guide.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/guiding/guide_leaf.h"
#include "shared/rng.h"

namespace core::guiding {

namespace {

// Cuts below one leaf in one iteration, and leaves in all: a bound on memory whatever is recorded.
// What there may still be is shared out evenly, so that leaves need not wait for each other.
constexpr size_t kMostCuts = 1023;
constexpr uint32_t kDeepestCut = 24;
constexpr size_t kMostLeaves = 1u << 15;
constexpr size_t kLeastRecordsToCut = 32;

/// The plane through the mean of the records, across the axis along which they spread most.
void setPlane(std::span<const Lesson> lessons, float& plane, uint32_t& axis)
{
    glm::dvec3 sum(0), squares(0);
    for (const Lesson& lesson : lessons) {
        const glm::dvec3 p(lesson.position);
        sum += p;
        squares += p * p;
    }
    const glm::dvec3 mean = sum / double(lessons.size());
    const glm::dvec3 variance = squares / double(lessons.size()) - mean * mean;
    axis = variance.y > variance.x ? 1u : 0u;
    if (variance.z > variance[int(axis)]) axis = 2u;
    plane = float(mean[int(axis)]);
}

}  // namespace

/// Position and axis of a plane; below and above it a node or a leaf (shared::kGuideLeafBit).
struct Guide::Node {
    float plane = 0;
    uint32_t axis = 0;
    uint32_t below = 0, above = 0;
};

/// What one leaf becomes in an iteration: itself, or a tree of which it is the root.
struct Guide::Growth {
    const GuideOptions& options;
    double limit = 0, decay = 0, times = 0;
    size_t mostCuts = 0;
    std::vector<Node> nodes{};
    std::vector<LearningLeaf> leaves{};

    /// Returns a reference among `nodes` and `leaves`. Reorders the lessons, always in the same
    /// way.
    uint32_t take(LearningLeaf leaf, std::span<Lesson> lessons, uint32_t depth = 0)
    {
        if (isFull(leaf, lessons.size()) && nodes.size() < mostCuts && depth < kDeepestCut) {
            const bool plain = options.space == GuideSpace::plain;
            Node node;
            if (plain) {
                node.axis = leaf.cell.depth % 3;
                node.plane = 0.5f * (leaf.cell.low + leaf.cell.high)[int(node.axis)];
            } else {
                setPlane(lessons, node.plane, node.axis);
            }
            const auto middle = std::stable_partition(
                lessons.begin(), lessons.end(), [&node](const Lesson& lesson) {
                    return lesson.position[int(node.axis)] < node.plane;
                });
            const auto count = static_cast<size_t>(middle - lessons.begin());
            if (plain || (count > 0 && count < lessons.size())) {
                leaf.halve();
                const size_t index = nodes.size();
                nodes.push_back(node);
                const uint32_t below =
                    take(leaf.child(node.plane, node.axis, false), lessons.first(count), depth + 1);
                const uint32_t above = take(leaf.child(node.plane, node.axis, true),
                                            lessons.subspan(count), depth + 1);
                nodes[index].below = below;
                nodes[index].above = above;
                return static_cast<uint32_t>(index);
            }
        }
        const bool wasGuided = leaf.share < 1;
        leaf.learn(lessons, decay, options);
        const auto count = double(lessons.size());
        leaf.aim(options, wasGuided ? count : 0, times * count);
        leaves.push_back(std::move(leaf));
        return static_cast<uint32_t>(leaves.size() - 1) | shared::kGuideLeafBit;
    }

    bool isFull(const LearningLeaf& leaf, size_t records) const
    {
        const double before = options.memory == GuideMemory::keep ? leaf.visits : 0;
        const size_t least = limit > 0 ? kLeastRecordsToCut : 1;
        return before + double(records) > limit && records >= least &&
               leaf.cell.depth < options.depth;
    }
};

Guide::Guide(const GuideOptions& options)
    : options_(options), leaves_(options.space == GuideSpace::plain ? 1 : shared::kGuideRoots,
                                 LearningLeaf(options.kind))
{
    for (uint32_t k = 0; k < shared::kGuideRoots; ++k)
        roots_[k] = std::min<uint32_t>(k, uint32_t(leaves_.size()) - 1) | shared::kGuideLeafBit;
    for (LearningLeaf& leaf : leaves_) leaf.cell = GuideCell(options.box);
    makeTables();
}

Guide::~Guide() = default;
Guide::Guide(Guide&&) noexcept = default;
Guide& Guide::operator=(Guide&&) noexcept = default;

/// Moves a lesson by half the size of its leaf at most, within the box; it may then teach another
/// leaf of the same tree.
static void spread(Lesson& lesson, const GuideTables& tables, const GuideCell& cell,
                   const GuideBox& box)
{
    const auto word = [&](int i) { return shared::floatAsUint(lesson.position[i]); };
    const glm::uvec4 random = shared::pcg4d(
        {word(0), word(1), word(2), shared::floatAsUint(lesson.direction.x + lesson.reflected)});
    const glm::vec3 u(shared::unitFloat(random.x), shared::unitFloat(random.y),
                      shared::unitFloat(random.z));
    lesson.position = glm::clamp(lesson.position + (u - 0.5f) * (cell.high - cell.low), box.low,
                                 box.low + box.side);
    lesson.leaf = shared::findGuideLeaf(tables.view(), lesson.position, lesson.tree);
}

std::vector<Lesson> Guide::lessonsOf(std::span<const PathRecords> parts) const
{
    std::vector<size_t> firsts(parts.size() + 1);
    for (size_t i = 0; i < parts.size(); ++i) firsts[i + 1] = firsts[i] + parts[i].records.size();
    std::vector<Lesson> lessons(firsts.back());
    parallelFor(parts.size(), 8, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            size_t r = 0;
            for (const shared::GuidePathEnd& path : parts[i].ends)
                for (uint32_t k = 0; k < path.count; ++k, ++r)
                    lessons[firsts[i] + r] = lessonOf(parts[i].records[r], path.final, *tables_);
            CHECK(r == parts[i].records.size());
        }
    });
    return lessons;
}

/// Those of a leaf together, otherwise in their order; `begins` gets where each leaf's begin.
static std::vector<Lesson> sorted(std::span<const Lesson> lessons, size_t leaves,
                                  std::vector<size_t>& begins)
{
    begins.assign(leaves + 1, 0);
    for (const Lesson& lesson : lessons) ++begins[lesson.leaf + 1];
    for (size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
    std::vector<size_t> next(begins.begin(), begins.end() - 1);
    std::vector<Lesson> result(lessons.size());
    for (const Lesson& lesson : lessons) result[next[lesson.leaf]++] = lesson;
    return result;
}

void Guide::learn(std::span<const Lesson> given, double samples, double times)
{
    CHECK(samples > 0 && samples >= samplesBefore_);
    std::vector<Lesson> moved;
    if (options_.filter == GuideFilter::spread) {
        moved.assign(given.begin(), given.end());
        for (Lesson& lesson : moved)
            spread(lesson, *tables_, leaves_[lesson.leaf].cell, options_.box);
        given = moved;
    }
    std::vector<size_t> begins;
    std::vector<Lesson> lessons = sorted(given, leaves_.size(), begins);
    noteShare(lessons);

    const double counted =
        options_.memory == GuideMemory::keep ? samples : samples - samplesBefore_;
    const double limit = double(options_.recordsPerLeaf) * std::sqrt(2 * counted);
    const double decay = samplesBefore_ * samplesBefore_ / (samples * samples);
    const size_t mostCuts = std::min(kMostCuts, kMostLeaves / leaves_.size() - 1);
    std::vector<Growth> growths(leaves_.size(),
                                Growth{options_, limit, std::min(decay, 1.0), times, mostCuts});
    std::vector<uint32_t> becomes(leaves_.size());
    parallelFor(leaves_.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const std::span<Lesson> own(lessons.data() + begins[i], begins[i + 1] - begins[i]);
            noteDensities(uint32_t(i), own);
            becomes[i] = growths[i].take(leaves_[i], own);
        }
    });
    graft(growths, becomes);
    samplesBefore_ = samples;
    tablesBefore_ = tables_;
    figures_.records += double(lessons.size());
    makeTables();
}

void Guide::learn(std::span<const PathRecords> parts, double samples, double times)
{
    learn(lessonsOf(parts), samples, times);
}

/// Puts what leaves have become where they were.
void Guide::graft(std::span<const Growth> growths, std::span<const uint32_t> becomes)
{
    std::vector<LearningLeaf> leaves;
    std::vector<uint32_t> references(growths.size());
    const size_t oldNodes = nodes_.size();
    for (size_t i = 0; i < growths.size(); ++i) {
        const auto firstNode = static_cast<uint32_t>(nodes_.size());
        const auto firstLeaf = static_cast<uint32_t>(leaves.size());
        const auto moved = [&](uint32_t reference) {
            return reference + ((reference & shared::kGuideLeafBit) != 0 ? firstLeaf : firstNode);
        };
        for (const Node& n : growths[i].nodes)
            nodes_.push_back({n.plane, n.axis, moved(n.below), moved(n.above)});
        leaves.insert(leaves.end(), growths[i].leaves.begin(), growths[i].leaves.end());
        references[i] = moved(becomes[i]);
    }
    const auto renewed = [&](uint32_t& reference) {
        if ((reference & shared::kGuideLeafBit) != 0)
            reference = references[reference & ~shared::kGuideLeafBit];
    };
    for (uint32_t& root : roots_) renewed(root);
    for (size_t i = 0; i < oldNodes; ++i) {
        renewed(nodes_[i].below);
        renewed(nodes_[i].above);
    }
    leaves_ = std::move(leaves);
}

/// Where records are used twice: the density of each of a leaf's lessons, new or kept, in the
/// mixture of the iteration that it is not from.
void Guide::noteDensities(uint32_t leaf, std::span<Lesson> lessons)
{
    if (options_.memory == GuideMemory::keep || options_.memory == GuideMemory::reset) return;
    for (Lesson& old : leaves_[leaf].store.lessons())
        old.otherPdf = mixturePdf(old, *tables_, leaf);
    if (tablesBefore_ != nullptr)
        for (Lesson& lesson : lessons)
            lesson.otherPdf = mixturePdf(lesson, *tablesBefore_, leaves_[leaf].before);
    leaves_[leaf].before = leaf;
}

/// The share of the iteration's vertices that lay in guided leaves.
void Guide::noteShare(std::span<const Lesson> lessons)
{
    size_t guided = 0;
    for (const Lesson& lesson : lessons) guided += leaves_[lesson.leaf].share < 1 ? 1u : 0u;
    figures_.guidedShare = lessons.empty() ? 0 : double(guided) / double(lessons.size());
}

void Guide::makeTables()
{
    const auto tables = std::make_shared<GuideTables>();
    tables->nodes.reserve(shared::kGuideRootWords + nodes_.size());
    const auto moved = [](uint32_t reference) {
        return (reference & shared::kGuideLeafBit) != 0 ? reference
                                                        : reference + shared::kGuideRootWords;
    };
    std::array<uint32_t, 4 * shared::kGuideRootWords> roots{};
    for (size_t k = 0; k < roots_.size(); ++k) roots[k] = moved(roots_[k]);
    for (size_t k = 0; k < roots.size(); k += 4)
        tables->nodes.emplace_back(roots[k], roots[k + 1], roots[k + 2], roots[k + 3]);
    for (const Node& n : nodes_) {
        tables->nodes.emplace_back(shared::floatAsUint(n.plane), n.axis, moved(n.below),
                                   moved(n.above));
    }
    tables->leaves.resize(leaves_.size());
    tables->kind = options_.kind;
    tables->directions.reserve(leaves_.size() * shared::guideWords(options_.kind));
    for (size_t i = 0; i < leaves_.size(); ++i) {
        const LearningLeaf& leaf = leaves_[i];
        const double reflected = leaf.visits > 0 ? leaf.reflected / leaf.visits : 0;
        tables->leaves[i] = {leaf.write(*tables, options_), shared::floatAsUint(leaf.share),
                             shared::floatAsUint(float(reflected)), 0u};
    }
    // Devices have no empty buffers.
    if (tables->directions.empty()) tables->directions.emplace_back(0.0f);
    figures_.leaves = leaves_.size();
    figures_.bytes = tables->bytes();
    tables_ = tables;
}

double Guide::visits(uint32_t leaf) const
{
    return leaves_.at(leaf).visits;
}

}  // namespace core::guiding

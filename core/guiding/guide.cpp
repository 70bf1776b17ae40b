// One iteration: records find their leaves, leaves take them in order, those with too many are cut.
#include "core/guiding/guide.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/guiding/guide_leaf.h"

namespace core::guiding {

namespace {

// Cuts below one leaf in one iteration, and leaves in all: a bound on memory whatever is recorded.
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
    double limit = 0, decay = 0;
    size_t mostCuts = 0;
    std::vector<Node> nodes{};
    std::vector<LearningLeaf> leaves{};

    /// Returns a reference among `nodes` and `leaves`. Reorders the lessons, always in the same
    /// way.
    uint32_t take(LearningLeaf leaf, std::span<Lesson> lessons, uint32_t depth = 0)
    {
        const double visits = leaf.visits + double(lessons.size());
        if (visits > limit && lessons.size() >= kLeastRecordsToCut && nodes.size() < mostCuts &&
            depth < kDeepestCut) {
            Node node;
            setPlane(lessons, node.plane, node.axis);
            const auto middle = std::stable_partition(
                lessons.begin(), lessons.end(), [&node](const Lesson& lesson) {
                    return lesson.position[int(node.axis)] < node.plane;
                });
            const auto count = static_cast<size_t>(middle - lessons.begin());
            if (count > 0 && count < lessons.size()) {
                leaf.halve();
                const size_t index = nodes.size();
                nodes.push_back(node);
                const uint32_t below = take(leaf, lessons.first(count), depth + 1);
                const uint32_t above = take(leaf, lessons.subspan(count), depth + 1);
                nodes[index].below = below;
                nodes[index].above = above;
                return static_cast<uint32_t>(index);
            }
        }
        leaf.learn(lessons, decay, options);
        leaves.push_back(leaf);
        return static_cast<uint32_t>(leaves.size() - 1) | shared::kGuideLeafBit;
    }
};

Guide::Guide(const GuideOptions& options)
    : options_(options), leaves_(shared::kGuideRoots, LearningLeaf(options.kind))
{
    for (uint32_t k = 0; k < shared::kGuideRoots; ++k) roots_[k] = k | shared::kGuideLeafBit;
    makeTables();
}

Guide::~Guide() = default;
Guide::Guide(Guide&&) noexcept = default;
Guide& Guide::operator=(Guide&&) noexcept = default;

/// All records of all parts as lessons, those of a leaf together and in the order of the parts;
/// `begins` gets where each leaf's begin.
static std::vector<Lesson> sortedLessons(std::span<const PathRecords> parts,
                                         const GuideTables& tables, std::vector<size_t>& begins)
{
    std::vector<size_t> firsts(parts.size() + 1);
    for (size_t i = 0; i < parts.size(); ++i) firsts[i + 1] = firsts[i] + parts[i].records.size();
    std::vector<Lesson> lessons(firsts.back());
    parallelFor(parts.size(), 8, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            size_t r = 0;
            for (const shared::GuidePathEnd& path : parts[i].ends)
                for (uint32_t k = 0; k < path.count; ++k, ++r)
                    lessons[firsts[i] + r] = lessonOf(parts[i].records[r], path.final, tables);
            CHECK(r == parts[i].records.size());
        }
    });
    begins.assign(tables.leaves.size() + 1, 0);
    for (const Lesson& lesson : lessons) ++begins[lesson.leaf + 1];
    for (size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
    std::vector<size_t> next(begins.begin(), begins.end() - 1);
    std::vector<Lesson> sorted(lessons.size());
    for (const Lesson& lesson : lessons) sorted[next[lesson.leaf]++] = lesson;
    return sorted;
}

void Guide::learn(std::span<const PathRecords> parts, double samples)
{
    CHECK(samples > 0);
    std::vector<size_t> begins;
    std::vector<Lesson> lessons = sortedLessons(parts, *tables_, begins);
    noteShare(lessons);

    const double limit = double(options_.recordsPerLeaf) * std::sqrt(2 * samples);
    const double decay = samplesBefore_ * samplesBefore_ / (samples * samples);
    const size_t mostCuts = leaves_.size() < kMostLeaves ? kMostCuts : 0;
    std::vector<Growth> growths(leaves_.size(),
                                Growth{options_, limit, std::min(decay, 1.0), mostCuts});
    std::vector<uint32_t> becomes(leaves_.size());
    parallelFor(leaves_.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const std::span<Lesson> own(lessons.data() + begins[i], begins[i + 1] - begins[i]);
            becomes[i] = growths[i].take(leaves_[i], own);
        }
    });
    graft(growths, becomes);
    samplesBefore_ = samples;
    figures_.records += double(lessons.size());
    makeTables();
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
    const size_t words = shared::guideWords(options_.kind);
    tables->kind = options_.kind;
    tables->directions.resize(leaves_.size() * words);
    for (size_t i = 0; i < leaves_.size(); ++i) {
        const LearningLeaf& leaf = leaves_[i];
        const size_t first = i * words;
        const double reflected = leaf.visits > 0 ? leaf.reflected / leaf.visits : 0;
        tables->leaves[i] = {uint32_t(first), shared::floatAsUint(leaf.share),
                             shared::floatAsUint(float(reflected)), 0u};
        leaf.writeWords(std::span(tables->directions).subspan(first, words));
    }
    figures_.leaves = leaves_.size();
    figures_.bytes = tables->bytes();
    tables_ = tables;
}

double Guide::visits(uint32_t leaf) const
{
    return leaves_.at(leaf).visits;
}

}  // namespace core::guiding

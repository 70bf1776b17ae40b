// A path guide that learns: spatial trees by dominant normal, directions in each leaf (a
// histogram, lobes or a quadtree), and the share of the BSDF that has had the least variance. After
// T. Mueller, M. Gross, J. Novak, "Practical Path Guiding for Efficient Light-Transport Simulation"
// (2017); what devices read of it, and what differs there: shaders/shared/guide.h. What differs in
// learning: sums are kept from iteration to iteration, leaves are cut at the mean of their records,
// and a leaf is not used before records that its guide has not seen say that this pays.
// guide_options.h has switches back to the paper.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/guiding/guide_options.h"
#include "shared/guide.h"
#include "shared/guided_path.h"

namespace core::guiding {

struct Lesson;
struct LearningLeaf;

/// What devices read. Never changes once it is made, so that a view may render with one while the
/// next is made.
struct GuideTables {
    std::vector<glm::uvec4> nodes, leaves;
    std::vector<glm::vec4> directions;
    uint32_t kind = shared::kGuideHistogram;

    shared::GuideView view() const
    {
        return {nodes.data(), leaves.data(), directions.data(), kind};
    }
    size_t bytes() const { return 16 * (nodes.size() + leaves.size() + directions.size()); }
};

/// What the paths of a part of a picture have left, path after path: `ends[k].count` records each.
struct PathRecords {
    std::vector<shared::GuideRecord> records;
    std::vector<shared::GuidePathEnd> ends;

    void clear()
    {
        records.clear();
        ends.clear();
    }
};

/// What a guide says of itself.
struct GuideFigures {
    size_t leaves = 0, bytes = 0;
    double records = 0;      // learnt from
    double guidedShare = 0;  // of the vertices of the last iteration: those in guided leaves
};

class Guide {
public:
    explicit Guide(const GuideOptions& options = {});
    ~Guide();
    Guide(Guide&&) noexcept;
    Guide& operator=(Guide&&) noexcept;

    /// What the records of paths teach that were sampled with tables(), record after record, part
    /// after part.
    std::vector<Lesson> lessonsOf(std::span<const PathRecords> parts) const;

    /// Learns from them. `samples` per pixel have been taken since the guide was made, these
    /// included; until the next lesson there will be so many `times` the records, 0: no lesson
    /// follows. The result depends on the order of `lessons`, not on threads.
    void learn(std::span<const Lesson> lessons, double samples, double times = 0);

    /// The same from records.
    void learn(std::span<const PathRecords> parts, double samples, double times = 0);

    /// Never null; of a guide that has learnt nothing they choose the BSDF everywhere.
    std::shared_ptr<const GuideTables> tables() const { return tables_; }
    const GuideFigures& figures() const { return figures_; }

    /// Records that the leaf has learnt from.
    double visits(uint32_t leaf) const;

private:
    struct Node;
    struct Growth;

    void graft(std::span<const Growth> growths, std::span<const uint32_t> becomes);
    void noteShare(std::span<const Lesson> lessons);
    void noteDensities(uint32_t leaf, std::span<Lesson> lessons);
    void makeTables();

    GuideOptions options_;
    std::vector<Node> nodes_;
    std::vector<LearningLeaf> leaves_;
    std::array<uint32_t, shared::kGuideRoots> roots_{};
    double samplesBefore_ = 0;
    std::shared_ptr<const GuideTables> tables_, tablesBefore_;
    GuideFigures figures_;
};

}  // namespace core::guiding

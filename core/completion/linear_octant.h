// Completion by linear combinations of known columns, one column after the other: what Gauss-Jordan
// elimination over GF(2) and adaptive matrix completion have in common. Rows that do not matter
// count as dark, which costs no ray.
#pragma once

#include "core/completion/octant.h"

namespace core::many_lights {

class LinearOctant : protected Octant {
public:
    virtual ~LinearOctant() = default;

    void run();

protected:
    LinearOctant(Tracer& tracer, std::span<const uint32_t> columns, const CompletionParams& params,
                 uint64_t seed, CompletedSlice& out);

    virtual uint32_t basisSize() const = 0;

    /// The rows to sample of a column with these rows that matter. Returns how many draws it took.
    virtual uint32_t chooseRows(std::span<const uint64_t> matters, Words& rows) = 0;

    /// Predicts a column in all rows from its bits in `samples` (those that matter have been
    /// traced). Returns whether the prediction agrees with these.
    virtual bool predict(std::span<const uint64_t> column, std::span<const uint64_t> matters,
                         const Words& samples) = 0;

    /// Adds a column that is known in full.
    virtual void append(std::span<const uint64_t> column) = 0;

    std::vector<float> predicted_;  // 0 (dark) to 1 (lit)

private:
    bool sampled();
    bool verified();
    void take();
    void finishTraced();
    void addResidual();
    void traceFully();

    Words samples_, checks_;
    uint32_t drawn_ = 0;
};

}  // namespace core::many_lights

// Completed slices as a device sums them: cut into pieces of some columns, each with all that a
// kernel reads, in the records of shared/virtual_light.h.
#pragma once

#include <memory>

#include "core/many_lights/slice_job.h"
#include "core/many_lights/slice_visibility.h"
#include "shared/virtual_light.h"

namespace core::many_lights {

/// A slice on its way through a device: what it has of radiance so far, light that is found on the
/// CPU included.
struct PendingSlice {
    uint32_t slice = 0;
    uint32_t pieces = 0;  // that have not been summed yet
    std::vector<glm::vec3> radiance;
    SliceStats stats;
};

/// Some columns of a slice with the values of all rows. Groups of rows follow each other as
/// shared::SliceGroup says; a slice of fewer rows than a whole group leaves the rest of it zero.
struct SlicePiece {
    std::shared_ptr<PendingSlice> slice;
    uint32_t rows = 0, columns = 0;
    std::vector<shared::ReceiverRecord> receivers;
    std::vector<shared::LightRecord> lights;
    std::vector<glm::vec4> details;
    std::vector<uint32_t> values;

    uint64_t entries() const { return uint64_t(rows) * columns; }
    uint32_t groups() const { return (rows + shared::kSliceGroup - 1) / shared::kSliceGroup; }
    /// Of one of its groups, if the piece's own arrays begin at zero.
    shared::SliceGroup group(uint32_t index, bool numbers) const;
};

/// Whether what completion leaves are numbers: methods that predict such, and sampled errors, which
/// are added to what was predicted.
bool leavesNumbers(const CompletionParams& params);

/// How many columns a piece of a slice of so many rows may have: small enough for one submission.
uint32_t pieceColumns(uint32_t rows, LightShape shape);

/// Columns [range.begin, range.end) of a slice that has been completed.
SlicePiece packPiece(const SliceJob& job, const SliceVisibility& visibility,
                     std::span<const Receiver> receivers, std::span<const uint32_t> chosen,
                     ColumnRange range);

}  // namespace core::many_lights

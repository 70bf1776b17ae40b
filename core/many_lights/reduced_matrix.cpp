// See reduced_matrix.h.
#include "core/many_lights/reduced_matrix.h"

#include <atomic>
#include <cmath>

#include "core/base/denormals.h"
#include "core/base/parallel.h"
#include "core/many_lights/slice_oracle.h"
#include "core/trace/scene_view.h"

namespace core::many_lights {

namespace {

constexpr uint32_t kBlock = 64;  // columns that one thread takes

/// Some columns of the matrix: first their cosines, then all their rays, then their light.
class BlockTracer {
public:
    BlockTracer(const SliceJob& job, const SliceRows& rows)
        : job_(job), rows_(rows), weights_(kBlock * size_t(rows.count())),
          matters_(rows.count(), kBlock), visible_(rows.count(), kBlock)
    {}

    uint64_t trace(uint32_t begin, uint32_t end, const std::stop_token& stop, ReducedMatrix& out)
    {
        const uint32_t rows = rows_.count();
        std::vector<Column> columns;
        for (uint32_t j = begin; j < end; ++j)
            columns.push_back(columnOf(job_.lights->lights[j], 1, j, job_.receivers.frame));
        visible_.reset(rows, kBlock);
        std::vector<TraceRequest> requests;
        uint64_t rays = 0;
        for (uint32_t k = 0; k < columns.size(); ++k) {
            rows_.weigh(columns[k], job_.gather, weightsOf(k));
            positiveToBits(weightsOf(k), matters_.column(k));
            rays += countBits(matters_.column(k));
            requests.push_back({k, matters_.column(k).data(), visible_.column(k).data()});
        }
        SliceOracle(*job_.receivers.accel, rows_, columns, matters_, stop).trace(requests);
        for (uint32_t k = 0; k < columns.size(); ++k) {
            maskValues(visible_.column(k), weightsOf(k));
            rows_.clear({0, rows});
            rows_.add(columns[k], *job_.lights, weightsOf(k));
            const std::span<float> column = out.column(begin + k);
            for (uint32_t i = 0; i < rows; ++i) column[i] = shared::luminance(rows_.radiance(i));
            out.updateNorm(begin + k);
        }
        return rays;
    }

private:
    std::span<float> weightsOf(uint32_t k)
    {
        return {weights_.data() + size_t(k) * rows_.count(), rows_.count()};
    }

    const SliceJob& job_;
    SliceRows rows_;  // a copy: what is added to rows differs between threads
    std::vector<float> weights_;
    BitMatrix matters_, visible_;
};

}  // namespace

void ReducedMatrix::reset(uint32_t rows, uint32_t columns)
{
    rows_ = rows;
    stride_ = (rows + kLanes - 1) / kLanes * kLanes;
    values_.assign(size_t(stride_) * columns, 0.0f);
    norms_.assign(columns, 0.0f);
}

void ReducedMatrix::updateNorm(uint32_t j)
{
    norms_[j] = std::sqrt(innerProduct(column(j), column(j)));
}

float innerProduct(std::span<const float> a, std::span<const float> b)
{
    // Written so that compilers keep one vector of sums.
    constexpr size_t kLanes = ReducedMatrix::kLanes;
    std::array<float, kLanes> sums{};
    for (size_t i = 0; i + kLanes <= a.size(); i += kLanes)
        for (size_t k = 0; k < kLanes; ++k) sums[k] += a[i + k] * b[i + k];
    return ((sums[0] + sums[4]) + (sums[1] + sums[5])) +
           ((sums[2] + sums[6]) + (sums[3] + sums[7]));
}

std::optional<ReducedMatrix> traceReducedMatrix(const SliceJob& job,
                                                std::span<const Receiver> receivers,
                                                std::span<const uint32_t> chosen,
                                                const std::stop_token& stop, uint64_t& rays)
{
    SliceRows rows;
    rows.reset(sceneView(job.receivers.accel->world()), receivers, chosen);
    const auto count = static_cast<uint32_t>(job.lights->lights.size());
    ReducedMatrix matrix(rows.count(), count);
    std::atomic<uint64_t> traced = 0;
    constexpr size_t kBlocks = 8;  // of a tracer, whose memory is not made for every block anew
    const bool whole = parallelFor(
        count, kBlocks * kBlock,
        [&](size_t begin, size_t end) {
            const FlushDenormals flush;
            BlockTracer tracer(job, rows);
            for (size_t j = begin; j < end && !stop.stop_requested(); j += kBlock)
                traced +=
                    tracer.trace(static_cast<uint32_t>(j),
                                 static_cast<uint32_t>(std::min(j + kBlock, end)), stop, matrix);
        },
        stop);
    rays += traced;
    if (!whole || stop.stop_requested()) return std::nullopt;
    return matrix;
}

}  // namespace core::many_lights

// Between the threads that complete slices and the device that sums them: a thread of its own hands
// over what waits, batch by batch, while the others complete what comes next.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

#include "core/many_lights/slice_piece.h"

namespace core::many_lights {

/// What is the same for all pieces of a batch.
struct SumRules {
    shared::GatherRules gather{};
    bool numbers = false;  // leavesNumbers
    LightShape shape = LightShape::point;
};
SumRules sumRules(const SliceJob& job);

/// Sums batches of pieces: a kernel, or its twin.
class BatchSum {
public:
    virtual ~BatchSum() = default;

    static constexpr size_t kMostPieces = 128;

    /// Entries (rows times columns) of a batch from now on, so that it takes no longer than a
    /// submission may.
    virtual uint64_t batchEntries() const = 0;

    /// What the rows of each piece get from its columns, one piece after the other, in `radiance`;
    /// they are kMostPieces at most. Waits until it is there; may throw. Returns the seconds that
    /// the device was busy.
    virtual double sum(std::span<const SlicePiece> pieces, const SumRules& rules,
                       std::span<glm::vec3> radiance) = 0;
};

/// At most a batch waits while another one is under way.
class SliceQueue {
public:
    /// Called by the queue's thread, slice by slice.
    using Finished = std::function<void(PendingSlice&)>;

    /// Keeps `sum` by reference: nobody else may use it before the queue is gone. What has not
    /// begun when `stop` is requested is given up.
    SliceQueue(BatchSum& sum, const SumRules& rules, const std::stop_token& stop,
               Finished finished);
    ~SliceQueue();

    /// Takes a piece of a slice, by any thread; waits where too much waits already. False when it
    /// is given up: after a stop or a failure.
    bool push(SlicePiece piece);

    /// Waits until all pieces have been summed or given up; none may follow. Throws what the device
    /// threw. Returns the seconds that it was busy.
    double finish();

private:
    void loop();
    std::vector<SlicePiece> takeBatch();
    void sumBatch(std::vector<SlicePiece> batch);

    BatchSum& sum_;
    SumRules rules_;
    Finished finished_;
    std::stop_source over_;
    std::mutex mutex_;
    std::condition_variable_any changed_;
    std::deque<SlicePiece> waiting_;
    uint64_t waitingEntries_ = 0, most_ = 0;
    bool closed_ = false;
    std::exception_ptr failure_;
    double seconds_ = 0;
    std::stop_callback<std::function<void()>> passOn_;
    std::jthread thread_;  // last: ends before what it uses
};

}  // namespace core::many_lights

// See slice_queue.h.
#include "core/many_lights/slice_queue.h"

#include <utility>

namespace core::many_lights {

SumRules sumRules(const SliceJob& job)
{
    return {
        {job.gather.maxDepth, job.gather.clampDistance}, leavesNumbers(job.completion), job.shape};
}

SliceQueue::SliceQueue(BatchSum& sum, const SumRules& rules, const std::stop_token& stop,
                       Finished finished)
    : sum_(sum), rules_(rules), finished_(std::move(finished)), most_(sum.batchEntries()),
      passOn_(stop, [this] { over_.request_stop(); }), thread_([this] { loop(); })
{}

SliceQueue::~SliceQueue()
{
    over_.request_stop();
}

bool SliceQueue::push(SlicePiece piece)
{
    std::unique_lock lock(mutex_);
    const bool room = changed_.wait(lock, over_.get_token(), [this] {
        return waitingEntries_ < most_ && waiting_.size() < BatchSum::kMostPieces;
    });
    if (!room || over_.stop_requested()) return false;
    waitingEntries_ += piece.entries();
    waiting_.push_back(std::move(piece));
    lock.unlock();
    changed_.notify_all();
    return true;
}

double SliceQueue::finish()
{
    {
        const std::lock_guard lock(mutex_);
        closed_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return seconds_;
}

void SliceQueue::loop()
{
    try {
        while (!over_.stop_requested()) {
            std::vector<SlicePiece> batch = takeBatch();
            if (batch.empty()) return;
            changed_.notify_all();
            sumBatch(std::move(batch));
        }
    } catch (...) {
        failure_ = std::current_exception();
        over_.request_stop();
    }
}

/// What waits, as far as a batch may have it: the device is free, and to wait for more would leave
/// it so. Nothing when there will be no more.
std::vector<SlicePiece> SliceQueue::takeBatch()
{
    std::unique_lock lock(mutex_);
    const bool some =
        changed_.wait(lock, over_.get_token(), [this] { return closed_ || !waiting_.empty(); });
    std::vector<SlicePiece> batch;
    if (!some || over_.stop_requested()) return batch;
    most_ = sum_.batchEntries();
    for (uint64_t entries = 0; !waiting_.empty() && batch.size() < BatchSum::kMostPieces;) {
        entries += waiting_.front().entries();
        if (!batch.empty() && entries > most_) break;
        waitingEntries_ -= waiting_.front().entries();
        batch.push_back(std::move(waiting_.front()));
        waiting_.pop_front();
    }
    return batch;
}

void SliceQueue::sumBatch(std::vector<SlicePiece> batch)
{
    size_t rows = 0;
    for (const SlicePiece& piece : batch) rows += piece.rows;
    std::vector<glm::vec3> radiance(rows);
    seconds_ += sum_.sum(batch, rules_, radiance);
    const glm::vec3* found = radiance.data();
    for (SlicePiece& piece : batch) {
        PendingSlice& slice = *piece.slice;
        for (uint32_t row = 0; row < piece.rows; ++row) slice.radiance[row] += *found++;
        if (--slice.pieces == 0) finished_(slice);
    }
}

}  // namespace core::many_lights

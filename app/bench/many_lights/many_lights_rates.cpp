// See many_lights_rates.h.
#include "app/bench/many_lights/many_lights_rates.h"

#include <atomic>
#include <mutex>

#include "app/bench/bench_clock.h"
#include "core/base/denormals.h"
#include "core/base/parallel.h"

namespace app::many_lights {

namespace {

using namespace core::many_lights;

constexpr size_t kSlices = 12;
constexpr int kTurns = 3;

/// Thread seconds for one slice's rays.
struct Turn {
    double rays = 0, packets = 0, single = 0, raw = 0;
};

double secondsOfFull(const core::Accel& accel, SliceVisibility& slice, bool packets,
                     const std::stop_token& stop)
{
    SliceOracle oracle(accel, slice.rows(), slice.columns(), slice.matters(), stop, packets);
    const ColumnRange all{0, static_cast<uint32_t>(slice.columns().size())};
    CompletedSlice completed;
    const double start = threadSeconds();
    complete(oracle, slice.rows().count(), {&all, 1}, {.method = CompletionMethod::full}, 0,
             completed);
    return threadSeconds() - start;
}

double secondsOfRaw(const core::Accel& accel, std::span<const core::RayPacket> packets)
{
    uint32_t blocked = 0;
    const double start = threadSeconds();
    for (const core::RayPacket& packet : packets)
        blocked ^= accel.occluded(packet, core::RayPacket::kSize);
    const double seconds = threadSeconds() - start;
    static std::atomic<uint32_t> used;  // so that nobody leaves the rays out
    used = blocked;
    return seconds;
}

std::vector<Turn> turnsOf(const core::Accel& accel, SliceVisibility& slice,
                          const std::stop_token& stop)
{
    std::vector<core::RayPacket> packets;
    const size_t rays =
        packShadowRays(accel, slice.rows(), slice.columns(), slice.matters(), packets);
    std::vector<Turn> turns;
    if (rays < core::RayPacket::kSize) return turns;
    // The last packet is not full: what it lacks is in the others' favour by less than one ray in
    // ten thousand, so it is filled with its first ray.
    const size_t missing = packets.size() * core::RayPacket::kSize - rays;
    core::RayPacket& last = packets.back();
    for (size_t i = core::RayPacket::kSize - missing; i < core::RayPacket::kSize; ++i)
        for (auto* lane : {&last.originX, &last.originY, &last.originZ, &last.directionX,
                           &last.directionY, &last.directionZ, &last.tMax})
            (*lane)[i] = (*lane)[0];
    last.seed.fill(last.seed[0]);
    for (int turn = 0; turn < kTurns && !stop.stop_requested(); ++turn) {
        Turn t{double(rays)};
        t.raw = secondsOfRaw(accel, packets);
        t.packets = secondsOfFull(accel, slice, true, stop);
        t.single = secondsOfFull(accel, slice, false, stop);
        turns.push_back(t);
    }
    return turns;
}

}  // namespace

std::optional<RayRates> measureRates(LitScene& scene, const Subset& subset, uint32_t clusters)
{
    core::ManyLightsParams params = scene.common();
    params.clusters = clusters;
    const auto points = scene.points(params.sliceSize);
    const auto frame = scene.frame(params, true, scene.lights(), params.seed);
    if (!points || !frame) return {};
    const std::vector<uint8_t> marks = slicesOf(*points, subset);
    std::vector<uint32_t> slices;
    for (uint32_t s = 0; s < marks.size() && slices.size() < kSlices; ++s)
        if (marks[s] != 0) slices.push_back(s);
    std::mutex mutex;
    std::vector<Turn> turns;
    const std::stop_token stop = scene.stop();
    core::parallelFor(
        slices.size(), 1,
        [&](size_t i, size_t) {
            const core::FlushDenormals flush;
            const core::IndexRange range = points->slices.ranges[slices[i]];
            SliceVisibility slice;
            SliceStats stats;
            SliceJob job = frame->job();
            job.completion = {};  // its bits are not used: what is wanted are rows and columns
            if (!slice.run(job, points->receivers,
                           {points->slices.order.data() + range.begin, range.size()}, slices[i],
                           stop, stats))
                return;
            const std::vector<Turn> mine = turnsOf(scene.accel(), slice, stop);
            const std::lock_guard lock(mutex);
            turns.insert(turns.end(), mine.begin(), mine.end());
        },
        stop);
    if (stop.stop_requested() || turns.empty()) return {};
    Turn sum;
    std::vector<double> ratios;
    for (const Turn& t : turns) {
        sum.rays += t.rays;
        sum.packets += t.packets;
        sum.single += t.single;
        sum.raw += t.raw;
        ratios.push_back(t.raw / t.packets);
    }
    return RayRates{sum.rays / sum.packets, sum.rays / sum.single, sum.rays / sum.raw,
                    spreadOf(std::move(ratios)).median};
}

}  // namespace app::many_lights

// Batches are kept short, so that no submission holds the device for long. See path_batches.h.
#include "app/gpu/path_batches.h"

#include <algorithm>
#include <bit>

#include "core/base/time.h"
#include "spirv/bounce.h"
#include "spirv/megakernel.h"

namespace gpu {

namespace {

constexpr uint32_t kMaxLanes = 1u << shared::kStateLaneBits;
// Mesa's software device ends every loop of an invocation after 65,535 iterations in all
// (traverse.glsl): a whole path must stay below. Its bounces are invocations of their own in the
// other kernel. In a soup of 300,000 triangles, where a ray takes a thousand, paths of 32 events
// lost a seventh of their rays: from the second depth on it is looked after every batch whether it
// has been cut short.
constexpr uint32_t kDeepestMegakernel = 32, kDeepestUnwatched = 8;
constexpr uint32_t kMeasuredLanes = 1u << 14;
// What is traced before another kernel is compiled beside it. A graphics card is not slowed down by
// that. A software device is, since it traces on the processors that the compiler takes: there so
// many times what compiling the first kernel took comes before. Kernels of bounces, the first ones,
// are 1.25 to 1.55 times as fast as the others (four scenes, depth 12, two cores), so that
// measuring seldom gains; kernels without a guide are 1.1 times as fast as those with one.
constexpr uint64_t kLanesBeforeAnother = 1u << 21;
constexpr double kCompilationsBeforeMeasuring = 20, kCompilationsBeforeExchange = 8;
constexpr uint32_t kBouncesPerSubmit = 16;  // then the host looks whether any path is left

uint32_t laneCount(const shared::Batch& batch)
{
    return batch.tileCount * batch.sampleCount * shared::kGroupSize;
}

}  // namespace

PathBatches::PathBatches(Context& context) : PathBatches(context, {k_bounce, k_megakernel}) {}

PathBatches::PathBatches(Context& context, const PathKernels& kernels)
    : context_(context), bounce_(context.device, kernels.bounce, &context.layouts),
      megakernel_(context.device, kernels.megakernel, &context.layouts),
      bounceSets_{DescriptorSet(context.device, bounce_.own()),
                  DescriptorSet(context.device, bounce_.own())},
      megakernelSet_(context.device, megakernel_.own()),
      queues_(context.device, "the queues", (kBouncesPerSubmit + 2) * sizeof(shared::QueueHead))
{
    for (DescriptorSet& set : bounceSets_) set.bind(shared::kBindQueues, queues_);
}

void PathBatches::bind(uint32_t binding, const Buffer& buffer)
{
    for (DescriptorSet* set : {&bounceSets_[0], &bounceSets_[1], &megakernelSet_})
        if (set->knows(binding)) set->bind(binding, buffer);
}

void PathBatches::forgetScene()
{
    work_ = {};
    choice_ = nullptr;
    choices_.clear();
    pace_.restart();
}

PathBatches::WorkKind PathBatches::kindOfWork() const
{
    const shared::PathSettings& settings = work_.frame->data().settings;
    const bool small = uint64_t(settings.imageWidth) * settings.imageHeight < kMeasuredLanes;
    return {work_.constants, settings.maxDepth, work_.strategy, small};
}

double PathBatches::prepare(const PathWork& work, const Then& then)
{
    work_ = work;
    choice_ = &choices_[kindOfWork()];
    choice_->lanes = 0;
    choice_->seconds = 0;
    const shared::PathSettings& settings = work.frame->data().settings;
    const Length length{settings.maxDepth, settings.rouletteDepth, work.strategy};
    if (!isCompiled(work.constants) || length.mayBeMoreThan(length_))
        pace_.restart();
    else if (!work.whole)
        pace_.again();
    length_ = length;
    waits_ = false;
    takeChoice();
    const auto start = core::Clock::now();
    if (!compile(then)) return 0;
    return compileSeconds_ = core::secondsSince(start);
}

/// What is faster for one kind of paths is taken to be so for the other.
void PathBatches::exchange(const PathConstants& constants)
{
    if (work_.constants == constants) return;
    const Choice known = *choice_;
    work_.constants = constants;
    choice_ = &choices_.try_emplace(kindOfWork(), known).first->second;
    choice_->lanes = known.lanes;
    choice_->seconds = known.seconds;
    waits_ = false;
    takeChoice();
}

/// Whether so much has been traced that it pays to compile another kernel.
bool PathBatches::isWorth(uint64_t lanes, double seconds, double compilations) const
{
    if (lanes <= kLanesBeforeAnother) return false;
    return !context_.device.isSoftware() || seconds > compilations * compileSeconds_;
}

void PathBatches::exchangeWhenCompiled(const PathConstants& constants)
{
    if (work_.constants == constants) return;
    waits_ = true;
    if (!isCompiled(constants)) {
        if (!isWorth(waitedLanes_, waitedSeconds_, kCompilationsBeforeExchange)) return;
        if (wavefront_)
            bounce_.compileBeside(constants);
        else
            megakernel_.compileBeside(constants);
        if (!isCompiled(constants)) return;
    }
    exchange(constants);
}

void PathBatches::makeRoom(const Frame& frame)
{
    // Powers of two: few sizes in all, as a new one makes Mesa's software device compile the
    // kernels again.
    const uint32_t lanes =
        std::bit_ceil(std::clamp(frame.tileCount() * shared::kGroupSize, 1u << 16, kMaxLanes));
    if (radiance_.bytes() >= lanes * sizeof(glm::vec4)) return;
    radiance_ = {};  // first: its size tells whether all of these could be had
    for (Buffer& states : states_) {
        states = {};
        states = Buffer(context_.device, "the paths", uint64_t(lanes) * shared::kStateWords * 16,
                        VK_FORMAT_R32G32B32A32_UINT);
    }
    radiance_ = Buffer(context_.device, "the paths' radiance", lanes * sizeof(glm::vec4));
    megakernelSet_.bind(shared::kBindRadiance, radiance_);
    for (uint32_t i = 0; i < 2; ++i) {
        bounceSets_[i].bind(shared::kBindRadiance, radiance_);
        bounceSets_[i].bind(shared::kBindStateTexels, states_[i]);
        bounceSets_[i].bind(shared::kBindStates, states_[1 - i]);
    }
}

KernelSets PathBatches::sets(const DescriptorSet& own) const
{
    return {&work_.scene->set(), &work_.frame->set(), &own};
}

/// Software drivers compile at the first dispatch: an empty batch makes them do it now. What a
/// picture does not need is not compiled. Returns whether there was anything to compile.
bool PathBatches::compile(const Then& then)
{
    if (wavefront_ ? bounce_.isCompiled(work_.constants) : megakernel_.isCompiled(work_.constants))
        return false;
    const Pipeline& pipeline =
        wavefront_ ? bounce_.pipeline(work_.constants) : megakernel_.pipeline(work_.constants);
    const shared::Batch empty{0, 1, 0, 0};
    context_.device.submit(
        [&](VkCommandBuffer commands) {
            if (wavefront_) {
                bounce_.dispatch(commands, pipeline, sets(bounceSets_[0]), {empty, 0, 1}, 1);
            } else {
                megakernel_.dispatch(commands, pipeline, sets(megakernelSet_), empty, 1);
            }
            barrier(commands);
            then(commands, empty);
        },
        "the compilation of the kernels");
    return true;
}

/// The kernel that is the right one by what is known. False when measuring could tell more.
bool PathBatches::takeChoice()
{
    const bool tooDeep =
        choice_->cut || (context_.device.isSoftware() && maxDepth() > kDeepestMegakernel);
    const bool automatic = work_.kernel == core::Kernel::automatic && !tooDeep;
    const bool open = automatic && maxDepth() > 1;
    if (open) {
        wavefront_ = choice_->wavefront;
    } else if (automatic) {
        // Paths of one event are short: both kernels do, and compiling another one would hold up a
        // camera that moves for seconds.
        wavefront_ =
            bounce_.isCompiled(work_.constants) && !megakernel_.isCompiled(work_.constants);
    } else {
        wavefront_ = tooDeep || work_.kernel == core::Kernel::wavefront;
    }
    return !open || choice_->made;
}

/// On one batch from the middle of the image, twice, in turns, the results thrown away: once per
/// kind of work, so that neither moving nor editing is held up by it. Of two turns the first may
/// hold a software driver's own compilation, which comes with the first dispatch. The batch is
/// small on a software device, which so many lanes fill; others are measured with batches as they
/// get.
void PathBatches::chooseKernel(uint32_t lanes)
{
    if (takeChoice() || waits_) return;
    if (!isWorth(choice_->lanes, choice_->seconds, kCompilationsBeforeMeasuring)) return;
    bounce_.compileBeside(work_.constants);
    megakernel_.compileBeside(work_.constants);
    if (!bounce_.isCompiled(work_.constants) || !megakernel_.isCompiled(work_.constants)) return;
    const uint32_t tiles = work_.frame->tileCount();
    const uint32_t most =
        context_.device.isSoftware() ? std::min(kMeasuredLanes, lanes / 2) : lanes;
    const uint32_t count = std::clamp(most / shared::kGroupSize, 1u, tiles);
    const uint32_t samples = std::max(most / (count * shared::kGroupSize), 1u);
    const shared::Batch batch{(tiles - count) / 2, count, 0, samples};
    const Then nothing = [](VkCommandBuffer, const shared::Batch&) {};
    double best[2] = {1e30, 1e30};
    for (int round = 0; round < 4; ++round) {
        wavefront_ = round % 2 == 0;
        best[round % 2] = std::min(best[round % 2], run(batch, nothing));
    }
    choice_->wavefront = best[0] <= best[1];
    choice_->made = true;
    work_.frame->clearCounters();
    takeChoice();
}

uint32_t PathBatches::lanes(double seconds) const
{
    return pace_.lanes(seconds, mostLanes());
}

void PathBatches::trace(const shared::Batch& batch, const Then& then)
{
    const double seconds = run(batch, then);
    pace_.measured(laneCount(batch), seconds);
    choice_->lanes += laneCount(batch);
    choice_->seconds += seconds;
    if (!waits_) return;
    waitedLanes_ += laneCount(batch);
    waitedSeconds_ += seconds;
}

/// Returns the seconds that the device was busy.
double PathBatches::run(const shared::Batch& batch, const Then& then)
{
    if (wavefront_) return runBounces(batch, then);
    if (context_.device.isSoftware() && maxDepth() > kDeepestUnwatched)
        return runWatched(batch, then);
    return runWhole(batch, then);
}

double PathBatches::runWhole(const shared::Batch& batch, const Then& then)
{
    const Pipeline& pipeline = megakernel_.pipeline(work_.constants);
    return context_.device.submit(
        [&](VkCommandBuffer commands) {
            megakernel_.dispatch(commands, pipeline, sets(megakernelSet_), batch,
                                 groupsFor(laneCount(batch)));
            barrier(commands);
            then(commands, batch);
        },
        describe("whole paths", batch));
}

/// Where the device has cut a path short the batch is done again by bounces, and all that follow.
double PathBatches::runWatched(const shared::Batch& batch, const Then& then)
{
    const shared::Counters before = work_.frame->counters();
    const double seconds = runWhole(batch, [](VkCommandBuffer, const shared::Batch&) {});
    if (work_.frame->counters().cutRays == before.cutRays) {
        return seconds +
               context_.device.submit([&](VkCommandBuffer commands) { then(commands, batch); },
                                      describe("the sum", batch));
    }
    work_.frame->setCounters(before);
    choice_->cut = true;
    takeChoice();
    return seconds + runBounces(batch, then);
}

/// Bounces are submitted sixteen at a time; the sizes of their queues stay on the device.
double PathBatches::runBounces(const shared::Batch& batch, const Then& then)
{
    const Pipeline& pipeline = bounce_.pipeline(work_.constants);
    double seconds = 0;
    bool finished = false;  // `then` has been recorded
    uint32_t side = 0, waiting = laneCount(batch);
    for (uint64_t done = 0; waiting > 0 && done <= maxDepth(); done += kBouncesPerSubmit) {
        const auto count =
            static_cast<uint32_t>(std::min<uint64_t>(kBouncesPerSubmit, maxDepth() + 1 - done));
        std::array<shared::QueueHead, kBouncesPerSubmit + 1> heads;
        heads.fill({0, 1, 1, 0});
        heads[0] = {groupsFor(waiting), 1, 1, waiting};
        seconds += context_.device.submit(
            [&](VkCommandBuffer commands) {
                vk.CmdUpdateBuffer(commands, queues_.get(), 0, sizeof(heads), heads.data());
                for (uint32_t b = 0; b < count; ++b, side = 1 - side) {
                    barrier(commands);
                    const shared::BounceBatch push{batch, b, done + b == 0 ? 1u : 0u};
                    bounce_.dispatchIndirect(commands, pipeline, sets(bounceSets_[side]), push,
                                             queues_, b * sizeof(shared::QueueHead));
                }
                barrier(commands);
                finished = done + count > maxDepth();  // no path can be left
                if (finished) then(commands, batch);
            },
            describe("bounces", batch));
        shared::QueueHead next;
        queues_.read(std::as_writable_bytes(std::span(&next, 1)), count * sizeof(next));
        waiting = next.count;
    }
    if (!finished) {
        seconds += context_.device.submit([&](VkCommandBuffer commands) { then(commands, batch); },
                                          describe("the sum", batch));
    }
    return seconds;
}

/// A batch in words, for the message of a device that is lost in it.
std::string PathBatches::describe(const char* kernel, const shared::Batch& batch) const
{
    return std::string(kernel) + " of " + std::to_string(work_.triangleCount) +
           " triangles, tiles " + std::to_string(batch.firstTile) + " to " +
           std::to_string(batch.firstTile + batch.tileCount - 1) + " of " +
           std::to_string(work_.frame->tileCount()) + ", samples " +
           std::to_string(batch.firstSample) + " to " +
           std::to_string(batch.firstSample + batch.sampleCount - 1);
}

}  // namespace gpu

// See slice_sums.h.
#include "app/gpu/slice_sums.h"

#include <algorithm>
#include <bit>

#include "core/base/check.h"
#include "core/base/time.h"
#include "spirv/gather.h"

namespace gpu {

namespace {

constexpr VkFormat kWords = VK_FORMAT_R32G32B32A32_UINT;
constexpr double kLongest = 0.04;  // seconds of a submission: what a stop waits for
// Entries that BatchPace counts as a lane: of points, and of lights with extent, which are many
// samples each.
constexpr uint32_t kLaneEntries = 1024, kExtendedLaneEntries = 64;
constexpr uint32_t kMostLanes = 1u << 16;           // of a batch: eight megabytes of bits,
constexpr uint32_t kMostLanesOfNumbers = 1u << 14;  // or 64 of numbers

}  // namespace

SliceSums::SliceSums(const DeviceOptions& options)
    : context_(options), kernel_(context_.device, k_gather, &context_.layouts),
      set_(context_.device, kernel_.own()), groups_{shared::kBindSliceGroups,
                                                    "the groups of receivers", kWords},
      receivers_{shared::kBindReceivers, "the receivers", kWords},
      lights_{shared::kBindVirtualLights, "the virtual lights", kWords},
      details_{shared::kBindLightDetails, "the surfaces of virtual lights", kWords},
      values_{shared::kBindSliceValues, "the visibility", VK_FORMAT_R32_UINT}
{}

void SliceSums::setWorld(std::shared_ptr<const core::World> world, const core::Progress& progress)
{
    if (!takeWorld(scene_, world_, std::move(world), context_, progress, SceneUse::shaded))
        pace_.restart();
}

GatherConstants SliceSums::constantsFor(const core::many_lights::SumRules& rules) const
{
    return {scene_->features(), rules.numbers ? 1u : 0u, static_cast<uint32_t>(rules.shape)};
}

uint32_t SliceSums::laneEntries() const
{
    return rules_.shape == core::many_lights::LightShape::point ? kLaneEntries
                                                                : kExtendedLaneEntries;
}

uint32_t SliceSums::lanesOf(uint64_t entries) const
{
    const uint32_t each = laneEntries();
    return static_cast<uint32_t>((entries + each - 1) / each);
}

/// Software drivers compile at the first dispatch: an empty batch makes them do it now.
void SliceSums::prepare(const core::many_lights::SumRules& rules)
{
    CHECK(scene_ != nullptr);
    if (rules.shape == rules_.shape) {
        pace_.again();
    } else {
        pace_.restart();
    }
    rules_ = rules;
    if (kernel_.isCompiled(constantsFor(rules))) return;
    const core::Clock::time_point start = core::Clock::now();
    groups_.items.assign(1, {});
    dispatch(rules, "the compilation of the kernels");
    compileSeconds_ += core::secondsSince(start);
}

void SliceSums::addTo(core::RenderStats& stats) const
{
    const core::RenderStats mine = context_.stats();
    stats.device = mine.device;
    stats.driver = mine.driver;
    stats.peakDeviceBytes = mine.peakDeviceBytes;
    stats.compileSeconds = compileSeconds_;
    stats.readbackSeconds = readbackSeconds_;
}

uint64_t SliceSums::batchEntries() const
{
    const uint32_t most = rules_.numbers ? kMostLanesOfNumbers : kMostLanes;
    return uint64_t(pace_.lanes(std::min(seconds_, kLongest), most)) * laneEntries();
}

void SliceSums::makeRoom(Buffer& buffer, uint32_t binding, const char* name, uint64_t bytes,
                         VkFormat format)
{
    constexpr uint64_t kLeast = 1 << 16;
    if (buffer.bytes() >= std::max(bytes, uint64_t(1))) return;
    set_.unbind(binding);
    buffer = {};
    buffer = Buffer(context_.device, name, std::bit_ceil(std::max(bytes, kLeast)), format);
    set_.bind(binding, buffer);
}

template <class T> void SliceSums::upload(Array<T>& array)
{
    makeRoom(array.buffer, array.binding, array.name, array.items.size() * sizeof(T), array.format);
    array.buffer.writeAll(array.items);
}

/// Adds a piece to the batch.
void SliceSums::append(const core::many_lights::SlicePiece& piece, bool numbers)
{
    for (uint32_t i = 0; i < piece.groups(); ++i) {
        shared::SliceGroup group = piece.group(i, numbers);
        group.firstLight += static_cast<uint32_t>(lights_.items.size());
        group.firstDetail += static_cast<uint32_t>(details_.items.size());
        group.firstValue += static_cast<uint32_t>(values_.items.size());
        group.firstReceiver += static_cast<uint32_t>(receivers_.items.size());
        groups_.items.push_back(group);
    }
    const auto add = [](auto& array, const auto& more) {
        array.items.insert(array.items.end(), more.begin(), more.end());
    };
    add(lights_, piece.lights);
    add(details_, piece.details);
    add(values_, piece.values);
    add(receivers_, piece.receivers);
}

double SliceSums::dispatch(const core::many_lights::SumRules& rules, const char* what)
{
    upload(groups_);
    upload(receivers_);
    upload(lights_);
    upload(details_);
    upload(values_);
    const auto groups = static_cast<uint32_t>(groups_.items.size());
    makeRoom(gathered_, shared::kBindGathered, "the light of receivers",
             uint64_t(groups) * shared::kSliceGroup * sizeof(glm::vec4), VK_FORMAT_UNDEFINED);
    const Pipeline& pipeline = kernel_.pipeline(constantsFor(rules));
    return context_.device.submit(
        [&](VkCommandBuffer commands) {
            kernel_.dispatch(commands, pipeline, {&scene_->set(), nullptr, &set_}, rules.gather,
                             groups);
            barrier(commands);
        },
        what);
}

double SliceSums::sum(std::span<const core::many_lights::SlicePiece> pieces,
                      const core::many_lights::SumRules& rules, std::span<glm::vec3> radiance)
{
    groups_.items.clear();
    lights_.items.clear();
    details_.items.clear();
    values_.items.clear();
    receivers_.items.clear();
    uint64_t entries = 0;
    for (const core::many_lights::SlicePiece& piece : pieces) {
        append(piece, rules.numbers);
        entries += piece.entries();
    }
    const double seconds = dispatch(rules, "the sum of virtual lights");
    pace_.measured(lanesOf(entries), seconds);

    const core::Clock::time_point start = core::Clock::now();
    found_.resize(groups_.items.size() * shared::kSliceGroup);
    gathered_.read(std::as_writable_bytes(std::span(found_)));
    size_t row = 0;
    for (size_t g = 0; g < groups_.items.size(); ++g)
        for (uint32_t i = 0; i < groups_.items[g].rows; ++i)
            radiance[row++] = glm::vec3(found_[g * shared::kSliceGroup + i]);
    readbackSeconds_ += core::secondsSince(start);
    return seconds;
}

}  // namespace gpu

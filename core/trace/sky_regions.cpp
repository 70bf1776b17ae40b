// Probes are rays from places towards the environment, drawn by its table or by those of regions;
// cells of a table get the root of the mean square of what their probes brought, the density with
// the least variance (whatever number of probes a cell has had). A region leans on the one that it
// was cut from where it has few probes of its own.
#include "core/trace/sky_regions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>

#include "core/base/parallel.h"
#include "core/base/pcg32.h"
#include "core/base/time.h"
#include "core/scene/light_table.h"
#include "core/trace/scene_view.h"
#include "core/trace/sky_places.h"

namespace core {

namespace {

using glm::vec2;
using shared::kSkySide;

constexpr size_t kWalks = 4096, kFirstWalks = 512;
constexpr uint32_t kFirstProbes = 8;   // of a place,
constexpr uint32_t kAimedProbes = 24;  // and so many more by its region's table
constexpr uint32_t kLampProbes = 4;
constexpr size_t kLeastPlaces = 48;     // of a region
constexpr size_t kSlice = 2048;         // places between two reports
constexpr double kPrior = 2;            // what the region above counts, in probes of each cell
constexpr double kWholeAtFirst = 0.25;  // share of directions that the whole environment keeps
constexpr double kWhole = 0.1;
constexpr double kLeastShare = 0.05;  // of the environment among emitters, and of all others
constexpr double kHidden = 0.125;     // probes that bring something; below, regions pay

constexpr uint32_t kCells = kSkySide * kSkySide;
using Cells = std::array<double, kCells>;

struct Probe {
    uint32_t cell = 0;
    float brings = 0;
};

uint32_t cellOf(vec2 u)
{
    const vec2 at = glm::min(u * static_cast<float>(kSkySide), static_cast<float>(kSkySide - 1));
    return static_cast<uint32_t>(at.y) * kSkySide + static_cast<uint32_t>(at.x);
}

class Learner {
public:
    /// `report` gets the share of all probes that have been traced.
    Learner(
        const Accel& accel, std::vector<Place> places,
        std::function<void(double)> report = [](double) {})
        : accel_(accel), places_(std::move(places)), report_(std::move(report)),
          probes_(places_.size() * (kFirstProbes + kAimedProbes)), lampSquares_(places_.size()),
          settings_(worldSettings(accel.world()))
    {}

    /// Share of first probes that bring something.
    double probeWhole()
    {
        probe(0, kFirstProbes, nullptr);
        size_t seen = 0;
        for (size_t i = 0; i < places_.size(); ++i)
            for (const Probe& p : probesOf(i)) seen += p.brings > 0;
        return static_cast<double>(seen) / std::max(1.0, double(places_.size()) * kFirstProbes);
    }

    SkyRegions learn()
    {
        const SkyRegions rough = makeRegions(kWholeAtFirst);
        probe(kFirstProbes, kAimedProbes, rough.words.data());
        return makeRegions(kWhole);
    }

private:
    std::span<const Probe> probesOf(size_t place) const
    {
        return {&probes_[place * (kFirstProbes + kAimedProbes)], probed_};
    }

    /// Traces `count` probes for each place, from its number `first` on, by the tables in `words`
    /// or, null, by the environment's own; and those of lamps with the first.
    void probe(uint32_t first, uint32_t count, const glm::uvec4* words)
    {
        probed_ = first + count;
        const double all = double(places_.size()) * (kFirstProbes + kAimedProbes);
        for (size_t slice = 0; slice < places_.size(); slice += kSlice) {
            const size_t places = std::min(kSlice, places_.size() - slice);
            report_((double(first) * double(places_.size()) + double(count) * double(slice)) / all);
            parallelFor(places, 64, [&](size_t begin, size_t end) {
                probePlaces(slice + begin, slice + end, first, count, words);
            });
        }
    }

    void probePlaces(size_t begin, size_t end, uint32_t first, uint32_t count,
                     const glm::uvec4* words)
    {
        Bringing bringing(accel_);
        std::vector<float> lamps((end - begin) * kLampProbes);
        for (size_t i = begin; i < end; ++i) {
            Pcg32 random(first, i);
            probeSky(i, {&probes_[i * (kFirstProbes + kAimedProbes) + first], count}, words, random,
                     bringing);
            if (first == 0 && settings_.emitterCount > 1)
                probeLamps(i, {&lamps[(i - begin) * kLampProbes], kLampProbes}, random, bringing);
        }
        bringing.trace();
        for (size_t k = 0; k < lamps.size() && first == 0; ++k)
            lampSquares_[begin + k / kLampProbes] +=
                double(lamps[k]) * double(lamps[k]) / kLampProbes;
    }

    void probeSky(size_t place, std::span<Probe> probes, const glm::uvec4* words, Pcg32& random,
                  Bringing& bringing) const
    {
        shared::SceneView view = sceneView(accel_.world());
        view.skyRegions = words;
        const uint32_t region =
            words == nullptr
                ? 0
                : shared::findSkyRegion(view, places_[place].position, places_[place].normal);
        for (size_t k = 0; k < probes.size(); ++k) {
            // Stratified in rows of the table.
            vec2 u(static_cast<float>(random()),
                   static_cast<float>((double(k) + random()) / double(probes.size())));
            u = glm::min(u, shared::kOneMinusEpsilon);
            if (region != 0) shared::warpToSky(view, region, u);
            probes[k].cell = cellOf(u);
            shared::EmitterSample sample;
            if (shared::sampleEnvironment(view, settings_, 0, u, sample))
                bringing.add(places_[place], sample, 1 / sample.pdf, probes[k].brings);
        }
    }

    void probeLamps(size_t place, std::span<float> brings, Pcg32& random, Bringing& bringing) const
    {
        const shared::SceneView view = sceneView(accel_.world());
        const Place& p = places_[place];
        const float lamps = 1 - shared::pmfEmitter(view, settings_.environmentEmitter);
        for (float& b : brings) {
            const auto u = [&] {
                return std::min(static_cast<float>(random()), shared::kOneMinusEpsilon);
            };
            const shared::EmitterChoice chosen =
                shared::finishChoice(view, p.position, shared::packReceiver(p.normal),
                                     shared::beginBesideSky(view, settings_, lamps * u()));
            const float x = u();
            shared::EmitterSample sample;
            if (chosen.pmf > 0 && chosen.emitter != settings_.environmentEmitter &&
                shared::sampleEmitter(view, settings_, chosen.emitter, p.position, 0, {x, u()},
                                      sample))
                bringing.add(p, sample, lamps / (chosen.pmf * (sample.pdf > 0 ? sample.pdf : 1)),
                             b);
        }
    }

    /// Mean squares of what probes of these places brought, cell by cell, `above` where there are
    /// few.
    Cells squares(std::span<const uint32_t> items, const Cells& above) const
    {
        Cells sums{}, counts{};
        for (const uint32_t i : items) {
            for (const Probe& p : probesOf(i)) {
                sums[p.cell] += double(p.brings) * double(p.brings);
                counts[p.cell] += 1;
            }
        }
        for (uint32_t c = 0; c < kCells; ++c)
            sums[c] = (sums[c] + kPrior * above[c]) / (counts[c] + kPrior);
        return sums;
    }

    SkyRegions makeRegions(double whole)
    {
        made_ = {};
        whole_ = whole;
        made_.words.resize(shared::kSkyRootWords);
        std::array<std::vector<uint32_t>, shared::kSkyRoots> trees;
        std::vector<uint32_t> all(places_.size());
        std::iota(all.begin(), all.end(), 0u);
        for (const uint32_t i : all) trees[shared::skyRoot(places_[i].normal)].push_back(i);
        const Cells everywhere = squares(all, Cells{});
        for (uint32_t t = 0; t < trees.size(); ++t)
            made_.words[t >> 2][static_cast<int>(t & 3)] =
                trees[t].empty() ? shared::kSkyRegionBit : addTree(trees[t], everywhere);
        return std::move(made_);
    }

    /// Returns the reference to the tree over these places.
    uint32_t addTree(std::span<uint32_t> items, const Cells& above)
    {
        const Cells own = squares(items, above);
        glm::vec3 low = places_[items[0]].position, high = low;
        for (const uint32_t i : items) {
            low = glm::min(low, places_[i].position);
            high = glm::max(high, places_[i].position);
        }
        const glm::vec3 size = high - low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        const auto at = [&](uint32_t i) { return places_[i].position[axis]; };
        const auto middle = items.begin() + static_cast<std::ptrdiff_t>(items.size() / 2);
        std::nth_element(items.begin(), middle, items.end(), [&](uint32_t a, uint32_t b) {
            return at(a) != at(b) ? at(a) < at(b) : a < b;
        });
        const float plane = at(*middle);
        const auto upper =
            std::partition(items.begin(), items.end(), [&](uint32_t i) { return at(i) < plane; });
        if (items.size() < 2 * kLeastPlaces || upper == items.begin()) return addRegion(items, own);
        const auto node = static_cast<uint32_t>(made_.words.size());
        made_.words.emplace_back();
        const uint32_t below = addTree({items.begin(), upper}, own);
        const uint32_t beyond = addTree({upper, items.end()}, own);
        made_.words[node] = {std::bit_cast<uint32_t>(plane), static_cast<uint32_t>(axis), below,
                             beyond};
        return node;
    }

    uint32_t addRegion(std::span<const uint32_t> items, const Cells& meanSquares)
    {
        const auto region = static_cast<uint32_t>(made_.words.size());
        made_.words.resize(region + shared::kSkyRegionWords);
        Cells weights;
        for (uint32_t c = 0; c < kCells; ++c) weights[c] = std::sqrt(meanSquares[c]);
        const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
        made_.words[region].x = std::bit_cast<uint32_t>(shareOfSky(items, sum / kCells));
        std::array<double, kSkySide> rows{};
        for (uint32_t c = 0; c < kCells; ++c) {
            weights[c] = ((sum > 0 ? (1 - whole_) * weights[c] / sum : 0) + whole_ / kCells);
            rows[c / kSkySide] += weights[c];
        }
        writeCdf(region + 1, rows);
        for (uint32_t y = 0; y < kSkySide; ++y)
            writeCdf(region + 1 + shared::kSkyCdfWords * (1 + y),
                     {&weights[size_t(y) * kSkySide], kSkySide});
        ++made_.count;
        return region | shared::kSkyRegionBit;
    }

    /// By the root mean squares of what the environment, drawn by this table, and other emitters
    /// bring.
    float shareOfSky(std::span<const uint32_t> items, double sky) const
    {
        // Without others nothing may be left to them.
        if (!(shared::pmfEmitter(sceneView(accel_.world()), settings_.environmentEmitter) < 1))
            return 1;
        double lamps = 0;
        for (const uint32_t i : items) lamps += lampSquares_[i];
        lamps = std::sqrt(lamps / static_cast<double>(items.size()));
        const double share = sky + lamps > 0 ? sky / (sky + lamps) : 0.5;
        return static_cast<float>(std::clamp(share, kLeastShare, 1 - kLeastShare));
    }

    void writeCdf(uint32_t word, std::span<const double> weights)
    {
        const std::vector<float> cdf = makeCdf(weights);
        for (uint32_t k = 0; k < kSkySide; ++k)
            made_.words[word + k / 4][static_cast<int>(k % 4)] =
                std::bit_cast<uint32_t>(cdf[k + 1]);
    }

    const Accel& accel_;
    std::vector<Place> places_;
    std::function<void(double)> report_;
    std::vector<Probe> probes_;  // kFirstProbes + kAimedProbes of each place
    std::vector<double> lampSquares_;
    shared::PathSettings settings_;
    uint32_t probed_ = 0;  // of each place
    SkyRegions made_;      // while they are made
    double whole_ = 0;
};

}  // namespace

std::shared_ptr<const SkyRegions> makeSkyRegions(const Accel& accel, SkyNeed need,
                                                 const Progress& progress)
{
    if (accel.world().environmentEmitter == shared::kNone) return nullptr;
    const auto report = [&](double share) {
        if (progress) progress("looking for the sky", share);
    };
    const Clock::time_point start = Clock::now();
    report(0);
    if (need == SkyNeed::hidden) {
        std::vector<Place> some = findPlaces(accel, kFirstWalks, 0);
        if (some.empty()) return nullptr;
        const double seen = Learner(accel, std::move(some)).probeWhole();
        if (seen > kHidden) return nullptr;
    }
    report(0);
    std::vector<Place> places = findPlaces(accel, kWalks, 1);
    if (places.empty()) return nullptr;
    Learner learner(accel, std::move(places), report);
    learner.probeWhole();
    SkyRegions made = learner.learn();
    made.seconds = secondsSince(start);
    return std::make_shared<const SkyRegions>(std::move(made));
}

}  // namespace core

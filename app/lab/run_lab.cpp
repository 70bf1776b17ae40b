// The order of the experiments, and how many trials each gets. See run_lab.h.
#include "app/lab/run_lab.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "app/lab/flatland.h"
#include "app/lab/flatland_picture.h"
#include "app/lab/moving_lobe.h"
#include "app/lab/table.h"
#include "app/lab/traps.h"
#include "core/base/time.h"

namespace app::lab {

namespace {

using Step = std::function<void(double)>;
using Report = std::function<void(const char*, double)>;

/// Steps of one of `parts` equal parts of a stage. Safe to call from any thread.
class Stage {
public:
    Stage(const char* name, size_t parts, const Report& report)
        : name_(name), parts_(static_cast<double>(parts)), report_(report)
    {}

    Step part(size_t index)
    {
        return [this, index](double fraction) {
            const std::lock_guard lock(mutex_);
            report_(name_, (static_cast<double>(index) + fraction) / parts_);
        };
    }

private:
    const char* name_;
    double parts_;
    const Report& report_;
    std::mutex mutex_;
};

bool measureTable(const LabSettings& settings, LabResults& results, const Report& report,
                  std::stop_token stop)
{
    Stage table("table", kPairs, report);
    for (size_t i = 0; i < kPairs; ++i) {
        const std::vector<Cell> cells = measurePair(pairs()[i], settings, table.part(i), stop);
        if (cells.empty()) return false;
        results.cells.insert(results.cells.end(), cells.begin(), cells.end());
    }
    Stage sweeps("sweeps over c and k", kPairs, report);
    for (size_t i = 0; i < kPairs; ++i)
        if (!measureSweeps(pairs()[i], settings, results, sweeps.part(i), stop)) return false;
    return true;
}

/// The sequences that the report shows: the right way and MIS, resampled in two ways, and what is
/// biased.
std::vector<LobeSettings> lobeSequences(const LabSettings& settings)
{
    using core::reuse::Resampling;
    struct Variant {
        LobeMethod method;
        uint32_t k;
        Resampling resampling = Resampling::threshold;
    };
    const Variant variants[] = {{LobeMethod::reweightingAugmentation, 8},
                                {LobeMethod::reweightingAugmentation, 8, Resampling::systematic},
                                {LobeMethod::balanceHeuristic, 1},
                                {LobeMethod::equalWeights, 2},
                                {LobeMethod::equalWeights, 8},
                                {LobeMethod::accumulation, 0}};
    std::vector<LobeSettings> list;
    for (const double step : {0.002, 0.01, 0.04}) {
        for (const Variant& v : variants) {
            LobeSettings lobe;
            lobe.method = v.method;
            lobe.k = v.k;
            lobe.resampling = v.resampling;
            lobe.step = step;
            lobe.trials = std::max<uint64_t>(settings.trials / 20, 100);
            lobe.seed = settings.seed;
            list.push_back(lobe);
        }
    }
    return list;
}

/// What an independent computation with systematic resampling gave for n = 4, K = 32, k = 8.
double expectedRatio(const LobeSettings& lobe)
{
    using core::reuse::Resampling;
    if (lobe.method != LobeMethod::reweightingAugmentation ||
        lobe.resampling != Resampling::systematic)
        return kUnknown;
    return lobe.step == 0.002 ? 0.112 : lobe.step == 0.01 ? 0.107 : 0.259;
}

bool measureLobes(const LabSettings& settings, LabResults& results, const Report& report,
                  std::stop_token stop)
{
    const std::vector<LobeSettings> sequences = lobeSequences(settings);
    Stage stage("moving lobe", sequences.size(), report);
    for (size_t i = 0; i < sequences.size(); ++i) {
        LobeSequence sequence = movingLobe(sequences[i], stop);
        if (sequence.frames.empty()) return false;
        sequence.expectedRatio = expectedRatio(sequences[i]);
        results.lobes.push_back(std::move(sequence));
        stage.part(i)(1);
    }
    return true;
}

/// What a history of a given memory should keep.
bool measureStores(const LabSettings& settings, LabResults& results, const Report& report,
                   std::stop_token stop)
{
    struct Variant {
        uint32_t kept;
        double cap, brightness;
    };
    constexpr Variant kVariants[] = {
        {16, 16, 0}, {16, 64, 0}, {16, 64, 1}, {16, 64, 4}, {32, 32, 0}};
    constexpr double kSteps[] = {0.002, 0.01, 0.04};
    Stage stage("stores", std::size(kVariants) * std::size(kSteps), report);
    for (const Variant& v : kVariants) {
        for (const double step : kSteps) {
            LobeSettings lobe;
            lobe.step = step;
            lobe.K = v.kept;
            lobe.cap = v.cap;
            lobe.brightness = v.brightness;
            lobe.trials = std::max<uint64_t>(settings.trials / 40, 100);
            lobe.seed = settings.seed;
            const LobeSequence sequence = movingLobe(lobe, stop);
            if (sequence.frames.empty()) return false;
            double largestZ = 0;
            for (const LobeFrame& f : sequence.frames) largestZ = std::max(largestZ, std::abs(f.z));
            results.stores.push_back(
                {step, v.kept, v.cap, v.brightness, sequence.lateVarianceRatio, largestZ});
            stage.part(results.stores.size() - 1)(1);
        }
    }
    return true;
}

}  // namespace

std::optional<LabResults>
runLab(const LabSettings& settings,
       const std::function<void(const char* stage, double fraction)>& progress,
       std::stop_token stop)
{
    const core::Clock::time_point start = core::Clock::now();
    LabResults results;
    results.trials = settings.trials;
    results.seed = settings.seed;
    results.quick = settings.quick;
    if (!measureTable(settings, results, progress, stop)) return {};
    results.majorisation = majorisationSweep();
    if (!measureLobes(settings, results, progress, stop)) return {};
    if (!measureStores(settings, results, progress, stop)) return {};
    Stage flat("flatland", 1, progress), traps("traps", 1, progress);
    results.flatland = flatlandVariants(settings.trials, settings.seed, flat.part(0), stop);
    results.picture = flatlandPicture(settings.seed);
    results.traps = measureTraps(settings.trials, settings.seed, traps.part(0), stop);
    if (results.flatland.empty() || results.traps.empty()) return {};
    results.seconds = core::secondsSince(start);
    return results;
}

}  // namespace app::lab

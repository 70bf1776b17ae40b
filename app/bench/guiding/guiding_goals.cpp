// See guiding_goals.h.
#include "app/bench/guiding/guiding_goals.h"

#include <cmath>

#include "app/base/read_value.h"

namespace app::guiding {

namespace {

/// What one scene is to gain, or all of them where it has no name; on each device where that has
/// none.
struct Demand {
    const char *scene, *device;
    uint32_t spp;
    double least;
};

constexpr Demand kDemands[] = {
    {"cbox-up", "cpu", 64, 2.6},
    {"cbox-up", "vulkan", 64, 3.2},
    {"door-ajar", "cpu", 64, 4},
    {"door-ajar", "vulkan", 64, 4},
    {"cornell-glossy", "", 64, 2},
    {"kitchen", "", 64, 1.2},
    {"", "", 64, 0.97},
    {"", "", 16, 0.95},
};

std::string textOf(const Demand& d)
{
    const std::string scene = *d.scene == 0 ? "every scene" : d.scene;
    const std::string device = *d.device == 0 ? "every device" : d.device;
    return scene + " on " + device + ", " + std::to_string(d.spp) + " spp";
}

void judge(Goal& goal)
{
    if (!std::isnan(goal.measured.value))
        goal.verdict = goal.measured.value >= goal.least ? Verdict::met : Verdict::missed;
}

/// The least number that falls under the demand.
Goal goalOf(const Results& r, const Demand& demand)
{
    Goal goal;
    goal.text = textOf(demand);
    goal.least = demand.least;
    for (const SceneResult& scene : r.scenes) {
        if (*demand.scene != 0 && scene.name != demand.scene) continue;
        for (const BenchDevice& device : r.devices) {
            if (*demand.device != 0 && device.name != demand.device) continue;
            const Row *plain = findRow(scene, "path", device.name, demand.spp),
                      *guided = findRow(scene, "guided", device.name, demand.spp);
            if (plain == nullptr || guided == nullptr) continue;
            const Ratio gain = efficiency(device, *plain, *guided);
            if (std::isnan(gain.value) || gain.value >= goal.measured.value) continue;
            goal.measured = gain;
            goal.where = scene.name + ", " + device.name;
        }
    }
    judge(goal);
    return goal;
}

/// The first sample after a move, which no learning of its own has helped. Where there was no room
/// for the whole move, nothing was measured that the goal is about.
Goal arrivalGoal(const Results& r)
{
    Goal goal;
    goal.text = "every scene on every device, the first sample after " +
                numberText(kArrivalDegrees) + " degrees, less variance";
    goal.least = 3.5;
    std::string others;
    for (const SceneResult& scene : r.scenes)
        for (const Arrival& arrival : scene.arrivals) {
            if (arrival.degrees < kArrivalDegrees) {
                const std::string other =
                    scene.name + " (" + numberText(arrival.degrees) + " degrees)";
                if (others.find(other) == std::string::npos)
                    others += (others.empty() ? "" : ", ") + other;
                continue;
            }
            const Ratio gain = varianceRatio(arrival);
            if (std::isnan(gain.value) || gain.value >= goal.measured.value) continue;
            goal.measured = gain;
            goal.where = scene.name + ", " + arrival.place();
        }
    if (!others.empty()) goal.text += "; undecided: " + others;
    judge(goal);
    return goal;
}

}  // namespace

const char* verdictName(Verdict verdict)
{
    constexpr const char* kNames[] = {"met", "missed", "not measured"};
    return kNames[static_cast<size_t>(verdict)];
}

std::vector<Goal> goalsOf(const Results& results)
{
    std::vector<Goal> goals{arrivalGoal(results)};
    for (const Demand& demand : kDemands) goals.push_back(goalOf(results, demand));
    return goals;
}

}  // namespace app::guiding

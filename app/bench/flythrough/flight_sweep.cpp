// One parameter of sample reuse after the other, all others as they are. See flight_measure.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <type_traits>

#include "app/base/read_value.h"
#include "app/bench/bench_clock.h"
#include "app/bench/flythrough/flight_measure.h"

namespace app::flight {

namespace {

/// What a picture shows, and what another of the same kind is.
constexpr std::array<std::string_view, 3> kNotSwept{"max-depth", "roulette-depth", "seed"};

/// The type of fields that can be halved and doubled.
template <class T>
constexpr bool kIsAmount = std::is_same_v<T, uint32_t> || std::is_same_v<T, float>;

}  // namespace

std::map<std::string, std::vector<double>> sweptValues(const core::ReuseParams& params, bool quick)
{
    const std::vector<double> factors =
        quick ? std::vector<double>{0.25, 1, 4} : std::vector<double>{0.125, 0.25, 0.5, 1, 2, 4};
    std::map<std::string, std::vector<double>> swept;
    core::ReuseParams::visit(params, [&](const core::Field& field, const auto& member) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (kIsAmount<Member>) {
            if (std::ranges::find(kNotSwept, field.name) != kNotSwept.end()) return;
            if (field.range.low == field.range.high) return;
            std::set<double> values;
            if (field.range.low == 0 && !std::is_integral_v<Member>) values.insert(0);
            for (const double factor : factors) {
                double value = factor * static_cast<double>(member);
                if (std::is_integral_v<Member>) value = std::round(value);
                values.insert(std::clamp(value, field.range.low, field.range.high));
            }
            if (values.size() > 1) swept[field.name] = {values.begin(), values.end()};
        }
    });
    return swept;
}

core::ReuseParams withValue(core::ReuseParams params, const std::string& name, double value)
{
    core::ReuseParams::visit(params, [&](const core::Field& field, auto& member) {
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (kIsAmount<Member>)
            if (name == field.name) member = static_cast<Member>(value);
    });
    return params;
}

void Measurement::sweep()
{
    if (results_.scenes.empty()) return;
    // The strategy whose parameters these are, unless it has been left out.
    const std::string usual(core::enumName(core::ReuseParams{}.reuse));
    const auto found = std::ranges::find(results_.strategies, usual);
    results_.sweptStrategy =
        found != results_.strategies.end() ? usual : results_.strategies.back();
    results_.sweptScene = scene_.name;
    std::set<double> steps{scene_.shownStep};
    if (!o_.quick) steps.insert(steps_.back());
    const auto swept = sweptValues(paramsOf(results_.sweptStrategy), o_.quick);
    for (const auto& [name, values] : swept)
        for (const double step : steps) {
            tools_.progress(scene_.name + ": " + name + ", steps of " + numberText(step));
            if (!sweepParameter(name, values, step)) return;
        }
}

/// False: stopped, and nothing was added.
bool Measurement::sweepParameter(const std::string& name, const std::vector<double>& values,
                                 double step)
{
    const core::ReuseParams usual = paramsOf(results_.sweptStrategy);
    std::map<double, Cell> cells;
    for (uint32_t seed = 0; seed < o_.seeds; ++seed)
        for (const double value : values) {
            std::optional<Landing> landing =
                fly(withValue(usual, name, value), step, results_.longest(), 1);
            if (!landing) return false;
            cells.try_emplace(value, *reference_).first->second.add(std::move(*landing));
        }
    const PictureErrors& unit = scene_.atRest.front().errors;
    for (const auto& [value, cell] : cells) {
        SweepPoint point{name,
                         value,
                         step,
                         withValue(usual, name, value) == usual,
                         median(cell.seconds),
                         cell.errors.errors(),
                         {},
                         {}};
        point.ratio = quotient(point.errors.relMse, unit.relMse);
        point.trimmedRatio = quotient(point.errors.trimmed, unit.trimmed);
        results_.sweeps.push_back(point);
    }
    return true;
}

}  // namespace app::flight

// What `bench manylights` measures: one table of methods, and the settings of each.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/args/args.h"

namespace app::many_lights {

/// Where a method is measured.
enum class Sweep {
    clusters,  // at every number of clusters
    errors,    // at relative errors that are allowed: clusters are as many as that takes
    named,     // at the main number of clusters, where it is asked for by name: takes very long
    rates,     // at fixed rates of rows, and at the least of them over some numbers of clusters
    uniform,   // at the least of these rates, to compare with rows drawn adaptively
    highRate,  // at the cap of the rate
};

/// A method as what it changes in the parameters that all have in common.
struct Method {
    const char* name;
    const char* help;  // what it is, one line
    void (*change)(core::ManyLightsParams&);
    Sweep sweep = Sweep::clusters;
    bool packets = true;  // false: shadow rays one by one
};

/// All of them; the first is `full`, which the others are compared with.
std::span<const Method> methodTable();

/// Whether a method is a curve of time against error.
constexpr bool isCurve(const Method& method)
{
    return method.sweep == Sweep::clusters || method.sweep == Sweep::errors;
}

/// A method at one setting.
struct Case {
    const Method* method = nullptr;
    uint32_t clusters = 0;  // 0: as many as an error takes that is not the common one
    double rowRate = 0;     // NaN: the method's own
    core::ManyLightsParams params;
};

/// Those of one repetition, in the table's order. `full` is always among them.
std::vector<Case> casesOf(const ManyLightsBenchOptions& options);

/// The fixed rates of rows that are measured, ascending.
std::vector<double> fixedRates(bool quick);

/// Throws core::Error (command line) for a name that no method has.
void requireMethods(const std::vector<std::string>& names);

}  // namespace app::many_lights

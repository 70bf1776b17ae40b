// What `bench guiding` measures: one table of variants of guided path tracing.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/args/args.h"

namespace app::guiding {

/// What is measured together: single switches; practical path guiding and its parts; training with
/// and without old records; combinations of the iterations' renders; trees of fixed depth. The
/// last three are chapter 9 of S. Wang, "Efficient Sample Usage in Photo-Realistic Rendering"
/// (2022).
enum class Family { switches, papers, training, combinations, depths };
inline constexpr Family kFamilies[] = {Family::switches, Family::papers, Family::training,
                                       Family::combinations, Family::depths};

/// Its name on the command line, where it stands for all of its variants.
std::string_view familyName(Family family);

/// A variant as what it changes in the parameters that all have in common, when so many samples per
/// pixel are to be taken.
struct Variant {
    const char* name;
    const char* help;                                   // what it is, one sentence
    void (*change)(core::GuidedParams&, uint32_t spp);  // null: path tracing without a guide
    bool isMain = false;                                // in a quick run, too
    Family family = Family::switches;

    /// Whether it is measured with all numbers of samples.
    bool isSwept() const { return isMain || family == Family::training; }
};

/// All of them; the first is `path`, which the others are compared with, the second `guided`.
std::span<const Variant> variantTable();

const Variant& variantNamed(std::string_view name);

/// Those that are measured, in the table's order: those that are named, alone or by their family,
/// else all switches. `path` is always among them.
std::vector<const Variant*> variantsOf(const GuidingBenchOptions& options);

/// The variant's parameters, with a seed and for so many samples per pixel: those of the path
/// tracer, or of the guided one.
core::AnyParams paramsOf(const Variant& variant, const core::GuidedParams& common, uint32_t seed,
                         uint32_t spp);

/// Throws core::Error (command line) for a name that no variant has.
void requireVariants(const std::vector<std::string>& names);

}  // namespace app::guiding

// What `bench guiding` measures: one table of variants of guided path tracing.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "app/args/args.h"

namespace app::guiding {

/// A variant as what it changes in the parameters that all have in common.
struct Variant {
    const char* name;
    const char* help;                     // what it is, one sentence
    void (*change)(core::GuidedParams&);  // null: path tracing without a guide
    bool isMain = false;                  // in a quick run and at all numbers of samples, too
};

/// All of them; the first is `path`, which the others are compared with, the second `guided`.
std::span<const Variant> variantTable();

/// Those that are measured, in the table's order; `path` is always among them.
std::vector<const Variant*> variantsOf(const GuidingBenchOptions& options);

/// The variant's parameters, with a seed: those of the path tracer, or of the guided one.
core::AnyParams paramsOf(const Variant& variant, const core::GuidedParams& common, uint32_t seed);

/// Throws core::Error (command line) for a name that no variant has.
void requireVariants(const std::vector<std::string>& names);

}  // namespace app::guiding

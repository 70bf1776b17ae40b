// How the visibility of a slice is found: by tracing all of it, or some of it and guessing the
// rest.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/params.h"

namespace core::many_lights {

enum class CompletionMethod : uint32_t {
    full,         // trace everything
    matching,     // Boolean: a column is a known column or its complement
    gaussJordan,  // a column is a sum over GF(2) of known columns
    amc,          // a column is a linear combination of known columns
    svt,          // the columns have a small nuclear norm
};

/// Whether a method predicts numbers, which are bits only where they are rounded.
constexpr bool givesNumbers(CompletionMethod method)
{
    return method == CompletionMethod::amc || method == CompletionMethod::svt;
}

/// What becomes of predictions that are numbers.
enum class Coefficients : uint32_t {
    bits,     // rounded to 0 or 1
    clamped,  // to [0, 1]
    real,     // as they are, as in the thesis
};

/// What becomes of a column that agrees with no known one.
enum class OnMismatch : uint32_t {
    full,       // it is traced in full
    recursion,  // only those parts of the slice are traced where the nearest known column disagrees
    repair,     // so are, for every column, the borders of the shadows of the nearest known one
};

/// Row numbers and rates refer to the rows of a slice.
struct CompletionParams {
    CompletionMethod method = CompletionMethod::matching;
    float rowRate = 0.025f;           // alpha, to begin with in every octant
    float rowIncrement = 0.025f;      // of alpha at a failed verification
    float verificationRate = 0.025f;  // beta
    float rowCap = 0.4f;              // of alpha
    uint32_t rowMinimum = 24;         // and as many for verification
    bool rowsByLight = true;
    uint32_t smallSlice = 64;  // up to so many rows everything is traced
    bool adaptiveRows = true;
    bool replacement = false;
    bool joint = true;
    bool disambiguate = true;
    bool dontCare = true;
    uint32_t block = 16;
    OnMismatch onMismatch = OnMismatch::repair;
    float stray = 0.02f;
    float bailOut = 0.9f;
    bool twoPhase = false;
    bool seedConstant = false;
    bool guard = true;
    Coefficients coefficients = Coefficients::real;
    uint32_t svtIterations = 100;
    float residualRate = 0;

    /// As the thesis describes it and its tables were made.
    static CompletionParams authorPreset()
    {
        CompletionParams params;
        params.rowMinimum = 1;
        params.smallSlice = 0;
        params.onMismatch = OnMismatch::full;
        params.replacement = true;
        params.rowsByLight = params.joint = params.disambiguate = params.dontCare = false;
        params.guard = false;
        params.block = 1;
        params.bailOut = 1;
        return params;
    }

    template <class Self, class V> static void visit(Self& p, V&& v);
    friend bool operator==(const CompletionParams&, const CompletionParams&) = default;
};

template <class Self, class V> void CompletionParams::visit(Self& p, V&& v)
{
    v(Field{"completion",
            "how the visibility of clusters of lights is found: trace all of it (full), or trace "
            "a few rows of a column and find a known column that agrees (matching), a sum of known "
            "columns over GF(2) (gauss-jordan), or a linear combination of them (amc); or let few "
            "rows of all "
            "columns decide the matrix of least nuclear norm (svt)",
            {},
            true},
      p.method);
    v(Field{"row-rate", "share of a slice's rows that are traced of every column", {0, 1}, true},
      p.rowRate);
    v(Field{"row-increment", "what a failed verification adds to row-rate. Not of svt", {0, 1}},
      p.rowIncrement);
    v(Field{"verification-rate",
            "share of the rows that verify a match; 0: none is verified. Not of svt",
            {0, 1},
            true},
      p.verificationRate);
    v(Field{"row-cap", "the most that row-rate becomes. Not of svt", {0, 1}}, p.rowCap);
    v(Field{"row-minimum", "rows traced of a column at least, and as many to verify", {1, 1024}},
      p.rowMinimum);
    v(Field{"small-slice", "slices of so few rows are traced in full", {0, 65536}}, p.smallSlice);
    v(Field{"rows-by-light",
            "matching: half of these rows for columns of mean brightness, more for those that may "
            "bring more light, and fewer for those that bring less"},
      p.rowsByLight);
    v(Field{"adaptive-rows", "draw rows at the borders of known shadows more often. Not of svt"},
      p.adaptiveRows);
    v(Field{"replacement",
            "draw rows with replacement, as the thesis does; amc without guard only. Not of svt"},
      p.replacement);
    v(Field{"joint",
            "matching: trace the rows of verification with the others, and match on all of them"},
      p.joint);
    v(Field{"disambiguate", "matching: let rays decide between several matches, not chance"},
      p.disambiguate);
    v(Field{"dont-care", "trace no ray between surfaces that face away from each other"},
      p.dontCare);
    v(Field{"block", "matching: columns that share their sampled rows", {1, 1024}}, p.block);
    v(Field{"on-mismatch",
            "matching: a column without a match is traced in full, where the nearest known column "
            "disagrees (recursion), or, like all but dim columns, there and at the borders of "
            "shadows (repair)"},
      p.onMismatch);
    v(Field{"stray",
            "matching, repair: share of a column's traced rows away from known borders that may be "
            "wrong; with more it is traced in full. Less for bright columns, more for dim ones",
            {0, 1}},
      p.stray);
    v(Field{"bail-out",
            "matching: an octant is traced in full once a larger share than this was traced of the "
            "rows that were not sampled; 1: never",
            {0, 1}},
      p.bailOut);
    v(Field{"two-phase",
            "matching: sample all columns of an octant before any is traced in full",
            {},
            true},
      p.twoPhase);
    v(Field{"seed-constant",
            "count the column that is lit everywhere as known from the beginning. Not of svt"},
      p.seedConstant);
    v(Field{"guard", "gauss-jordan and amc: sample so many rows that what is known cannot explain "
                     "any column"},
      p.guard);
    v(Field{"coefficients",
            "amc and svt: what becomes of predictions: rounded to bits, clamped to 0..1, or real "
            "numbers"},
      p.coefficients);
    v(Field{"svt-iterations", "svt: iterations at most", {1, 10000}}, p.svtIterations);
    v(Field{"residual-rate",
            "share of the rows traced to correct the mean of what is predicted, which makes the "
            "picture unbiased and noisier; 0: none. Not of svt",
            {0, 1}},
      p.residualRate);
}

}  // namespace core::many_lights

template <> struct core::EnumNames<core::many_lights::CompletionMethod> {
    static constexpr std::array<std::string_view, 5> names{"full", "matching", "gauss-jordan",
                                                           "amc", "svt"};
};
template <> struct core::EnumNames<core::many_lights::OnMismatch> {
    static constexpr std::array<std::string_view, 3> names{"full", "recursion", "repair"};
};
template <> struct core::EnumNames<core::many_lights::Coefficients> {
    static constexpr std::array<std::string_view, 3> names{"bits", "clamped", "real"};
};

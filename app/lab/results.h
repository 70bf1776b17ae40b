// What the laboratory measures, as plain data: written by the experiments (table, sweeps,
// moving_lobe, flatland, traps), read by the report, the files and the tests.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace app::lab {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// What subtracts beta (sum of weights - 1) from an estimate: nothing, the truth itself (the best
/// that a control variate of this form can do), or the estimate (self-normalisation, biased).
enum class Beta : uint8_t { none, ideal, own };

/// One method on one function under one change of density, over many independent trials.
struct Cell {
    std::string pair, function, method;  // "D2", "F1", "ra": ids of pairs.h, functions.h, methods.h
    Beta beta = Beta::none;
    uint32_t oldSamples = 0;  // N
    uint32_t newSamples = 0;  // n
    uint32_t candidates = 0;  // k of RIS; 0 where the method draws none
    double c = kUnknown;      // scale of the old density; kUnknown where the method has none
    uint64_t trials = 0;
    double truth = 0, mean = 0;
    double standardError = 0;            // of the mean
    double variance = 0;                 // N Var, as measured
    double varianceError = 0;            // standard error of that, from the fourth moment
    double expectedVariance = kUnknown;  // N Var by quadrature of the formula; kInfinite: provably
    // By quadrature; differs from the truth where the method is biased
    double expectedMean = kUnknown;
    double rays = 0;       // new evaluations of f per trial
    double densities = 0;  // pairs of densities evaluated per trial
    double ess = 0;        // (sum v)^2 / sum v^2, mean over the trials

    /// Standard errors between mean and truth; 0 where the variance is infinite or nothing varied
    /// and nothing differs.
    double z() const
    {
        if (std::isinf(expectedVariance)) return 0;  // nor does the standard error settle
        const double difference = mean - truth;
        // A method without variance is either right to rounding or certainly wrong.
        if (!(standardError > 1e-13 * std::abs(truth)))
            return std::abs(difference) <= 1e-9 * std::abs(truth) ? 0 : kInfinite;
        return difference / standardError;
    }
};

/// One point of a sweep over c (in units of the best, c*) or over k.
struct SweepPoint {
    std::string pair, function;
    double cFactor = 1;
    uint32_t candidates = 0;
    double variance = 0, varianceError = 0;  // N Var
    double expectedVariance = kUnknown;
    double z = 0;
};

/// The constants of a pair as the new lobe moves away from the old one.
struct MajorisationPoint {
    double position = 0;        // centre of the new lobe
    double rejection = 1;       // b = sup p/q
    double augmentation = 1;    // a = sup q/p
    double c = 0;               // c* at n = N
    double growth = 0;          // M*/N at n = N
    double totalVariation = 0;  // R(1)
    double reweightingEss = 0;  // N / integral p^2/q, over N
};

/// One frame of the moving lobe, for one method.
struct LobeFrame {
    double bias = 0;  // (mean - truth) / truth
    double z = 0;
    double varianceRatio = 0;  // to Discard with the same number of new rays
};
struct LobeSequence {
    double step = 0;     // delta per frame, in units of the domain
    std::string method;  // as in the legend: "R-A", "equal weights", ...
    uint32_t candidates = 0;
    bool unbiased = true;
    std::vector<LobeFrame> frames;
    double lateVarianceRatio = 0;  // mean of the frames 30 to 39
    double expectedRatio = kUnknown;
    double largestBias = 0;  // relative, over all frames
};

/// What a history keeps from frame to frame, on the moving lobe.
struct StoreResult {
    double step = 0;               // of the lobe, per frame
    uint32_t kept = 0;             // K, samples in memory
    double cap = 0;                // of the nominal N that they stand for
    double brightness = 0;         // eta of the score u (p + eta f / I)
    double lateVarianceRatio = 0;  // to Discard, mean of the frames 30 to 39
    double largestZ = 0;           // of the bias, over all frames
};

/// One variant of the backprojection in flatland.
struct FlatlandResult {
    std::string variant, meaning;
    bool unbiased = true;
    double truth = 0, mean = 0, bias = 0, z = 0;  // bias relative
    double variance = 0, varianceError = 0;
    double expectedBias = kUnknown, expectedVariance = kUnknown;
    double meanWeight = 0;  // of sum v: 1 where every sample is accounted for
    uint64_t trials = 0;
};

/// An image of flatland by one way to go on: every pixel of every row is an estimate of its own.
struct FlatlandStrip {
    std::string name, meaning;
    bool exact = false;  // by quadrature: one row
    bool unbiased = true;
    std::vector<double> values;  // row by row
    double noise = 0;            // root mean square over the pixels, in units of the mean truth
    double bias = 0;        // the same of what is wrong on average, less what chance makes of it
    bool biasSeen = false;  // beyond chance
};

/// A sample in one pixel of flatland, as one trial of R-A weighted it.
struct FlatlandSample {
    double ground = 0, direction = 0;  // sine of its angle
    bool fresh = false;
    double weight = 1;  // of an old one: the share of it that counts, min(1, p/(c q))
};

/// The line of pixels of the new camera, rendered in several ways.
struct FlatlandPicture {
    double low = 0, width = 0;  // ends of the stretch of ground
    uint32_t pixels = 0, rows = 0;
    std::vector<double> truth;  // per pixel
    std::vector<FlatlandStrip> strips;
    std::vector<FlatlandSample> samples;
};

/// Something that looks right and is not: the wrong way and the right way, measured.
struct Trap {
    std::string name, wrong, right;    // one sentence each
    double wrongBias = 0, wrongZ = 0;  // bias relative
    double rightBias = 0, rightZ = 0;
    double expectedBias = kUnknown;  // of the wrong way
    uint64_t trials = 0;
};

struct LabResults {
    uint64_t trials = 0, seed = 0;
    bool quick = false;
    double seconds = 0;
    std::string version, commit;
    std::vector<Cell> cells;
    std::vector<SweepPoint> overC, overK;
    std::vector<MajorisationPoint> majorisation;
    std::vector<LobeSequence> lobes;
    std::vector<StoreResult> stores;
    std::vector<FlatlandResult> flatland;
    FlatlandPicture picture;
    std::vector<Trap> traps;
};

}  // namespace app::lab

// The picture as a weighted mean of what was rendered between the lessons of a guide, each
// iteration with a better guide than the one before. Above the film: an iteration's own sums are
// the difference of what the film says at its ends. How weights are found:
// core/guiding/combination.h; here the three channels of a pixel count as three pixels that share
// their weight. Crossed weights of single pixels are unbiased with independent samples; with the
// Sobol sampler, whose halves make up for each other, pictures are 2 % too bright (cbox-up, 63
// samples; weights of each pixel's own variance 20 % too dark, those of the picture .0 %). After S.
// Wang, "Efficient Sample Usage in Photo-Realistic Rendering" (2022),
// chapter 9.
#pragma once

#include <array>
#include <vector>

#include "core/guiding/combination.h"
#include "core/image/film.h"
#include "core/methods/guided_params.h"

namespace core {

class IterationPictures {
public:
    /// A new view.
    void begin(const GuidedParams& params);

    /// Whether pictures are anything but the film.
    bool isOn() const;

    /// Whether the film is asked for by note().
    bool takesNotes() const;

    /// The samples of the view, more than `samples`, at which note() is wanted next, so that the
    /// present iteration has two halves; the largest number when it is not.
    uint64_t nextPart(uint64_t samples) const;

    /// The film with everything, between two parts of an iteration or at its end.
    void note(const Estimate& film, bool ends);

    /// With Combine::trial, once in a view: the film as it is counts so much less, sample by
    /// sample, than what is to come.
    void discount(const Estimate& film, double weight);

    /// The picture: the film with everything goes in. Its variance is that of the weighted mean as
    /// if weights were given; its weight is the number of samples that would have this variance if
    /// all iterations were equally noisy.
    Estimate picture(Estimate film) const;

private:
    /// Sums over the samples of a half of an iteration, three channels to a pixel.
    struct Sums {
        std::vector<float> sum, squares;
        uint64_t samples = 0;
    };
    /// With weights from their own samples all of it is in the first half.
    using Iteration = std::array<Sums, 2>;
    class Mixer;

    Estimate discounted(Estimate film) const;
    uint64_t isSecond(uint64_t samplesBefore) const;
    size_t firstInPicture(uint64_t present) const;

    GuidedParams params_;
    double weight_ = 1;  // of a sample of what has ended; Combine::trial
    std::vector<Iteration> ended_;
    Iteration present_;
    std::vector<double> sum_, squares_;  // of the film at the last note
    uint64_t samples_ = 0, first_ = 0;   // there; at the beginning of the iteration
};

}  // namespace core

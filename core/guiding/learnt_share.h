// The share of the BSDF in a leaf, learnt by stochastic descent: T. Mueller, "Path Guiding in
// Production" (SIGGRAPH course, 2019), section 10.5.4, with the optimiser of D. Kingma, J. Ba,
// "Adam: A Method for Stochastic Optimization" (2015). The loss is the Kullback-Leibler divergence
// of the mixture from the light that is scattered on.
#pragma once

#include <cstdint>

namespace core::guiding {

class LearntShare {
public:
    /// One direction: what it brought times f |cos| (positive), the densities of the BSDF and of
    /// the guide there, and that of the mixture it was drawn from.
    void learn(double product, double bsdfPdf, double guidePdf, double pdf);

    /// The share of the BSDF, in (0, 1); a half at first.
    double share() const;

    double theta() const { return theta_; }

private:
    void step(double gradient);

    double theta_ = 0;  // the share is its logistic function
    double first_ = 0, second_ = 0;
    uint32_t steps_ = 0;
    double gradient_ = 0, weight_ = 0;  // of the batch
};

}  // namespace core::guiding

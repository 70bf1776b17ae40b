// What guided renderers do between their passes, whatever traces the paths: when the guide learns,
// which paths it learns from, and what roulette takes for a pixel's value.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string_view>
#include <vector>

#include "core/guiding/convergence.h"
#include "core/guiding/guide.h"
#include "core/guiding/trial.h"
#include "core/image/image.h"
#include "core/methods/guided_params.h"
#include "core/methods/iteration_pictures.h"
#include "core/methods/renderer.h"

namespace core {

class GuideTraining {
public:
    /// Forgets everything: another scene, within this box. Whether its guide pays depends on what
    /// paths cost.
    void beginScene(const guiding::PathCosts& costs, const guiding::GuideBox& box);

    /// A view begins. One that follows on the last one (`start`), with the same parameters, goes on
    /// with the guide; what is known of pixels is gone.
    void begin(const GuidedParams& params, glm::uvec2 size, Start start);

    /// Whether there is a guide at all.
    bool isOn() const { return params_.training > 0; }

    /// Of the paths of the view. One that follows on others, from which the guide has learnt, has
    /// other random numbers than they had: no path may be guided by what was learnt from its own.
    uint32_t seed() const;

    /// PathSettings::guidedRules of the paths that follow on `samples` of the view.
    uint32_t rulesAfter(uint64_t samples) const;

    /// Whether these paths neither follow the guide nor teach it.
    bool isIdleAfter(uint64_t samples) const
    {
        return followers() == shared::kGuideForNone && strideAfter(samples) == 0;
    }

    /// As Renderer::advance, in pieces that end where the guide learns: `render` is what the method
    /// would do without a guide, `learn` is called with the samples that there are, when it is
    /// time; `film` is what has been rendered in all.
    void advance(const Budget& budget, const std::stop_token& stop,
                 const std::function<uint64_t()>& samples,
                 const std::function<void(const Budget&)>& render,
                 const std::function<void(uint64_t)>& learn, const std::function<Estimate()>& film);

    /// The view has had `samples`, of which `parts` have recorded those since the last lesson, and
    /// are empty afterwards; `mean` is the picture.
    void learn(std::span<guiding::PathRecords> parts, uint64_t samples, const Image& mean);

    /// The picture, where it is more than the mean of all samples.
    const IterationPictures& pictures() const { return pictures_; }

    /// What paths are sampled with. Never null.
    std::shared_ptr<const guiding::GuideTables> tables() const { return guide_.tables(); }

    /// Luminance that each pixel is thought to have; empty while nothing is known.
    std::span<const float> estimates() const { return estimates_; }

    const guiding::Guide& guide() const { return guide_; }

    /// What there is to say of the guide, for stats and panel.
    std::vector<StatsDetail> details() const;

private:
    /// Who follows the guide: nobody while it knows too little, then the recorded paths alone,
    /// which tell whether it pays, and then all paths or none.
    enum class State { looksOn, tries, pays, doesNotPay };

    void makeGuide();
    void tryOut(std::span<const guiding::PathRecords> parts,
                std::span<const guiding::Lesson> lessons, double decay);
    double gain() const;
    void beginToPay();
    void beginTrial();
    void tryAgain();
    uint64_t proofOfView() const;
    void decide();
    std::string_view stateName() const;
    uint32_t followers() const;
    uint64_t trainingEnd() const;
    double recordsAfter(uint64_t samples) const;
    uint32_t strideAfter(uint64_t samples) const;
    uint32_t wantedStride(uint64_t samples) const;
    uint64_t nextLesson(uint64_t samples) const;
    uint64_t lastLesson(uint64_t samples) const;

    guiding::PathCosts costs_;
    guiding::Guide guide_;
    guiding::GuideBox box_;
    guiding::Trial trial_;
    guiding::Convergence convergence_;
    State state_ = State::looksOn;
    IterationPictures pictures_;
    GuidedParams params_;
    uint64_t pixels_ = 0;
    uint32_t firstStride_ = 1;
    uint64_t viewSamples_ = 0;  // of the view, up to the last lesson
    uint64_t viewPaths_ = 0;    // that have been recorded of them
    uint32_t views_ = 0;        // before this one, from which there was something to learn
    double allSamples_ = 0;     // of all views, that have been learnt from
    uint32_t lessons_ = 0, lessonsOfTrial_ = 0;
    bool isTried_ = false;   // in this view
    uint64_t rested_ = 0;    // samples of all views since the guide was given up
    uint64_t patience_ = 0;  // samples of them before a view begins with another trial
    double discount_ = 0;    // of what there is of the view, to be told to the pictures; 0: none
    std::vector<float> estimates_;
    double seconds_ = 0;
};

/// How a guide of these parameters knows directions, as kernels are told; 0 without one.
uint32_t guideKindOf(const GuidedParams& params);

/// What connections are weighted against, as kernels are told: shared::kNeeBsdf or kNeeMixture.
uint32_t neeOf(const GuidedParams& params);

/// A cube around the world.
guiding::GuideBox guideBox(const World& world);

}  // namespace core

// All methods on one scene after another. What takes turns within one repetition is the methods,
// forwards and backwards by turns, so that other work on the machine slows all of them alike.
#pragma once

#include "app/bench/bench_run.h"
#include "app/bench/many_lights/many_lights_cases.h"
#include "app/bench/many_lights/many_lights_reference.h"

namespace app::many_lights {

class Measurement {
public:
    Measurement(const ManyLightsBenchOptions& options, const BenchTools& tools);

    /// Everything that can be measured of the scene number `index`, into results(); what a stop
    /// left unfinished is not in them. Throws core::Error.
    void measureScene(size_t index);

    Results& results() { return results_; }
    const Results& results() const { return results_; }

private:
    void load(size_t index);
    bool findSubset();
    bool repeat(uint32_t repetition);
    void takeShots(size_t index);
    bool addShot(const std::string& name, const core::ManyLightsParams& params, bool packets);
    std::string about(const std::string& what) const { return scene_.name + ": " + what; }
    std::filesystem::path referenceFile(const std::string& part) const;

    const ManyLightsBenchOptions& o_;
    BenchTools tools_;
    std::vector<Case> cases_;
    Results results_;

    // Of the present scene.
    std::unique_ptr<LitScene> lit_;
    Subset subset_, shown_;  // shown: of the pictures
    std::optional<LightsReference> reference_, shownReference_;
    /// By case, of the first repetition.
    std::vector<std::vector<glm::vec3>> pictures_;
    SceneResult scene_;
};

}  // namespace app::many_lights

// All strategies of finding light in one scene after another, two pictures of each kind and pair of
// seeds. They take turns within one pair, forwards and backwards by turns, so that other work on
// the machine slows all of them alike.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/bench/bench_run.h"
#include "app/bench/light/light_cases.h"
#include "app/bench/light/light_results.h"
#include "core/methods/renderer.h"

namespace app::light {

class Measurement {
public:
    /// Opens the devices. Throws core::Error when one that was asked for is not there.
    Measurement(const LightBenchOptions& options, const BenchTools& tools);

    /// Everything that can be measured of the scene number `index`, into results(); what a stop
    /// left unfinished is not in them. Throws core::Error.
    void measureScene(size_t index);

    Results& results() { return results_; }
    const Results& results() const { return results_; }

private:
    struct Pair {
        core::Image a, b;
        Sample sample;
    };
    /// A strategy on a device, with a renderer of its own: rebuilding would heat the machine
    /// between the pictures.
    struct Station {
        const Strategy* strategy;
        size_t device;
        std::unique_ptr<core::Renderer> renderer;
        double buildSeconds = 0;
    };
    /// A row while it is measured.
    struct Cell {
        size_t station;
        uint32_t spp;
        std::vector<Pair> pairs;
    };

    void load(size_t index);
    void build();
    bool warmUp();
    bool measureTurn(size_t device, uint32_t spp, uint32_t pair);
    std::optional<Pair> renderPair(const Cell& cell, uint32_t pair);
    std::optional<core::Image> render(const Cell& cell, uint32_t seed, Sample& sample);
    void finishScene();
    Row rowOf(const Cell& cell, const Cell& plain, const std::vector<core::Image>& levels) const;
    core::Image level(size_t pair) const;

    std::string about(const std::string& what) const { return scene_.name + ": " + what; }

    const LightBenchOptions& o_;
    BenchTools tools_;
    std::vector<OpenedDevice> devices_;
    Results results_;

    // Of the present scene.
    std::shared_ptr<const core::World> world_;
    core::View view_;
    std::vector<Station> stations_;
    std::vector<Cell> cells_;
    SceneResult scene_;
};

}  // namespace app::light

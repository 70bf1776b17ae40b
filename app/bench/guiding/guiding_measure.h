// All variants of guided path tracing on one scene after another. They take turns within one seed,
// forwards and backwards by turns, so that other work on the machine slows all of them alike.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/bench/bench_run.h"
#include "app/bench/guiding/guiding_cases.h"
#include "app/bench/guiding/guiding_reference.h"
#include "app/bench/guiding/guiding_results.h"
#include "app/bench/guiding/guiding_window.h"

namespace app::guiding {

class Measurement {
public:
    /// Opens the devices. Throws core::Error when one that was asked for is not there.
    Measurement(const GuidingBenchOptions& options, const BenchTools& tools);

    /// Everything that can be measured of the scene number `index`, into results(); what a stop
    /// left unfinished is not in them. Throws core::Error.
    void measureScene(size_t index);

    Results& results() { return results_; }
    const Results& results() const { return results_; }

private:
    /// A device with a renderer for each of the two methods.
    struct Station {
        Target target;
        std::unique_ptr<core::Renderer> path, guided;
        std::unique_ptr<WindowArrivals> window{};  // of the present scene, where it is measured

        core::Renderer& rendererOf(const Variant& variant) const
        {
            return variant.change == nullptr ? *path : *guided;
        }
    };
    /// A row while it is measured.
    struct Cell {
        const Variant* variant;
        size_t station;
        Row row;
        ErrorSum errors;
        TileSums differences;
    };
    struct Picture {
        core::Image image;
        Sample sample;
    };

    void load(size_t index);
    bool findReference(size_t index);
    bool warmUp();
    void makeCells();
    bool measureTurn(size_t station, uint32_t spp, uint32_t seed);
    bool measureArrivals(uint32_t seed);
    void planWindow(const flight::Flight& way, double degrees);
    std::optional<double> arrive(Station& station, bool window, const Variant& variant,
                                 uint32_t seed);
    std::optional<core::Image> arriveByRenderer(const Station& station, const Variant& variant,
                                                const core::AnyParams& params);
    double relMseOf(const core::Image& picture) const;
    std::optional<Picture> render(const Cell& cell, uint32_t seed);
    void add(Cell& cell, const Picture& picture, const core::Image& plain);
    void finishScene();
    void takeShots();

    std::string about(const std::string& what) const { return scene_.name + ": " + what; }

    const GuidingBenchOptions& o_;
    BenchTools tools_;
    std::vector<Station> stations_;
    Results results_;

    // Of the present scene.
    const SceneOptions* options_ = nullptr;
    std::shared_ptr<const core::World> world_;
    core::View view_, away_;            // the one that is measured, and where the camera comes from
    std::optional<CameraTrack> orbit_;  // from there to here, in the window's loop
    std::optional<GuidingReference> reference_;
    std::vector<Cell> cells_;
    std::vector<std::pair<std::string, core::Image>> shown_;  // by variant
    SceneResult scene_;
};

}  // namespace app::guiding

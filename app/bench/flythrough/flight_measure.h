// All flights through one scene after another. What takes turns within one seed is the strategies,
// so that other work on the machine slows all of them alike.
#pragma once

#include <map>
#include <stop_token>
#include <string>

#include "app/args/args.h"
#include "app/bench/bench_run.h"
#include "app/bench/flythrough/flight_pilot.h"
#include "app/bench/flythrough/flight_reference.h"
#include "app/bench/flythrough/flight_results.h"

namespace app::flight {

class Measurement {
public:
    Measurement(const FlightBenchOptions& options, const BenchTools& tools);

    /// Everything that can be measured of the scene number `index`, into results(). What a stop
    /// left unfinished is not in them. Throws core::Error.
    void measureScene(size_t index);

    /// Flights in the window's own loop through the scene `index`, which was measured last; into
    /// its result. Where they cannot be, it warns and leaves the rest as it is. Throws core::Error
    /// when it is interrupted or the device is lost.
    void measureWindow(size_t index);

    /// Flights with one parameter changed, through the scene that was measured last.
    void sweep();

    Results& results() { return results_; }
    const Results& results() const { return results_; }

private:
    /// Errors and times of one strategy in one place.
    struct Cell {
        ErrorSum errors;
        std::vector<double> seconds;
        double rays = 0;
        core::Image first;  // of the pictures

        explicit Cell(const FlightReference& reference) : errors(reference.mean, reference.variance)
        {}
        void add(Landing landing);
    };
    using Cells = std::map<std::string, Cell>;

    double endsAt(size_t index) const;
    void load(size_t index);
    void chooseSteps();
    bool findReference(size_t index);
    void chooseStrategies();
    bool measureCell(double step, uint32_t frame);
    bool measureDiscard(double step, uint32_t frame, std::vector<double>& seconds);
    void finishScene();
    std::optional<FlightReference> windowReference(size_t index, glm::uvec2 size, bool rests);
    core::Image onSurfaces(const core::Image& light, glm::uvec2 size);
    void flyInWindow(size_t index);
    void takeShots(const Cells& cells);
    void addShot(const std::string& name, uint32_t samples, const Landing& landing);
    std::optional<Landing> fly(core::ReuseParams params, double step, uint32_t frames,
                               uint32_t samples);
    core::ReuseParams paramsOf(const std::string& strategy) const;
    bool sweepParameter(const std::string& name, const std::vector<double>& values, double step);

    const FlightBenchOptions& o_;
    BenchTools tools_;
    Pilot pilot_;
    Results results_;
    uint32_t flights_ = 0;  // so far: each has a seed of its own

    // Of the present scene.
    std::shared_ptr<const core::World> world_;
    std::optional<Flight> flight_;
    std::optional<FlightReference> reference_;
    std::map<uint32_t, Cell> discard_;  // by n; of all flights: it does not depend on them
    std::map<std::pair<double, uint32_t>, double> discardSeconds_;  // by step and frame
    std::vector<double> steps_;                                     // those that fit
    glm::uvec2 corner_{0}, part_{0};  // of the shots, what is shown larger
    SceneResult scene_;
};

/// What flies in the window's own loop: a strategy with so many paths per pixel.
struct Crew {
    core::ReuseStrategy strategy;
    float rays;
};

/// Of the strategies that were measured those that are of interest in a window, Discard first, with
/// `rays` paths per pixel; of Reweighting-Augmentation with fewer, too.
std::vector<Crew> crewsOf(const std::vector<std::string>& strategies, float rays);

/// The parameters of reuse that a sweep changes, with their values: halved and doubled from
/// `params` on, as far as their range allows, ascending. What decides what is seen and not how well
/// is left out.
std::map<std::string, std::vector<double>> sweptValues(const core::ReuseParams& params, bool quick);

/// `params` with one of them changed.
core::ReuseParams withValue(core::ReuseParams params, const std::string& name, double value);

/// An error that is reached in a time.
struct Reached {
    double seconds = 0, error = 0;
};

/// Error over that of Discard in as much time, which is known at some points in order of time;
/// between them and beyond, it is a power of the time. NaN where it cannot be told.
double equalTimeRatio(const std::vector<Reached>& discard, const Reached& reached);

}  // namespace app::flight

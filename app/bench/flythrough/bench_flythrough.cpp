// See bench_flythrough.h.
#include "app/bench/flythrough/bench_flythrough.h"

#include "app/bench/bench_run.h"
#include "app/bench/flythrough/flight_files.h"
#include "app/bench/flythrough/flight_measure.h"
#include "app/bench/flythrough/flight_page.h"
#include "core/base/output_file.h"

namespace app {

namespace {

class FlightBench : public SceneBench {
public:
    FlightBench(const FlightBenchOptions& options, const BenchTools& tools)
        : o_(options), stop_(tools.stop), measurement_(options, tools)
    {}

    void measureScene(size_t index) override
    {
        measurement_.measureScene(index);
        if (o_.window && !stop_.stop_requested()) measurement_.measureWindow(index);
        if (index == 0 && o_.sweeps) measurement_.sweep();
    }

    bool isEmpty() const override { return measurement_.results().scenes.empty(); }

    void write(double seconds, bool interrupted) override
    {
        flight::Results& results = measurement_.results();
        results.seconds = seconds;
        results.interrupted = interrupted;
        core::writeFile(o_.output / "flythrough.json", flight::resultsJson(results));
        core::writeFile(o_.output / "flythrough.csv", flight::rowsCsv(results));
        core::writeFile(o_.output / "index.html", flight::resultsPage(results, o_.output));
    }

    std::string table() const override { return flight::resultsTable(measurement_.results()); }

private:
    const FlightBenchOptions& o_;
    std::stop_token stop_;
    flight::Measurement measurement_;
};

}  // namespace

int benchFlythrough(const FlightBenchOptions& options, std::ostream& out)
{
    return runBench(
        {options.scenes, options.output, "flythrough.json", "index.html", options.quiet},
        [&](const BenchTools& tools) { return std::make_unique<FlightBench>(options, tools); },
        out);
}

}  // namespace app

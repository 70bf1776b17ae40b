// See bench_light.h.
#include "app/bench/light/bench_light.h"

#include "app/bench/bench_run.h"
#include "app/bench/light/light_files.h"
#include "app/bench/light/light_measure.h"
#include "app/bench/light/light_page.h"
#include "core/base/output_file.h"

namespace app {

namespace {

class LightBench : public SceneBench {
public:
    LightBench(const LightBenchOptions& options, const BenchTools& tools)
        : folder_(options.output), measurement_(options, tools)
    {}

    void measureScene(size_t index) override { measurement_.measureScene(index); }

    bool isEmpty() const override { return measurement_.results().scenes.empty(); }

    void write(double seconds, bool interrupted) override
    {
        light::Results& results = measurement_.results();
        results.seconds = seconds;
        results.interrupted = interrupted;
        core::writeFile(folder_ / "light.json", light::resultsJson(results));
        core::writeFile(folder_ / "light.csv", light::rowsCsv(results));
        core::writeFile(folder_ / "light.html", light::resultsPage(results));
    }

    std::string table() const override { return light::resultsTable(measurement_.results()); }

private:
    std::filesystem::path folder_;
    light::Measurement measurement_;
};

}  // namespace

int benchLight(const LightBenchOptions& options, std::ostream& out)
{
    light::requireStrategies(options.strategies);
    return runBench(
        {options.scenes, options.output, "light.json", "light.html", options.quiet},
        [&](const BenchTools& tools) { return std::make_unique<LightBench>(options, tools); }, out);
}

}  // namespace app

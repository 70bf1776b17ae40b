// See bench_many_lights.h.
#include "app/bench/many_lights/bench_many_lights.h"

#include "app/bench/bench_run.h"
#include "app/bench/many_lights/many_lights_files.h"
#include "app/bench/many_lights/many_lights_measure.h"
#include "app/bench/many_lights/many_lights_page.h"
#include "app/version/system.h"
#include "core/base/output_file.h"

namespace app {

namespace {

class ManyLightsBench : public SceneBench {
public:
    ManyLightsBench(const ManyLightsBenchOptions& options, const BenchTools& tools)
        : folder_(options.output), measurement_(options, tools)
    {
        measurement_.results().machine = systemInfo().processor;
    }

    void measureScene(size_t index) override { measurement_.measureScene(index); }

    bool isEmpty() const override { return measurement_.results().scenes.empty(); }

    void write(double seconds, bool interrupted) override
    {
        many_lights::Results& results = measurement_.results();
        results.seconds = seconds;
        results.interrupted = interrupted;
        core::writeFile(folder_ / "manylights.json", many_lights::resultsJson(results));
        core::writeFile(folder_ / "index.html", many_lights::resultsPage(results, folder_));
    }

    std::string table() const override { return many_lights::resultsTable(measurement_.results()); }

private:
    std::filesystem::path folder_;
    many_lights::Measurement measurement_;
};

}  // namespace

int benchManyLights(const ManyLightsBenchOptions& options, std::ostream& out)
{
    many_lights::requireMethods(options.methods);
    return runBench(
        {options.scenes, options.output, "manylights.json", "index.html", options.quiet},
        [&](const BenchTools& tools) { return std::make_unique<ManyLightsBench>(options, tools); },
        out);
}

}  // namespace app

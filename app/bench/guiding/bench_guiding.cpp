// See bench_guiding.h.
#include "app/bench/guiding/bench_guiding.h"

#include "app/bench/bench_run.h"
#include "app/bench/guiding/guiding_files.h"
#include "app/bench/guiding/guiding_measure.h"
#include "app/bench/guiding/guiding_page.h"
#include "core/base/output_file.h"

namespace app {

namespace {

class GuidingBench : public SceneBench {
public:
    GuidingBench(const GuidingBenchOptions& options, const BenchTools& tools)
        : folder_(options.output), measurement_(options, tools)
    {}

    void measureScene(size_t index) override { measurement_.measureScene(index); }

    bool isEmpty() const override { return measurement_.results().scenes.empty(); }

    void write(double seconds, bool interrupted) override
    {
        guiding::Results& results = measurement_.results();
        results.seconds = seconds;
        results.interrupted = interrupted;
        core::writeFile(folder_ / "guiding.json", guiding::resultsJson(results));
        core::writeFile(folder_ / "guiding.csv", guiding::rowsCsv(results));
        core::writeFile(folder_ / "guiding.html", guiding::resultsPage(results, folder_));
    }

    std::string table() const override { return guiding::resultsTable(measurement_.results()); }

private:
    std::filesystem::path folder_;
    guiding::Measurement measurement_;
};

}  // namespace

int benchGuiding(const GuidingBenchOptions& options, std::ostream& out)
{
    guiding::requireVariants(options.variants);
    return runBench(
        {options.scenes, options.output, "guiding.json", "guiding.html", options.quiet},
        [&](const BenchTools& tools) { return std::make_unique<GuidingBench>(options, tools); },
        out);
}

}  // namespace app

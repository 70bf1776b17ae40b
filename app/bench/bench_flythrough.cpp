// Folder first, then scene after scene; files are written after each, so that nothing measured is
// lost. See bench_flythrough.h.
#include "app/bench/bench_flythrough.h"

#include "app/base/interrupt.h"
#include "app/base/log.h"
#include "app/base/new_folder.h"
#include "app/bench/bench_scenes.h"
#include "app/bench/flight_files.h"
#include "app/bench/flight_measure.h"
#include "app/bench/flight_page.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/base/time.h"

namespace app {

namespace {

void writeFiles(const std::filesystem::path& folder, const flight::Results& results)
{
    core::writeFile(folder / "flythrough.json", flight::resultsJson(results));
    core::writeFile(folder / "flythrough.csv", flight::rowsCsv(results));
    core::writeFile(folder / "index.html", flight::resultsPage(results, folder));
}

}  // namespace

int benchFlythrough(const FlightBenchOptions& options, std::ostream& out)
{
    const core::Clock::time_point start = core::Clock::now();
    requireFiles(options.scenes);
    NewFolder folder(options.output, "flythrough.json");
    Interrupt interrupt;  // before anything that starts threads
    interrupt.keepResult(true);
    Log log(options.quiet);
    flight::Measurement measurement(
        options, [&log](const std::string& text) { log.progressText(text); },
        [&log](const std::string& text) { log.warning(text); }, log.callback(), interrupt.token());
    flight::Results& results = measurement.results();
    for (size_t i = 0; i < options.scenes.size() && !interrupt.requested(); ++i) {
        try {
            measurement.measureScene(i);
            if (options.window && !interrupt.requested()) measurement.measureWindow(i);
            if (i == 0 && options.sweeps) measurement.sweep();
        } catch (const core::Error& error) {
            if (!interrupt.requested() || error.code() != core::ExitCode::interrupted) throw;
        }
        results.seconds = core::secondsSince(start);
        results.interrupted = interrupt.requested();
        if (results.scenes.empty()) continue;
        folder.keep();
        writeFiles(options.output, results);
    }
    if (interrupt.requested())
        log.warning(results.scenes.empty() ? "interrupted before the first flights: nothing written"
                                           : "interrupted: what was measured so far is written");
    if (results.scenes.empty()) return static_cast<int>(core::ExitCode::interrupted);
    out << flight::resultsTable(results);
    log.line("the page: " + (options.output / "index.html").string());
    return static_cast<int>(interrupt.requested() ? core::ExitCode::interrupted
                                                  : core::ExitCode::done);
}

}  // namespace app

// Folder first, then scene after scene; files are written after each, so that nothing measured is
// lost. See bench_many_lights.h.
#include "app/bench/bench_many_lights.h"

#include "app/base/interrupt.h"
#include "app/base/log.h"
#include "app/base/new_folder.h"
#include "app/bench/bench_scenes.h"
#include "app/bench/many_lights_files.h"
#include "app/bench/many_lights_measure.h"
#include "app/bench/many_lights_page.h"
#include "app/version/system.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "core/base/time.h"

namespace app {

namespace {

void writeFiles(const std::filesystem::path& folder, const many_lights::Results& results)
{
    core::writeFile(folder / "manylights.json", many_lights::resultsJson(results));
    core::writeFile(folder / "index.html", many_lights::resultsPage(results, folder));
}

}  // namespace

int benchManyLights(const ManyLightsBenchOptions& options, std::ostream& out)
{
    const core::Clock::time_point start = core::Clock::now();
    many_lights::requireMethods(options.methods);
    requireFiles(options.scenes);
    NewFolder folder(options.output, "manylights.json");
    Interrupt interrupt;  // before anything that starts threads
    interrupt.keepResult(true);
    Log log(options.quiet);
    many_lights::Measurement measurement(
        options, [&log](const std::string& text) { log.progressText(text); },
        [&log](const std::string& text) { log.warning(text); }, log.callback(), interrupt.token());
    many_lights::Results& results = measurement.results();
    results.machine = systemInfo().processor;
    for (size_t i = 0; i < options.scenes.size() && !interrupt.requested(); ++i) {
        try {
            measurement.measureScene(i);
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
        log.warning(results.scenes.empty() ? "interrupted before the first method: nothing measured"
                                           : "interrupted: what was measured so far is written");
    if (results.scenes.empty()) return static_cast<int>(core::ExitCode::interrupted);
    out << many_lights::resultsTable(results);
    log.line("the page: " + (options.output / "index.html").string());
    return static_cast<int>(interrupt.requested() ? core::ExitCode::interrupted
                                                  : core::ExitCode::done);
}

}  // namespace app

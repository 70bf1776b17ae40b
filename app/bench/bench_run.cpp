// See bench_run.h.
#include "app/bench/bench_run.h"

#include "app/base/interrupt.h"
#include "app/base/log.h"
#include "app/base/new_folder.h"
#include "app/bench/bench_scenes.h"
#include "core/base/check.h"
#include "core/base/time.h"

namespace app {

int runBench(const BenchOrder& order,
             const std::function<std::unique_ptr<SceneBench>(const BenchTools&)>& make,
             std::ostream& out)
{
    const core::Clock::time_point start = core::Clock::now();
    requireFiles(order.scenes);
    NewFolder folder(order.output, order.result);
    Interrupt interrupt;  // before anything that starts threads
    interrupt.keepResult(true);
    Log log(order.quiet);
    const auto bench = make({[&log](const std::string& text) { log.progressText(text); },
                             [&log](const std::string& text) { log.warning(text); }, log.callback(),
                             interrupt.token()});
    for (size_t i = 0; i < order.scenes.size() && !interrupt.requested(); ++i) {
        try {
            bench->measureScene(i);
        } catch (const core::Error& error) {
            if (!interrupt.requested() || error.code() != core::ExitCode::interrupted) throw;
        }
        if (bench->isEmpty()) continue;
        folder.keep();
        bench->write(core::secondsSince(start), interrupt.requested());
    }
    if (interrupt.requested())
        log.warning(bench->isEmpty() ? "interrupted: nothing measured, nothing written"
                                     : "interrupted: what was measured so far is written");
    if (bench->isEmpty()) return static_cast<int>(core::ExitCode::interrupted);
    out << bench->table();
    log.line("the page: " + (order.output / order.page).string());
    return static_cast<int>(interrupt.requested() ? core::ExitCode::interrupted
                                                  : core::ExitCode::done);
}

}  // namespace app

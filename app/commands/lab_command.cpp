// Folder first, then work, then files. See lab_command.h.
#include "app/commands/lab_command.h"

#include <optional>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/base/interrupt.h"
#include "app/base/json_file.h"
#include "app/base/log.h"
#include "app/base/new_folder.h"
#include "app/base/program_version.h"
#include "app/lab/lab_files.h"
#include "app/lab/run_lab.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;

int labCommand(const LabOptions& options, std::ostream& out)
{
    NewFolder folder(options.output, "lab.json");
    Log log(options.quiet);
    Interrupt interrupt;
    interrupt.keepResult(true);  // a signal ends the work in order, so that the folder is removed
    std::optional<lab::LabResults> results =
        lab::runLab({.trials = options.trials, .seed = options.seed, .quick = options.quick},
                    log.callback(), interrupt.token());
    if (!results) {
        log.warning("interrupted: nothing was written");
        return static_cast<int>(core::ExitCode::interrupted);
    }
    results->version = kVersion;
    results->commit = kCommit;
    folder.keep();
    lab::writeLabFiles(options.output, *results);
    const fs::path page = options.output / "index.html";
    log.line("the report: " + page.string());
    const nlohmann::ordered_json line{{"schema", 1},
                                      {"command", "lab"},
                                      {"page", page.string()},
                                      {"cells", results->cells.size()},
                                      {"seconds", results->seconds}};
    // File names may hold any bytes; JSON is UTF-8.
    out << jsonText(line) << '\n';
    return static_cast<int>(interrupt.requested() ? core::ExitCode::interrupted
                                                  : core::ExitCode::done);
}

}  // namespace app

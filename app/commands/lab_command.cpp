// Folder first, then work, then files. See lab_command.h.
#include "app/commands/lab_command.h"

#include <optional>
#include <system_error>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/base/interrupt.h"
#include "app/base/json_file.h"
#include "app/base/log.h"
#include "app/base/program_version.h"
#include "app/lab/lab_files.h"
#include "app/lab/run_lab.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

namespace app {

namespace {

namespace fs = std::filesystem;

/// A folder that is created with its parents, and removed again unless it is kept.
class NewFolder {
public:
    explicit NewFolder(const fs::path& folder)
    {
        std::error_code error;
        // lexically: "a/b/." and "a/b/" are a/b.
        fs::path path = (folder / ".").lexically_normal().parent_path();
        for (fs::path p = path; !p.empty() && !fs::exists(p, error); p = p.parent_path()) {
            made_.push_back(p);
            if (p == p.parent_path()) break;
        }
        if (!fs::exists(folder, error)) fs::create_directories(path, error);
        if (!fs::is_directory(path, error)) {
            removeFolders();
            throw core::Error(folder.string() + ": " + reason(path));
        }
        try {
            core::requireWritableFile(path / "lab.json");
        } catch (...) {
            removeFolders();
            throw;
        }
    }
    ~NewFolder()
    {
        if (!kept_) removeFolders();
    }
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;

    void keep() { kept_ = true; }

private:
    /// Why `folder` cannot be used; follows its name and a colon.
    static std::string reason(const fs::path& folder)
    {
        std::error_code error;
        for (fs::path path = folder; !path.empty(); path = path.parent_path()) {
            if (fs::exists(path, error) && !fs::is_directory(path, error))
                return (path == folder ? "" : path.string() + " ") + "is a file — name a folder";
            if (path == path.parent_path()) break;
        }
        return "this folder cannot be made — name one in a place that can be written";
    }

    /// Removes empty folders only.
    void removeFolders()
    {
        std::error_code ignored;
        for (const fs::path& path : made_) fs::remove(path, ignored);
    }

    std::vector<fs::path> made_;  // the innermost first
    bool kept_ = false;
};

}  // namespace

int labCommand(const LabOptions& options, std::ostream& out)
{
    NewFolder folder(options.output);
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

// How measurements over several scenes run: folder first, then scene after scene. Files are written
// after each, so that nothing measured is lost.
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <span>
#include <stop_token>
#include <string>

#include "app/args/args.h"
#include "core/base/progress.h"

namespace app {

using Say = std::function<void(const std::string&)>;

/// What a measurement is given to say how far it is, and to hear that it is to end. `progress`
/// takes what is being done, `warn` what a person should know, `loading` the stages of a scene on
/// its way into memory.
struct BenchTools {
    Say progress, warn;
    core::Progress loading;
    std::stop_token stop;
};

class SceneBench {
public:
    virtual ~SceneBench() = default;

    /// Everything that can be measured of the scene number `index`; what a stop left unfinished is
    /// not in the results. Throws core::Error.
    virtual void measureScene(size_t index) = 0;

    /// Nothing measured yet.
    virtual bool isEmpty() const = 0;

    /// All files anew, with what there is after so many seconds.
    virtual void write(double seconds, bool interrupted) = 0;

    /// The results as a short text for the terminal.
    virtual std::string table() const = 0;
};

struct BenchOrder {
    std::span<const SceneOptions> scenes;
    std::filesystem::path output;
    const char *result, *page;  // names of files that are written into `output`
    bool quiet = false;
};

/// Looks at all files and the folder before work begins; `make` comes after that, before anything
/// is loaded. Prints the table on `out` and returns the exit code. Throws core::Error.
int runBench(const BenchOrder& order,
             const std::function<std::unique_ptr<SceneBench>(const BenchTools&)>& make,
             std::ostream& out);

}  // namespace app

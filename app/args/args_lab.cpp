// The command line of the laboratory. See args.h.
#include <memory>
#include <optional>
#include <string>

#include "app/args/args_options.h"
#include "app/lab/run_lab.h"

namespace app {

Subcommand labCommandLine(CLI::App& root)
{
    const auto o = std::make_shared<LabOptions>();
    const auto trials = std::make_shared<std::optional<uint64_t>>();
    CLI::App& app = *root.add_subcommand(
        "lab",
        "the laboratory of sample reuse: every way to go on with samples of an old density under a "
        "new one, measured on functions with known integrals; writes a page to read, CSV and JSON");
    const std::string output = "Output", size = "Measurement";
    addValue(app, output, "-o,--output", o->output,
             "folder for index.html, lab.json and the tables; made when it does not exist")
        ->type_name("DIR");
    app.add_flag("-q,--quiet", o->quiet, "no progress on stderr")->group(output);
    addValue(app, size, "--trials", *trials,
             "independent trials of each cell of the table (one in " +
                 std::to_string(lab::kThinning) + " where augmentation draws more than " +
                 std::to_string(lab::kMuchAugmentation - 1) +
                 " new samples for each old one), default " + std::to_string(lab::kUsualTrials) +
                 "; the other experiments scale with it",
             {100, 1e9});
    app.add_flag("--quick", o->quick,
                 "for a look: " + std::to_string(lab::kQuickTrials) +
                     " trials unless --trials says otherwise")
        ->group(size);
    addValue(app, size, "--seed", o->seed, "of all random numbers; equal seeds, equal numbers");
    app.footer("Example: rekindle lab -o lab\n         rekindle lab -o look --quick");
    return {&app, "rekindle lab -o DIR [options]", [o, trials]() -> Command {
                if (o->output.empty())
                    badCommandLine("lab: -o DIR is missing — see rekindle lab --help");
                o->trials = trials->value_or(o->quick ? lab::kQuickTrials : lab::kUsualTrials);
                return *o;
            }};
}

}  // namespace app

// The command line of the measurement of path guiding. See args.h.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/args/args_options.h"

namespace app {

namespace {

/// What may be left out, and what --quick makes smaller.
struct GuidingArguments : PictureArguments {
    std::optional<uint32_t> seeds, referenceSpp;
    bool sweep = false;
};

constexpr uint32_t kSeeds = 3, kQuickSeeds = 2;
/// Of the paper whose experiments are mirrored.
constexpr uint32_t kSweep[] = {31, 63, 127, 255, 511, 1023};
/// A reference has so many times the samples of the largest picture, and no less than that.
constexpr uint32_t kReferenceFactor = 8, kLeastReference = 1024, kQuickReference = 256;

constexpr PictureHelp kGuidingHelp{
    .output = "folder for guiding.html, guiding.json, guiding.csv, pictures and references; made "
              "when it does not exist, and its references are used again when they still fit",
    .quick = "for a look: path and guided only, fewer seeds, a noisier reference; about two "
             "minutes for a small scene",
    .samples = "samples per pixel of each variant (default 16,64)"};

void addOwnOptions(CLI::App& app, GuidingBenchOptions& o, GuidingArguments& given)
{
    const std::string group = "Measurement";
    addRead(app, group, "--variants", "LIST", o.variants, splitList,
            "variants to measure beside path, by their names on the page, as guided,no-gate, or "
            "families: switches (default; quick: guided alone), papers, training, combinations, "
            "depths");
    app.add_flag("--sweep", given.sweep,
                 "path, guided and the family training also with 31, 63, 127, 255, 511 and 1023 "
                 "samples per pixel")
        ->group(group);
    app.add_flag("--window", o.window,
                 "the first sample after a move in the window's own loop, too: the camera rests, "
                 "orbits for a second and rests again")
        ->group(group);
    addValue(app, group, "--seeds", given.seeds,
             "pictures of each kind, default " + std::to_string(kSeeds) +
                 "; quick: " + std::to_string(kQuickSeeds),
             {1, 1000});
    addValue(app, group, "--reference-spp", given.referenceSpp,
             "samples per pixel of the references, default " + std::to_string(kReferenceFactor) +
                 " times those of the pictures and at least " + std::to_string(kLeastReference) +
                 "; quick: the same and at least " + std::to_string(kQuickReference) +
                 "; odd numbers are rounded up",
             {2, 1e8});
    addValue(app, "Output", "--exposure", o.exposure, "stops that brighten the pictures",
             {-40, 40});
}

GuidingBenchOptions finished(GuidingBenchOptions o, const GuidingArguments& given)
{
    finishPictures("bench guiding", given, {16, 64}, o);
    o.sweep = o.samples;
    if (given.sweep) o.sweep.insert(o.sweep.end(), std::begin(kSweep), std::end(kSweep));
    std::ranges::sort(o.sweep);
    o.sweep.erase(std::unique(o.sweep.begin(), o.sweep.end()), o.sweep.end());
    o.seeds = given.seeds.value_or(o.quick ? kQuickSeeds : kSeeds);
    o.referenceSpp = given.referenceSpp.value_or(
        std::max(o.quick ? kQuickReference : kLeastReference, kReferenceFactor * o.sweep.back()));
    o.referenceSpp += o.referenceSpp % 2;  // of two halves, whose difference is the noise
    return o;
}

}  // namespace

Subcommand guidingCommandLine(CLI::App& bench)
{
    const auto o = std::make_shared<GuidingBenchOptions>();
    const auto given = std::make_shared<GuidingArguments>();
    CLI::App& app = *bench.add_subcommand(
        "guiding",
        "what path guiding gains and costs: error and time of --method guided, as it is and with "
        "each of its switches, beside those of --method path; writes a page to read, CSV and JSON");
    addPictureOptions(app, *o, *given, kGuidingHelp);
    addOwnOptions(app, *o, *given);
    const auto parameters = addParametersOf(app, core::GuidedParams::kMethod, {});
    app.footer("Example: rekindle bench guiding room.glb -o guiding --quick\n"
               "         rekindle bench guiding room.glb hall.glb -o guiding --device cpu");
    return {&app, "rekindle bench guiding SCENE... -o DIR [options]",
            [o, given, parameters]() -> Command {
                o->params = parameters->params().as<core::GuidedParams>();
                return finished(*o, *given);
            }};
}

}  // namespace app

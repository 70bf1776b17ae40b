// The command line of the measurement of light. See args.h.
#include <memory>
#include <optional>
#include <string>

#include "app/args/args_options.h"

namespace app {

namespace {

/// What may be left out, and what --quick makes smaller.
struct LightArguments : PictureArguments {
    std::optional<uint32_t> pairs;
};

constexpr uint32_t kPairs = 3, kQuickPairs = 2;

constexpr PictureHelp kLightHelp{
    .output = "folder for light.html, light.json and light.csv; made when it does not exist",
    .quick = "for a look: power and tree only, two pairs of seeds, 8 samples per pixel; seconds "
             "for a small scene",
    .samples = "samples per pixel of each picture (default 16,64; quick: 8)"};

LightBenchOptions finished(LightBenchOptions o, const LightArguments& given)
{
    finishPictures("bench light", given,
                   o.quick ? std::vector<uint32_t>{8} : std::vector<uint32_t>{16, 64}, o);
    o.pairs = given.pairs.value_or(o.quick ? kQuickPairs : kPairs);
    return o;
}

}  // namespace

Subcommand lightCommandLine(CLI::App& bench)
{
    const auto o = std::make_shared<LightBenchOptions>();
    const auto given = std::make_shared<LightArguments>();
    CLI::App& app = *bench.add_subcommand(
        "light",
        "ways to find light beside each other: emitters chosen by power, or by the tree for the "
        "place, guided paths, surfaces or emitters alone; error and processor time by pairs of "
        "seeds, without a reference; writes a page to read, CSV and JSON");
    addPictureOptions(app, *o, *given, kLightHelp);
    const std::string group = "Measurement";
    addRead(app, group, "--strategies", "LIST", o->strategies, splitList,
            "strategies to measure beside power: tree, guided (default; quick: tree), bsdf, light");
    addValue(app, group, "--pairs", given->pairs,
             "pairs of pictures of each kind, default " + std::to_string(kPairs) +
                 "; quick: " + std::to_string(kQuickPairs),
             {1, 1000});
    // Guided paths, which are measured beside the others, have no clamp.
    const auto parameters =
        addParametersOf(app, core::PathParams::kMethod, {"strategy", "clamp-indirect"});
    app.footer("Example: rekindle bench light room.glb -o light --quick\n"
               "         rekindle bench light room.glb hall.glb -o light --strategies tree,bsdf");
    return {&app, "rekindle bench light SCENE... -o DIR [options]",
            [o, given, parameters]() -> Command {
                o->params = parameters->params().as<core::PathParams>();
                return finished(*o, *given);
            }};
}

}  // namespace app

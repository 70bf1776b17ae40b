// The command line as structs: every option of a method comes from its one description, every
// mistake is reported.
#include "app/args/args.h"

#include <initializer_list>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/base/files.h"
#include "app/base/nearest.h"
#include "app/files/params_json.h"
#include "core/base/check.h"
#include "tests/support/files/text_search.h"

namespace {

using tests::contains;

app::Command parse(std::initializer_list<const char*> arguments)
{
    std::vector<const char*> argv{"rekindle"};
    argv.insert(argv.end(), arguments);
    return app::parseArguments(static_cast<int>(argv.size()), argv.data());
}

/// The message of a refused command line; empty when it was accepted or refused with another exit
/// code.
std::string refusal(std::initializer_list<const char*> arguments)
{
    try {
        parse(arguments);
    } catch (const core::Error& error) {
        if (error.code() == core::ExitCode::commandLine) return error.what();
    }
    return {};
}

TEST(Args, EveryParameterOfTheMethodIsAnOption)
{
    // Values that differ from every default, as text of each member's own kind.
    core::PathParams expected;
    expected.maxDepth = 17;
    expected.rouletteDepth = 5;
    expected.seed = 4294967295u;
    expected.sampler = core::SamplerKind::independent;
    expected.strategy = core::Strategy::light;
    expected.clampIndirect = 2.5f;
    expected.kernel = core::Kernel::megakernel;
    expected.sky = core::SkySampling::regions;
    std::vector<std::string> words{"rekindle", "render", "a.gltf", "-o", "a.exr"};
    const auto json = app::paramsJson(expected);
    for (const auto& [name, value] : json.items()) {
        EXPECT_NE(value, app::paramsJson(core::PathParams{})[name]) << name << " is at its default";
        words.push_back("--" + name);
        words.push_back(value.is_string() ? value.get<std::string>() : value.dump());
    }
    std::vector<const char*> argv;
    for (const std::string& word : words) argv.push_back(word.c_str());
    const app::Command command = app::parseArguments(static_cast<int>(argv.size()), argv.data());
    ASSERT_TRUE(std::holds_alternative<app::RenderOptions>(command));
    EXPECT_EQ(std::get<app::RenderOptions>(command).params, core::AnyParams(expected));
    EXPECT_EQ(app::biasedParams(expected), std::vector<std::string>{"clamp-indirect"});
    EXPECT_TRUE(app::biasedParams(core::PathParams{}).empty());
    EXPECT_TRUE(app::biasedParams(core::GuidedParams{}).empty());
    EXPECT_TRUE(app::biasedParams(core::GuidedParams{.combine = core::Combine::samples}).empty());
    EXPECT_EQ(app::biasedParams(core::GuidedParams{.combine = core::Combine::ess}),
              std::vector<std::string>{"combine"});
}

TEST(Args, HelpShowsEveryParameterWithItsRangeAndBias)
{
    const std::string text = std::get<app::Printed>(parse({"render", "--help"})).text;
    std::string words;  // without the line breaks, which depend on the widths
    std::istringstream stream(text);
    for (std::string word; stream >> word;) words += word + ' ';
    const core::PathParams params;
    core::PathParams::visit(params, [&text](const core::Field& field, const auto&) {
        EXPECT_TRUE(contains(text, std::string("--") + field.name)) << field.name;
    });
    EXPECT_TRUE(contains(text, "mis|bsdf|light"));
    EXPECT_TRUE(contains(words, "(1 to 4096, default 2)"));
    EXPECT_TRUE(contains(words, "(0.0001 to 1, default 0.005)")) << "as they are written, not as "
                                                                    "doubles that floats are";
    EXPECT_TRUE(contains(text, "[biased]"));
    EXPECT_TRUE(contains(text, "Example: "));
}

TEST(Args, HelpFitsInAHundredColumns)
{
    for (const auto& arguments : {std::initializer_list<const char*>{"--help"},
                                  {"view", "--help"},
                                  {"render", "--help"},
                                  {"compare", "-h"},
                                  {"info", "--help"},
                                  {"devices", "--help"},
                                  {"lab", "--help"},
                                  {"bench", "--help"},
                                  {"bench", "throughput", "--help"},
                                  {"bench", "flythrough", "--help"},
                                  {"bench", "manylights", "--help"},
                                  {"bench", "guiding", "--help"},
                                  {"bench", "light", "--help"}}) {
        const std::string text = std::get<app::Printed>(parse(arguments)).text;
        EXPECT_TRUE(contains(text, "Usage: rekindle"));
        EXPECT_TRUE(contains(text, "Example: rekindle"));
        size_t start = 0;
        for (size_t end; (end = text.find('\n', start)) != std::string::npos; start = end + 1)
            EXPECT_LE(end - start, 100u) << text.substr(start, end - start);
    }
}

TEST(Args, ValuesOutOfRangeAreRefusedWithTheRange)
{
    const auto withOption = [](const char* name, const char* value) {
        return refusal({"render", "a.gltf", "-o", "a.exr", name, value});
    };
    struct Case {
        const char *name, *value, *expected;
    };
    for (const Case& c : {Case{"--spp", "0", "from 1 to"},
                          {"--spp", "-4", "from 1 to"},
                          {"--spp", "4.5", "whole number"},
                          {"--spp", "", "whole number"},
                          {"--spp", "18446744073709551616", "from 1 to"},
                          {"--size", "0x10", "WIDTHxHEIGHT"},
                          {"--size", "10x0", "WIDTHxHEIGHT"},
                          {"--size", "10", "WIDTHxHEIGHT"},
                          {"--size", "-5x7", "WIDTHxHEIGHT"},
                          {"--size", "7x99999", "65536"},
                          {"--time", "0", "from"},
                          {"--time", "inf", "from"},
                          {"--time", "nan", "from"},
                          {"--width", "0", "from 1 to"},
                          {"--seed", "-1", "from 0 to 4294967295"},
                          {"--max-depth", "4097", "0 to 4096"},
                          {"--roulette-depth", "0", "1 to 4096"},
                          {"--sampler", "sobool", "did you mean sobol"},
                          {"--device", "gpu", "vulkan, cpu"},
                          {"--method", "magic", "is not one of path"},
                          {"--frames", "5-3", "FIRST-LAST"},
                          {"--frames", "a-b", "FIRST-LAST"},
                          {"--aov", "dept", "did you mean depth"},
                          {"--exposure", "1e9", "-40 to 40"},
                          {"--max-file-mb", "0", "from 1 to"}}) {
        const std::string message = withOption(c.name, c.value);
        EXPECT_TRUE(contains(message, c.expected))
            << c.name << ' ' << c.value << " said: " << message;
        EXPECT_TRUE(contains(message, c.name)) << message;
        EXPECT_FALSE(contains(message, "\n")) << message;
    }
}

TEST(Args, MistypedNamesGetTheNearestOne)
{
    EXPECT_TRUE(contains(refusal({"render", "--wdith", "64", "a.gltf"}), "did you mean --width?"));
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "--stat=x", "-o", "a.exr"}),
                         "did you mean --stats?"));
    EXPECT_TRUE(contains(refusal({"info", "a.gltf", "--jsn"}), "did you mean --json?"));
    EXPECT_TRUE(contains(refusal({"rendr", "a.gltf", "-o", "a.exr"}), "did you mean render?"));
    EXPECT_TRUE(contains(refusal({"bench", "thruoghput", "a.gltf"}), "did you mean throughput?"));
    EXPECT_TRUE(contains(refusal({"bench", "flytrough", "a.gltf"}), "did you mean flythrough?"));
    EXPECT_TRUE(contains(refusal({"bench", "manylight", "a.gltf"}), "did you mean manylights?"));
    EXPECT_TRUE(contains(refusal({"bench", "guidng", "a.gltf"}), "did you mean guiding?"));
    EXPECT_TRUE(contains(refusal({"bench", "ligth", "a.gltf"}), "did you mean light?"));
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "--zzzzzzzz"}), "unknown option --zzzzzzzz"));
    EXPECT_FALSE(contains(refusal({"render", "a.gltf", "--zzzzzzzz"}), "did you mean"));
}

TEST(Args, OptionsThatDoNotGoTogether)
{
    EXPECT_TRUE(contains(refusal({"render", "a.gltf"}), "-o FILE"));
    EXPECT_TRUE(contains(refusal({"render", "-o", "a.exr"}), "scene is missing"));
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "-o", "a.jpg"}), ".exr or .png"));
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "-o", "a.png", "--aov", "depth"}), "EXR"));
    EXPECT_TRUE(
        contains(refusal({"render", "a.gltf", "-o", "a.exr", "--until-rmse", "1"}), "--reference"));
    EXPECT_TRUE(
        contains(refusal({"render", "a.gltf", "-o", "a.exr", "--path", "p.json"}), "--frames"));
    EXPECT_TRUE(contains(
        refusal({"render", "a.gltf", "-o", "a.exr", "--device", "cpu", "--validation"}), "vulkan"));
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "-o", "a.exr", "--budget-ms", "5"}),
                         "give --frames"));
    for (const auto& [name, other] : {std::pair{"--budget-ms", "--spp"},
                                      {"--budget-ms", "--time"},
                                      {"--budget-rays", "--spp"},
                                      {"--budget-rays", "--time"},
                                      {"--budget-rays", "--budget-ms"}}) {
        const std::string message =
            refusal({"render", "a.gltf", "-o", "%d.exr", "--frames", "0-1", name, "5", other, "2"});
        EXPECT_TRUE(contains(message, name) && contains(message, other)) << message;
    }
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "-o", "a.exr", "--fps", "30"}), "--frames"));
    EXPECT_TRUE(contains(refusal({"render", "a.gltf", "-o", "a.exr", "--aov", "depth,maps"}),
                         "--method path has none"));
    EXPECT_NO_THROW(
        parse({"render", "a.gltf", "-o", "a.exr", "--aov", "maps", "--method", "reuse"}));
    EXPECT_TRUE(contains(refusal({"compare", "a.exr"}), "reference is missing"));
    EXPECT_TRUE(
        contains(refusal({"compare", "a.exr", "b.exr", "c.exr"}), "unexpected argument 'c.exr'"));
    EXPECT_TRUE(contains(refusal({"info"}), "scene is missing"));
    EXPECT_TRUE(contains(refusal({"bench"}), "throughput"));
    EXPECT_TRUE(contains(refusal({"bench", "throughput"}), "scene is missing"));
    EXPECT_TRUE(contains(refusal({"bench", "throughput", "a.gltf", "--instances", "kept"}),
                         "--instances kept"));
    EXPECT_NO_THROW(parse({"bench", "throughput", "a.gltf", "--instances", "flat"}));
}

TEST(Args, GuidingIsMeasuredAsItIsAsked)
{
    const auto guiding = [](std::initializer_list<const char*> more) {
        std::vector<const char*> arguments{"bench", "guiding", "a.gltf", "b.gltf", "-o", "x"};
        arguments.insert(arguments.end(), more);
        arguments.insert(arguments.begin(), "rekindle");
        return std::get<app::GuidingBenchOptions>(
            app::parseArguments(static_cast<int>(arguments.size()), arguments.data()));
    };
    const app::GuidingBenchOptions usual = guiding({});
    EXPECT_EQ(usual.scenes.size(), 2u);
    EXPECT_EQ(usual.devices, app::MeasuredDevices::both);
    EXPECT_EQ(usual.samples, (std::vector<uint32_t>{16, 64}));
    EXPECT_EQ(usual.sweep, usual.samples);
    EXPECT_EQ(usual.seeds, 3u);
    EXPECT_EQ(usual.referenceSpp, 1024u);
    EXPECT_EQ(usual.params, core::GuidedParams{});
    const app::GuidingBenchOptions other =
        guiding({"--sweep", "--samples", "63,8,63", "--gate", "2", "--device", "vulkan"});
    EXPECT_EQ(other.samples, (std::vector<uint32_t>{8, 63}));
    EXPECT_EQ(other.sweep, (std::vector<uint32_t>{8, 31, 63, 127, 255, 511, 1023}));
    EXPECT_EQ(other.referenceSpp, 8 * 1023u);
    EXPECT_EQ(other.params.gate, 2);
    EXPECT_EQ(other.devices, app::MeasuredDevices::vulkan);
    EXPECT_LT(guiding({"--quick"}).referenceSpp, 1024u);
    EXPECT_EQ(guiding({"--reference-spp", "33"}).referenceSpp, 34u);  // of two halves
    EXPECT_LT(guiding({"--quick"}).seeds, 3u);
}

TEST(Args, LightIsMeasuredAsItIsAsked)
{
    const auto light = [](std::initializer_list<const char*> more) {
        std::vector<const char*> arguments{"rekindle", "bench", "light", "a.gltf",
                                           "b.gltf",   "-o",    "x"};
        arguments.insert(arguments.end(), more);
        return std::get<app::LightBenchOptions>(
            app::parseArguments(static_cast<int>(arguments.size()), arguments.data()));
    };
    const app::LightBenchOptions usual = light({});
    EXPECT_EQ(usual.scenes.size(), 2u);
    EXPECT_EQ(usual.devices, app::MeasuredDevices::both);
    EXPECT_EQ(usual.samples, (std::vector<uint32_t>{16, 64}));
    EXPECT_EQ(usual.pairs, 3u);
    EXPECT_TRUE(usual.strategies.empty());
    EXPECT_EQ(usual.params, core::PathParams{});
    const app::LightBenchOptions quick = light({"--quick"});
    EXPECT_EQ(quick.samples, (std::vector<uint32_t>{8}));
    EXPECT_EQ(quick.pairs, 2u);
    const app::LightBenchOptions other =
        light({"--quick", "--samples", "32,4,32", "--pairs", "5", "--strategies", "tree,bsdf",
               "--max-depth", "3", "--device", "vulkan"});
    EXPECT_EQ(other.samples, (std::vector<uint32_t>{4, 32}));
    EXPECT_EQ(other.pairs, 5u);
    EXPECT_EQ(other.strategies, (std::vector<std::string>{"tree", "bsdf"}));
    EXPECT_EQ(other.params.maxDepth, 3u);
    EXPECT_EQ(other.devices, app::MeasuredDevices::vulkan);
    // Guided paths have no clamp: with one, the strategies would not estimate the same.
    EXPECT_TRUE(contains(refusal({"bench", "light", "a.gltf", "-o", "x", "--clamp-indirect", "1"}),
                         "unknown option"));
}

app::ViewOptions view(std::initializer_list<const char*> arguments)
{
    const app::Command command = parse(arguments);
    EXPECT_TRUE(std::holds_alternative<app::ViewOptions>(command));
    return std::get<app::ViewOptions>(command);
}

TEST(Args, NoCommandIsTheWindow)
{
    EXPECT_TRUE(view({}).scene.file.empty());
    EXPECT_TRUE(view({"view"}).scene.file.empty());
    EXPECT_FALSE(view({}).paramsGiven);
    for (const app::ViewOptions& o :
         {view({"room.glb", "--strict", "--device", "cpu", "--seed", "1", "--size", "800x600",
                "--no-settings"}),
          view({"view", "--strict", "--seed=1", "room.glb", "--no-settings", "--size", "800x600",
                "--device", "cpu"})}) {
        EXPECT_EQ(o.scene.file, "room.glb");
        EXPECT_TRUE(o.scene.load.strict);
        EXPECT_EQ(o.device, app::DeviceKind::cpu);
        EXPECT_TRUE(o.paramsGiven);  // though it is the default
        EXPECT_EQ(o.params, core::AnyParams());
        EXPECT_EQ(o.size, glm::uvec2(800, 600));
        EXPECT_TRUE(o.noSettings);
    }
    const app::ViewOptions o =
        view({"view", "r.gltf", "--camera", "door", "--path", "p.json", "--script", "s.json",
              "--ui-scale", "1.5", "--max-depth", "3", "--device-index", "1", "--validation"});
    EXPECT_EQ(o.camera, "door");
    EXPECT_EQ(o.path, "p.json");
    EXPECT_EQ(o.script, "s.json");
    EXPECT_EQ(o.uiScale, 1.5f);
    EXPECT_EQ(o.params.as<core::PathParams>().maxDepth, 3u);
    EXPECT_EQ(o.deviceIndex, 1);
    EXPECT_TRUE(o.validation);
    EXPECT_FALSE(o.noCache);
    EXPECT_TRUE(view({"r.gltf", "--no-cache"}).noCache);
    EXPECT_EQ(view({"--replay", "a.exr"}).replay, "a.exr");
    EXPECT_EQ(view({"view", "--replay", "a.PNG"}).replay, "a.PNG");
}

TEST(Args, OptionsOfTheWindowThatMakeNoSense)
{
    for (const char* picture : {"a.exr", "b.png", "C.EXR"})
        EXPECT_TRUE(contains(refusal({"view", picture}), "--replay")) << picture;
    EXPECT_TRUE(contains(refusal({"a.exr"}), "--replay a.exr"));
    EXPECT_TRUE(contains(refusal({"view", "--replay", "a.glb"}), ".exr or .png"));
    EXPECT_TRUE(contains(refusal({"a.glb", "--replay", "a.exr"}), "leave out a.glb"));
    EXPECT_TRUE(contains(refusal({"view", "--replay", "a.exr", "--camera", "0"}), "--camera"));
    EXPECT_TRUE(contains(refusal({"view", "--replay", "a.exr", "--seed", "1"}), "parameters"));
    EXPECT_TRUE(contains(refusal({"view", "--size", "63x100"}), "64 to 16384"));
    EXPECT_TRUE(contains(refusal({"view", "--size", "100x20000"}), "64 to 16384"));
    EXPECT_TRUE(contains(refusal({"view", "--ui-scale", "5"}), "0 to 4"));
    EXPECT_TRUE(contains(refusal({"view", "--scirpt", "a"}), "did you mean --script?"));
    EXPECT_TRUE(contains(refusal({"--no-setings"}), "did you mean --no-settings?"));
    EXPECT_TRUE(contains(refusal({"view", "a.glb", "b.glb"}), "unexpected argument 'b.glb'"));
}

TEST(Args, WhatStandsBeforeACommandIsRefused)
{
    EXPECT_TRUE(contains(refusal({"--device", "cpu", "render", "a.gltf", "-o", "a.exr"}),
                         "--device stands before the command — put it behind render"));
    EXPECT_TRUE(contains(refusal({"--strict", "info", "a.gltf"}), "--strict"));
    EXPECT_TRUE(contains(refusal({"a.gltf", "render", "-o", "a.exr"}), "a.gltf stands before"));
    EXPECT_TRUE(contains(refusal({"--seed", "2", "bench", "throughput", "a.gltf"}), "throughput"));
}

TEST(Args, HelpWinsOverMistakes)
{
    EXPECT_TRUE(std::holds_alternative<app::Printed>(parse({"render", "--spp", "0", "--help"})));
    EXPECT_TRUE(std::holds_alternative<app::Printed>(parse({"--version"})));
    const std::string program = std::get<app::Printed>(parse({"--help"})).text;
    EXPECT_FALSE(contains(program, "--max-depth"));  // those are in the help of view
    EXPECT_TRUE(contains(program, "window"));
}

TEST(Nearest, DistanceCountsSlips)
{
    EXPECT_EQ(app::editDistance("", ""), 0u);
    EXPECT_EQ(app::editDistance("abc", ""), 3u);
    EXPECT_EQ(app::editDistance("abc", "abc"), 0u);
    EXPECT_EQ(app::editDistance("abc", "acb"), 1u);   // neighbours swapped
    EXPECT_EQ(app::editDistance("abc", "abxc"), 1u);  // one too many
    EXPECT_EQ(app::editDistance("kitten", "sitting"), 3u);
    const std::vector<std::string> names{"--width", "--size"};
    EXPECT_EQ(app::nearestName("--wdith", names), "--width");
    EXPECT_EQ(app::nearestName("--something", names), "");
}

TEST(Files, NumbersInNames)
{
    EXPECT_EQ(app::numbered("out/f-%04d.png", 7), "out/f-0007.png");
    EXPECT_EQ(app::numbered("f%d.png", 12), "f12.png");
    EXPECT_EQ(app::numbered("f%02d.png", 123), "f123.png");
    EXPECT_TRUE(app::isNumbered("f%04d.exr"));
    for (const char* name : {"f.exr", "f%s.exr", "f%d%d.exr", "f%04x.exr", "%04d/f.exr", "f%"})
        EXPECT_FALSE(app::isNumbered(name)) << name;
}

}  // namespace

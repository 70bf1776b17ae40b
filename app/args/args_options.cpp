// Texts of the help, and options that several commands have. See args_options.h.
#include "app/args/args_options.h"

#include <sstream>

#include "core/base/check.h"

namespace app {

static constexpr size_t kHelpWidth = 100, kNameColumn = 34;

/// Breaks `text` into lines at spaces, each led by `indent` spaces except for the first.
static std::string wrap(const std::string& text, size_t indent)
{
    std::istringstream words(text);
    std::string result, word;
    size_t column = indent;
    while (words >> word) {
        if (column > indent && column + 1 + word.size() > kHelpWidth) {
            result += '\n' + std::string(indent, ' ');
            column = indent;
        } else if (column > indent) {
            result += ' ';
            ++column;
        }
        result += word;
        column += word.size();
    }
    return result;
}

/// One entry: the name on the left, wrapped help on the right (below a name that is too long).
static std::string entry(const std::string& name, const std::string& help)
{
    std::string line = "  " + name;
    if (line.size() + 2 > kNameColumn)
        line += '\n' + std::string(kNameColumn, ' ');
    else
        line.resize(kNameColumn, ' ');
    return line + wrap(help, kNameColumn) + '\n';
}

static std::string groupText(const CLI::App& app, const std::string& group)
{
    std::string text;
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_group() != group) continue;
        std::string name =
            option->get_positional() ? option->get_name(true) : option->get_name(false, true);
        if (!option->get_positional() && option->get_expected_min() > 0)
            name += ' ' + option->get_type_name();
        text += entry(name, option->get_description());
    }
    return text.empty() ? text : '\n' + group + ":\n" + text;
}

std::string helpText(const CLI::App& app, const std::string& usage)
{
    std::string text = "Usage: " + usage + "\n\n" + wrap(app.get_description(), 0) + '\n';
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    if (!commands.empty()) text += "\nCommands (each has its own --help):\n";
    for (const CLI::App* command : commands)
        text += entry(command->get_name(), command->get_description());
    for (const std::string& group : app.get_groups())
        if (!group.empty()) text += groupText(app, group);
    if (!app.get_footer().empty()) text += '\n' + app.get_footer() + '\n';
    return text;
}

std::vector<std::string> optionNames(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options()) {
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
        for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    }
    return names;
}

[[noreturn]] void badCommandLine(const std::string& message)
{
    throw core::Error(message, core::ExitCode::commandLine);
}

void addSceneFiles(CLI::App& app, std::vector<std::filesystem::path>& files)
{
    app.add_option(
           "SCENE",
           [&files](const CLI::results_t& results) {
               files.assign(results.begin(), results.end());
               return true;
           },
           "glTF 2.0 files, .gltf or .glb")
        ->group("Arguments")
        ->expected(1, 1000)
        ->allow_extra_args()
        ->type_name("FILE");
}

std::vector<SceneOptions> measuredScenes(const std::string& command, const SceneOptions& loading,
                                         const std::vector<std::filesystem::path>& files,
                                         const std::filesystem::path& output)
{
    const std::string help = " is missing — see rekindle " + command + " --help";
    if (files.empty()) badCommandLine(command + ": the scene" + help);
    if (output.empty()) badCommandLine(command + ": -o DIR" + help);
    std::vector<SceneOptions> scenes;
    for (const std::filesystem::path& file : files) {
        scenes.push_back(loading);
        scenes.back().file = file;
    }
    return scenes;
}

std::vector<std::string> splitList(const std::string& text)
{
    std::vector<std::string> items;
    std::istringstream stream(text);
    for (std::string item; std::getline(stream, item, ',');)
        if (!item.empty()) items.push_back(item);
    return items;
}

void addNoCache(CLI::App& app, const std::string& group, bool& noCache)
{
    app.add_flag(
           "--no-cache", noCache,
           "neither read nor keep compiled kernels and hierarchies of scenes, which otherwise "
           "wait in ~/.cache/rekindle for the next run")
        ->group(group);
}

void addSceneOptions(CLI::App& app, SceneOptions& scene)
{
    addValue(app, "Arguments", "SCENE", scene.file, "glTF 2.0 file, .gltf or .glb");
    addLoadingOptions(app, scene);
}

void addLoadingOptions(CLI::App& app, SceneOptions& scene)
{
    const std::string group = "Loading";
    addValue(app, group, "--at", scene.at, "instant of the scene's animation, in seconds",
             {0, 1e9});
    app.add_flag("--strict", scene.load.strict, "refuse a scene with any warning")->group(group);
    app.add_flag("--allow-outside", scene.load.allowOutside,
                 "let the scene read files outside its own folder")
        ->group(group);
    app.add_flag("--ignore-required", scene.load.ignoreRequired,
                 "try although the scene requires an unknown extension")
        ->group(group);
    addValue(app, group, "--environment", scene.load.environment,
             "what is around the scene instead of its own environment and sun: the file of a "
             "panorama (.exr, .hdr, .png, .jpg), plain (a grey sky), none, own, or auto (default): "
             "its own, and a plain sky where nothing in the scene shines")
        ->type_name("WHAT");
    addValue(app, group, "--instances", scene.load.instancing,
             "meshes that are used often: stored once (kept), as triangles of their own (flat), or "
             "whichever suits the scene");
    addValue(app, group, "--max-file-mb", scene.load.maxFileMb, "largest file to read, in MiB",
             {1, 1 << 20});
    addValue(app, group, "--max-memory-mb", scene.load.maxMemoryMb,
             "largest scene in memory, in MiB, estimated before it is read", {1, 1 << 24});
    addValue(app, group, "--max-texture-size", scene.load.maxTextureSize,
             "widest and highest image to decode, in pixels", {1, 65536});
}

/// "640x360" to a size. Throws as CLI11 does for a wrong value.
glm::uvec2 readSizeOf(const char* option, const std::string& text)
{
    constexpr core::Range kPixels{1, 65536};
    const size_t x = text.find_first_of("xX");
    glm::uvec2 size{};
    if (x == std::string::npos || !readValue(text.substr(0, x), kPixels, size.x).empty() ||
        !readValue(text.substr(x + 1), kPixels, size.y).empty())
        throw CLI::ValidationError(
            option, "'" + text + "' is not WIDTHxHEIGHT with both from 1 to 65536, as in 640x360");
    return size;
}

glm::uvec2 readSize(const std::string& text)
{
    return readSizeOf("--size", text);
}

}  // namespace app

// Options of the command line made from plain members: one text for reading, range check and help;
// and what several commands have in common.
// Only args*.cpp include this.
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/args/args.h"
#include "app/base/read_value.h"
#include "core/base/params.h"

namespace app {

template <class T> std::string typeName()
{
    if constexpr (IsOptional<T>::value)
        return typeName<typename T::value_type>();
    else if constexpr (std::is_enum_v<T>) {
        const auto names = core::enumNames<T>();
        std::vector<std::string> known(names.begin(), names.end());
        return CLI::detail::join(known, "|");
    } else if constexpr (std::is_same_v<T, bool>)
        return "true|false";
    else if constexpr (std::is_integral_v<T>)
        return "N";
    else if constexpr (std::is_floating_point_v<T>)
        return "X";
    else if constexpr (std::is_same_v<T, std::filesystem::path>)
        return "FILE";
    else
        return "TEXT";
}

/// The current value as the help shows it; empty when there is nothing worth showing.
template <class T> std::string defaultText(const T& value)
{
    if constexpr (IsOptional<T>::value)
        return value ? defaultText(*value) : std::string();
    else if constexpr (std::is_enum_v<T>)
        return std::string(core::enumName(value));
    else if constexpr (std::is_same_v<T, bool>)
        return value ? "true" : "false";
    else if constexpr (std::is_arithmetic_v<T>)
        return numberText(static_cast<double>(value));
    else
        return {};
}

/// " (0 to 8, default 2)": the range and the default of a value; empty when there is neither.
template <class T> std::string factsText(const T& value, core::Range range)
{
    std::string facts;
    if (range.low != range.high) facts = numberText(range.low) + " to " + numberText(range.high);
    const std::string shown = defaultText(value);
    if (!shown.empty()) facts += (facts.empty() ? "default " : ", default ") + shown;
    return facts.empty() ? facts : " (" + facts + ")";
}

/// Adds an option with one value, read into `member` (which holds the default). `name` as CLI11
/// takes it:
/// "-o,--output", "--spp", or a bare word for a positional. The last of several wins.
template <class T>
CLI::Option* addValue(CLI::App& app, const std::string& group, const std::string& name, T& member,
                      std::string help, core::Range range = {})
{
    help += factsText(member, range);
    const CLI::callback_t read = [&member, range, name](const CLI::results_t& results) {
        const std::string problem = readValue(results.back(), range, member);
        if (!problem.empty())
            throw CLI::ValidationError(name.substr(name.rfind(',') + 1),
                                       "'" + results.back() + "' is not " + problem);
        return true;
    };
    return app.add_option(name, read, help)
        ->group(group)
        ->expected(1)
        ->type_name(typeName<T>())
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

/// An option whose text `read` turns into a value.
template <class T, class Read>
void addRead(CLI::App& app, const std::string& group, const std::string& name,
             const std::string& type, T& member, Read read, const std::string& help)
{
    app.add_option(
           name,
           [&member, read](const CLI::results_t& results) {
               member = read(results.back());
               return true;
           },
           help)
        ->group(group)
        ->expected(1)
        ->type_name(type)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

/// --method and the parameters of every method: texts, until it is known which method they are for.
struct MethodArguments {
    std::string method;
    std::vector<std::pair<std::string, std::string>> values;  // name of the parameter, text

    bool given() const { return !method.empty() || !values.empty(); }

    /// The chosen method's parameters. Throws core::Error (command line) for a method that does not
    /// exist, a parameter that is not its own, and a value that does not fit.
    core::AnyParams params() const;
};

/// Adds them: names, help, ranges and defaults come from the table of methods. A parameter that
/// several methods have is one option.
std::shared_ptr<MethodArguments> addMethod(CLI::App& app);

/// Adds the parameters of one method, those named in `without` left out; the method is given.
std::shared_ptr<MethodArguments> addParametersOf(CLI::App& app, std::string_view method,
                                                 const std::vector<std::string_view>& without);

/// Throws core::Error (command line) when the method does not run on such a device.
void requireRuns(const core::AnyParams& params, DeviceKind device);

/// What every command that loads a scene has: SCENE and the group "Loading".
void addSceneOptions(CLI::App& app, SceneOptions& scene);

/// --no-cache, in the group of the device.
void addNoCache(CLI::App& app, const std::string& group, bool& noCache);

/// The group alone, for commands that take several scenes.
void addLoadingOptions(CLI::App& app, SceneOptions& scene);

/// "640x360" to a size. Throws as CLI11 does for a wrong value.
glm::uvec2 readSize(const std::string& text);

/// The same for an option of another name.
glm::uvec2 readSizeOf(const char* option, const std::string& text);

/// SCENE... of commands that take several: their files go to `files`.
void addSceneFiles(CLI::App& app, std::vector<std::filesystem::path>& files);

/// What `command` measures: each of the `files` loaded as `loading` says. Throws core::Error
/// (command line) where there are none, or no folder for the results.
std::vector<SceneOptions> measuredScenes(const std::string& command, const SceneOptions& loading,
                                         const std::vector<std::filesystem::path>& files,
                                         const std::filesystem::path& output);

/// What is read of a measurement of whole pictures, and put into its options at the end.
struct PictureArguments {
    SceneOptions loading;  // of every scene, but for the file
    std::vector<std::filesystem::path> files;
};

/// What the help of such a measurement says of options that all of them have.
struct PictureHelp {
    const char* output;
    const char* quick;
    const char* samples;
};

/// SCENE..., --output, --quiet, --quick, --samples, --size, --camera, --device, --device-index and
/// those of loading.
void addPictureOptions(CLI::App& app, PictureBenchOptions& options, PictureArguments& given,
                       const PictureHelp& help);

/// Scenes, and `usual` samples where none were given. Throws core::Error (command line) for
/// options that do not go together.
void finishPictures(const std::string& command, const PictureArguments& given,
                    std::vector<uint32_t> usual, PictureBenchOptions& options);

/// The items of "a,b,c" that are not empty.
std::vector<std::string> splitList(const std::string& text);

/// The numbers of "1,2,3", ascending and without repetition. `what` is one of them in words for a
/// person. Throws as CLI11 does for a wrong value.
template <class T>
std::vector<T> readNumbers(const char* option, const std::string& text, core::Range range,
                           const std::string& what)
{
    std::vector<T> numbers;
    for (const std::string& item : splitList(text)) {
        T number{};
        if (!readValue(item, range, number).empty())
            throw CLI::ValidationError(option, "'" + item + "' is not " + what);
        numbers.push_back(number);
    }
    if (numbers.empty()) throw CLI::ValidationError(option, "the list is empty");
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    return numbers;
}

[[noreturn]] void badCommandLine(const std::string& message);

/// A subcommand: where its options are read to and what it becomes.
struct Subcommand {
    CLI::App* app = nullptr;
    std::string usage;
    std::function<Command()> finish;
};

/// The window's options on `app`: the subcommand `view`, or the program without a command.
Subcommand viewCommandLine(CLI::App& app, const std::string& usage);

Subcommand labCommandLine(CLI::App& root);

Subcommand flythroughCommandLine(CLI::App& bench);

Subcommand manyLightsCommandLine(CLI::App& bench);

Subcommand guidingCommandLine(CLI::App& bench);

Subcommand lightCommandLine(CLI::App& bench);

/// Help of a command in at most 100 columns: usage, what it does, options by group, and the
/// example.
std::string helpText(const CLI::App& app, const std::string& usage);

/// The manual page of the program and all its commands, as roff.
std::string manualText(const CLI::App& root, const std::vector<Subcommand>& commands);

/// Long and short names of all options of a command, as typed.
std::vector<std::string> optionNames(const CLI::App& app);

}  // namespace app

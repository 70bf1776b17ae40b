// --method and the methods' parameters as options. A parameter is read when the whole command line
// is known, since its range may depend on the method.
#include <algorithm>

#include "app/args/args_options.h"
#include "core/base/check.h"

namespace app {

namespace {

/// Names of the methods that have a parameter of this name.
std::vector<std::string> ownersOf(const std::string& name)
{
    std::vector<std::string> owners;
    for (const core::MethodInfo& method : core::methods())
        core::AnyParams::visit(method.defaults, [&](const core::Field& field, const auto&) {
            if (name == field.name) owners.emplace_back(method.id());
        });
    return owners;
}

std::string joined(const std::vector<std::string>& words, const char* between)
{
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
    return text;
}

template <class T> std::string helpOf(const core::Field& field, const T& standard)
{
    return field.help + std::string(field.biased ? " [biased]" : "") +
           factsText(standard, field.range);
}

/// The help of a parameter, apart for those of its owners that mean something else by it.
std::string helpOf(const std::string& name, const std::vector<std::string>& owners)
{
    std::vector<std::pair<std::string, std::vector<std::string>>> helps;  // and whose they are
    for (const std::string& owner : owners)
        core::AnyParams::visit(
            core::methodNamed(owner).defaults, [&](const core::Field& field, const auto& standard) {
                if (name != field.name) return;
                const std::string help = helpOf(field, standard);
                const auto same = std::ranges::find(helps, help, [](auto& h) { return h.first; });
                if (same == helps.end())
                    helps.push_back({help, {owner}});
                else
                    same->second.push_back(owner);
            });
    if (helps.size() == 1) return helps.front().first;
    std::vector<std::string> texts;
    for (const auto& [help, whose] : helps) texts.push_back(joined(whose, ", ") + ": " + help);
    return joined(texts, "; ");
}

template <class T>
void addParameter(CLI::App& app, const std::string& group, const core::Field& field, const T&,
                  const std::string& help, std::shared_ptr<MethodArguments> arguments)
{
    const std::string name = field.name;
    app.add_option(
           "--" + name,
           [name, arguments](const CLI::results_t& results) {
               arguments->values.emplace_back(name, results.back());
               return true;
           },
           help)
        ->group(group)
        ->expected(1)
        ->type_name(typeName<T>())
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
}

}  // namespace

std::shared_ptr<MethodArguments> addMethod(CLI::App& app)
{
    const auto arguments = std::make_shared<MethodArguments>();
    std::vector<std::string> ids;
    std::string help = "how light is found:";
    for (const core::MethodInfo& method : core::methods()) {
        ids.emplace_back(method.id());
        help += (ids.size() > 1 ? "; " : " ") + ids.back() + ", " + method.help;
    }
    app.add_option(
           "--method",
           [arguments](const CLI::results_t& results) {
               arguments->method = results.back();
               return true;
           },
           help + " (default " + ids.front() + ")")
        ->group("Method")
        ->expected(1)
        ->type_name(joined(ids, "|"))
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    for (const core::MethodInfo& method : core::methods()) {
        const std::string id(method.id());
        core::AnyParams::visit(method.defaults, [&](const core::Field& field, const auto& value) {
            const std::vector<std::string> owners = ownersOf(field.name);
            if (owners.front() != id) return;
            addParameter(app, "Parameters of --method " + joined(owners, " and "), field, value,
                         helpOf(field.name, owners), arguments);
        });
    }
    return arguments;
}

std::shared_ptr<MethodArguments> addParametersOf(CLI::App& app, std::string_view method,
                                                 const std::vector<std::string_view>& without)
{
    const auto arguments = std::make_shared<MethodArguments>();
    arguments->method = method;
    core::AnyParams::visit(core::methodNamed(method).defaults,
                           [&](const core::Field& field, const auto& value) {
                               if (std::ranges::find(without, field.name) == without.end())
                                   addParameter(app, "Parameters of the method", field, value,
                                                helpOf(field, value), arguments);
                           });
    return arguments;
}

core::AnyParams MethodArguments::params() const
{
    core::AnyParams params =
        method.empty() ? core::methods().front().defaults : core::methodNamed(method).defaults;
    for (const auto& given : values) {
        // No structured binding: clang 14 has no lambda that captures one.
        const std::string &name = given.first, &text = given.second;
        bool found = false;
        core::AnyParams::visit(params, [&](const core::Field& field, auto& member) {
            if (name != field.name) return;
            found = true;
            const std::string problem = readValue(text, field.range, member);
            if (!problem.empty())
                badCommandLine("--" + name + ": '" + text + "' is not " + problem);
        });
        if (!found)
            badCommandLine("--" + name + " is a parameter of --method " +
                           joined(ownersOf(name), " and ") + ", not of " +
                           std::string(params.id()));
    }
    return params;
}

void requireRuns(const core::AnyParams& params, DeviceKind device)
{
    const std::string why = whyNot(params.id(), device);
    if (!why.empty())
        badCommandLine("--method " + std::string(params.id()) + " does not run on --device " +
                       std::string(core::enumName(device)) + ": " + why);
}

}  // namespace app

// The manual page, rekindle(1): made from the same commands and options as --help, so that it says
// nothing that the program does not. `rekindle --manual` prints it for the build.
#include "app/args/args_options.h"

#include <algorithm>

#include "app/base/program_version.h"

namespace app {

namespace {

/// Text as roff takes it: what would be a request or an escape is protected.
std::string roff(const std::string& text)
{
    std::string result;
    for (const char c : text) {
        const bool lineStart = result.empty() || result.back() == '\n';
        if (lineStart && (c == '.' || c == '\'')) result += "\\&";
        if (c == '\\')
            result += "\\e";
        else if (c == '-')
            result += "\\-";
        else
            result += c;
    }
    return result;
}

std::string optionEntry(const CLI::Option& option)
{
    if (option.get_positional())
        return ".TP\n.I " + roff(option.get_name(true)) + "\n" + roff(option.get_description()) +
               '\n';
    std::string names;
    for (const std::string& name : option.get_snames()) names += "\\fB\\-" + roff(name) + "\\fR, ";
    for (const std::string& name : option.get_lnames())
        names += "\\fB\\-\\-" + roff(name) + "\\fR, ";
    if (names.empty()) return {};
    names.resize(names.size() - 2);
    if (option.get_expected_min() > 0) names += " \\fI" + roff(option.get_type_name()) + "\\fR";
    return ".TP\n" + names + '\n' + roff(option.get_description()) + '\n';
}

/// `help`: those that every command has and the program tells, too.
std::string optionsOf(const CLI::App& app, bool help = false)
{
    std::string text;
    for (const std::string& group : app.get_groups()) {
        if (group.empty() || (group == "Help" && !help)) continue;
        std::string entries;
        for (const CLI::Option* option : app.get_options())
            if (option->get_group() == group) entries += optionEntry(*option);
        if (!entries.empty()) text += ".PP\n" + roff(group) + ":\n" + entries;
    }
    return text;
}

/// The footer's lines as they stand.
std::string asItStands(const std::string& text)
{
    return text.empty() ? text : ".PP\n.nf\n" + roff(text) + "\n.fi\n";
}

/// A command and then those under it, as they were added.
void addInOrder(const CLI::App& app, const std::vector<Subcommand>& commands,
                std::vector<const Subcommand*>& order)
{
    const auto own = std::ranges::find(commands, &app, &Subcommand::app);
    if (own != commands.end()) order.push_back(&*own);
    for (const CLI::App* child : app.get_subcommands([](const CLI::App*) { return true; }))
        addInOrder(*child, commands, order);
}

}  // namespace

std::string manualText(const CLI::App& root, const std::vector<Subcommand>& commands)
{
    std::string text = std::string(".TH REKINDLE 1 \"\" \"rekindle ") + kVersion +
                       "\" \"User Commands\"\n.SH NAME\nrekindle \\- path\\-traces glTF scenes in "
                       "a window or to files\n.SH SYNOPSIS\n.nf\n";
    std::vector<const Subcommand*> order;
    addInOrder(root, commands, order);
    for (const Subcommand* command : order) text += roff(command->usage) + '\n';
    text += ".fi\n.SH DESCRIPTION\n" + roff(root.get_description()) + '\n' + optionsOf(root, true);
    for (const Subcommand* command : order) {
        if (command->app == &root) continue;
        std::string title;
        for (const CLI::App* app = command->app; app != &root; app = app->get_parent())
            title = app->get_name() + (title.empty() ? "" : " ") + title;
        text += ".SH \"COMMAND " + roff(title) + "\"\n" + roff(command->usage) + "\n.PP\n" +
                roff(command->app->get_description()) + '\n' + optionsOf(*command->app) +
                asItStands(command->app->get_footer());
    }
    text += ".SH \"EXAMPLES AND EXIT STATUS\"\n" + asItStands(root.get_footer()).substr(4);
    return text;
}

}  // namespace app

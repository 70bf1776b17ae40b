// The manual page, rekindle(1): made from the same commands and options as --help, so that it says
// nothing that the program does not. `rekindle --manual` prints it for the build.
#include "app/args/args_options.h"

#include <iterator>

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

std::string optionsOf(const CLI::App& app)
{
    std::string text;
    for (const std::string& group : app.get_groups()) {
        if (group.empty() || group == "Help") continue;
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

}  // namespace

std::string manualText(const CLI::App& root, const std::vector<Subcommand>& commands)
{
    std::string text = std::string(".TH REKINDLE 1 \"\" \"rekindle ") + kVersion +
                       "\" \"User Commands\"\n.SH NAME\nrekindle \\- path\\-traces glTF scenes in "
                       "a window or to files\n.SH SYNOPSIS\n.nf\n";
    for (auto c = commands.rbegin(); c != commands.rend(); ++c) {
        // A group of commands has the usage of its only one.
        if (c == commands.rbegin() || c->usage != std::prev(c)->usage)
            text += roff(c->usage) + '\n';
    }
    text += ".fi\n.SH DESCRIPTION\n" + roff(root.get_description()) + '\n' + optionsOf(root);
    for (const Subcommand& command : commands) {
        if (command.app == &root) continue;
        std::string title;
        for (const CLI::App* app = command.app; app != &root; app = app->get_parent())
            title = app->get_name() + (title.empty() ? "" : " ") + title;
        text += ".SH \"COMMAND " + roff(title) + "\"\n" + roff(command.usage) + "\n.PP\n" +
                roff(command.app->get_description()) + '\n' + optionsOf(*command.app) +
                asItStands(command.app->get_footer());
    }
    text += ".SH \"EXAMPLES AND EXIT STATUS\"\n" + asItStands(root.get_footer()).substr(4);
    return text;
}

}  // namespace app

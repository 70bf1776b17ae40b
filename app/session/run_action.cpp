// Finding actions, and what they do when nothing else is open. The table is in actions.cpp.
#include <algorithm>
#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/base/nearest.h"
#include "app/session/actions.h"
#include "core/base/check.h"

namespace app {

using Json = nlohmann::ordered_json;

std::vector<ActionGroup> actionGroups()
{
    // Each begins with the action named.
    constexpr std::array<std::pair<const char*, std::string_view>, 7> kFirst{
        {{"Picture", "pause"},
         {"Camera", "focus"},
         {"Camera path", "add-key"},
         {"Comparison", "compare"},
         {"Files", "open"},
         {"Parameters", "set"},
         {"Window", "help"}}};
    const std::span<const Action> all = actions();
    const auto place = [&](std::string_view name) {
        return static_cast<size_t>(std::ranges::find(all, name, &Action::name) - all.begin());
    };
    std::vector<ActionGroup> groups;
    for (size_t i = 0; i < kFirst.size(); ++i) {
        const size_t begin = place(kFirst[i].second);
        const size_t end = i + 1 < kFirst.size() ? place(kFirst[i + 1].second) : all.size();
        groups.push_back({kFirst[i].first, all.subspan(begin, end - begin)});
    }
    return groups;
}

void escapeFrom(Session& s, AppRequests& app)
{
    if (const std::vector<Work> works = s.works(); !works.empty())
        s.cancel(works.front());
    else if (s.flying)
        s.flying = false;
    else
        app.leave = true;
}

namespace {

const Action& actionNamed(const std::string& name)
{
    std::vector<std::string> names;
    for (const Action& action : actions()) {
        if (name == action.name) return action;
        names.emplace_back(action.name);
    }
    throw core::Error("there is no action \"" + name + "\"" + suggestion(name, names),
                      core::ExitCode::commandLine);
}

}  // namespace

void runAction(const std::string& name, Session& session, AppRequests& app, const Json& arguments)
{
    actionNamed(name).run({session, app, arguments});
}

void runAction(const std::string& name, Session& session, AppRequests& app)
{
    runAction(name, session, app, Json::object());
}

void runByHand(const std::string& name, Session& session, AppRequests& app, const Json& arguments)
{
    const Action& action = actionNamed(name);
    const bool refused = action.refused != nullptr && action.refused(session);
    if (refused || action.replaces == Parts{} || lossesOf(session, action.replaces).empty())
        action.run({session, app, arguments});
    else
        app.question = Intent{&action, std::make_shared<const Json>(arguments)};
}

void runByHand(const std::string& name, Session& session, AppRequests& app)
{
    runByHand(name, session, app, Json::object());
}

void doIntent(const Intent& intent, Session& session, AppRequests& app)
{
    try {
        intent.action->run({session, app, *intent.arguments});
    } catch (const core::Error& error) {
        session.notices.tell(Severity::error, error.what());
    }
}

}  // namespace app

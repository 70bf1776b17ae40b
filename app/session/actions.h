// What can be done in the viewer, by name: the keys, the list of keys, the panel's buttons, scripts
// and the random walk of the tests all go through this one table.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "app/session/losses.h"
#include "app/session/session.h"

namespace app {

struct Action;

/// An action with its arguments, for later.
struct Intent {
    const Action* action = nullptr;
    std::shared_ptr<const nlohmann::ordered_json> arguments;
};

/// What only the window's loop can do; asked for here, done at the end of the frame.
struct AppRequests {
    bool leave = false;               // quit, unless something would be lost: see losses.h
    bool askQuit = false;             // ask first
    bool quit = false;                // whatever is lost
    bool quitWhenSaved = false;       // once all files are written, unless one cannot be
    std::optional<Intent> question;   // would lose something: ask first
    std::optional<Intent> whenSaved;  // as quitWhenSaved
    bool escape = false;  // close what is open over the picture; with nothing open escapeFrom()
    bool wouldReplace = false;  // a file is there: with "replace" it would have been written
    bool openPathBox = false, foldPanel = false;
    bool togglePlot = false;
    std::optional<std::filesystem::path> screenshot;  // PNG
    bool screenshotWithPanel = true;
    std::optional<std::string> toClipboard;
    bool pasteCamera = false;  // from the clipboard
    std::optional<glm::uvec2> resize;
};

struct ActionContext {
    Session& session;
    AppRequests& app;
    // An object; members as `arguments` of the action says
    const nlohmann::ordered_json& arguments;
};

struct Action {
    const char* name;       // "pause"; in scripts {"do": "pause"}
    const char* key;        // "Space", "Ctrl+S", "Shift+E"; "" when it has none
    const char* arguments;  // "" or what a script may give: "file", "dx, dy"
    const char* help;       // one line
    void (*run)(const ActionContext&);
    Parts replaces = {};  // what is gone afterwards
    // Whether it would only say why it cannot be done now: nothing is lost then, or asked about
    bool (*refused)(const Session&) = nullptr;
};

std::span<const Action> actions();

/// Actions that belong together, as the list of keys shows them.
struct ActionGroup {
    const char* title;
    std::span<const Action> actions;
};
std::vector<ActionGroup> actionGroups();

/// What Esc does when nothing lies over the picture: cancels the work that was begun last, else
/// ends flying, else leaves.
void escapeFrom(Session& session, AppRequests& app);

/// Does one. Throws core::Error for an unknown name (with the nearest one) or wrong arguments.
void runAction(const std::string& name, Session& session, AppRequests& app);
void runAction(const std::string& name, Session& session, AppRequests& app,
               const nlohmann::ordered_json& arguments);

/// The same for a key, a button or a file that is dropped: asks first, as `app.question`, when
/// something would be lost by it (see losses.h). Scripts mean what they say.
void runByHand(const std::string& name, Session& session, AppRequests& app,
               const nlohmann::ordered_json& arguments);
void runByHand(const std::string& name, Session& session, AppRequests& app);

/// What has been asked about, unasked; what is refused becomes a notice.
void doIntent(const Intent& intent, Session& session, AppRequests& app);

}  // namespace app

// What the parts of the panel share: the context of a frame, what is typed but not yet done, and
// small pieces.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <imgui.h>
#include <nlohmann/json.hpp>

#include "app/files/folder_list.h"
#include "app/session/file_actions.h"
#include "app/view/ui/param_widgets.h"
#include "app/view/ui/plot.h"
#include "app/view/ui/ui.h"
#include "app/view/ui/ui_places.h"
#include "app/view/ui/ui_text.h"

namespace app {

/// The two sides of a comparison.
inline constexpr const char* kSideNames[] = {"A", "B"};

/// A notice on its way out.
struct Toast {
    Notice notice;
    double since = 0;     // ImGui's time of its first frame
    bool copied = false;  // the path of its file
    int before = 0;       // messages of other files that it stands for, too
};

/// A line to type a file's name into, with what it could be completed to.
struct PathBox {
    std::string text;
    std::string completedFor;  // the text that `completions` belong to
    std::vector<std::string> completions;
    bool focus = false;       // give it the keyboard, everything selected
    bool caretAtEnd = false;  // with `focus`: nothing selected, what is typed goes on from there
    bool open = false;        // whether the completions are on show, if the line is
    int drawnAt = -1;         // ImGui's count of frames when the line was
    bool ownList = false;     // they are shown elsewhere, and the arrow keys choose there
    int arrows = 0;           // presses downwards less those upwards that nobody has taken yet
};

/// A scene that was open before.
struct RecentScene {
    std::string file;
    SmallPicture picture;
};

/// The window that looks for a scene.
struct SceneBrowser {
    bool open = false;
    PathBox box;
    std::string listed;  // the folder that `entries` are of, as it was typed
    std::vector<FolderEntry> entries;
    int chosen = -1;  // by the keyboard, of the rows on show
    std::vector<RecentScene> recent;
};

/// Of one picture, which every frame needs and a walk over all pixels tells.
struct KnownMean {
    std::weak_ptr<const Picture> of;
    double luminance = 0;
};

/// What lives from frame to frame and belongs to nobody else.
struct UiState {
    PathBox scene, reference, path, picture, environment;
    std::string toReplace;  // what was asked for and would replace a file if it is asked for again
    std::string cameraName, presetName, exportPattern = kFramePattern;
    uint64_t exportSamples = 64;
    double equalSeconds = 5;
    double targetError = 0;  // of the plot's time to go when no limit is set
    int selectedKey = -1;
    bool draggingKey = false;
    double editedFrame = 0;  // of the key whose frame is being typed
    std::vector<Toast> toasts;
    uint64_t seenNotices = 0;
    SceneBrowser browser;
    uint64_t loggedNotices = 0;
    std::vector<std::string> unknownActions;
    bool recalled = false;     // the places of windows
    std::string search;        // in the list of keys
    std::vector<Loss> losses;  // by what is asked about, as the question tells them
    Intent intent;             // that it is about; of quitting there is none
    ImVec2 caption{0, 0};      // right and lower end of the caption on the picture
    WindowPlaces places;
    Area plot;               // of the plot's window in the frame before; empty: it is closed
    bool plotAsked = false;  // for in this run
    CurveColours colours;    // of the plot's past curves
    KnownMean mean;
    ImVec2 progress{0, 0};  // right and lower end of the strips of progress; 0: there are none
};

struct UiContext {
    Session& session;
    AppRequests& app;
    const UiFrame& frame;
    UiState& state;
    float em = 13;        // height of a letter
    ImVec2 window{0, 0};  // size
    const Area& picture;  // what the window has for it: overlays stay inside

    /// Runs an action, or asks first; what it refuses becomes a notice.
    void act(const char* action,
             const nlohmann::ordered_json& arguments = nlohmann::ordered_json::object()) const;
};

/// Flags of what lies over the picture and takes no part in the order of windows.
inline constexpr ImGuiWindowFlags kOverlay =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
    ImGuiWindowFlags_NoBringToFrontOnFocus;

// --- pieces (ui_pieces.cpp)

/// A button that runs an action: its key and help are the tool-tip. A non-empty `whyNot` disables
/// it and says why. `width` 0: as wide as the text; negative: up to that far from the right edge.
bool actionButton(const UiContext& c, const char* label, const char* action,
                  const std::string& whyNot = {},
                  const nlohmann::ordered_json& arguments = nlohmann::ordered_json::object(),
                  float width = 0);

/// The same, without running it: true when clicked.
bool buttonOf(const UiContext& c, const char* label, const char* action,
              const std::string& whyNot = {}, float width = 0);

/// Runs an action that writes to the "file" that was typed: one that is there is replaced when this
/// is asked for twice.
void writeTyped(const UiContext& c, const char* action, nlohmann::ordered_json arguments);

/// The same for what no action does: true when clicked.
bool plainButton(const char* label, const std::string& help, const std::string& whyNot = {},
                 float width = 0);

/// Goes on in the same line when `width` more pixels have room there, else in the next.
void sameLineIfRoom(float width);

/// The width of a button with this text.
float buttonWidth(const char* label);

/// A collapsible section, whose state is kept in `open`. Push an id of the same name around its
/// contents.
bool section(const char* title, bool& open);

/// Text on the picture, on a dark ground, with its upper left corner at `place`.
void labelOnPicture(const UiContext& c, ImVec2 place, const std::string& text);

/// Text, wrapped at spaces.
void wrappedText(const std::string& text);

/// Small text in the colour of disabled things, wrapped.
void dimText(const std::string& text);

/// A line to type a path into, completed with Tab or by the mouse; true when Enter was pressed.
/// `extensions`: lower case with dots; folders are always offered.
bool pathInput(PathBox& box, const char* id, const char* hint,
               const std::vector<std::string>& extensions);

/// A line of text; true when Enter was pressed.
bool textInput(const char* id, const char* hint, std::string& text);

/// Beside the 0 in the input that was drawn last: what it means.
void zeroHint(const char* text);

/// Whole number without bounds, typed or stepped; 0 reads as `zero` when that is not null. True
/// when it changed.
bool countInput(const char* id, uint64_t& value, const char* zero = nullptr);

/// "Ctrl+S" of an action, or "".
std::string keyOf(const char* action);

/// Whether an action would only say why it cannot be done now.
bool isRefused(const UiContext& c, const char* action);

/// " (3 times)" for a message that was repeated.
std::string timesText(const Notice& notice);

/// The picture's biasing parameters, as names.
std::vector<std::string> biases(const RenderParams& params);

/// The picture that is on show, or null.
std::shared_ptr<const Picture> shownPicture(const UiContext& c);

/// A row to choose a method; its name when one was chosen, else nothing.
std::string methodRow(const RenderParams& params);

/// A row to choose a device; true when another was chosen.
bool deviceRow(const UiContext& c, RenderParams& params);

/// Shows the plot if it is not on show, else hides it. In small windows it is there only when asked
/// for in this run, whatever the settings keep; where it has no room at all a message says so.
void togglePlot(const UiContext& c);

/// What the status line's tool-tips say of a coarse picture, and of any picture's seconds.
std::string previewMeans(const Picture& picture);
std::string secondsMean(const Picture& picture);

/// What the caption of a view of first hits says of what is black in it, or nothing.
std::string blackMeans(Show show, const core::World* world);

/// Why the plot cannot be shown now; empty when it can.
std::string whyNoPlot(const UiContext& c);

/// The newest of them, with their pictures as they are on disk now.
std::vector<RecentScene> recentScenes(const Session& session);

// --- sections of the panel

void drawSceneSection(const UiContext& c);
void drawMethodSection(const UiContext& c);
void drawLimitsSection(const UiContext& c);
void drawCameraSection(const UiContext& c);
void drawPathSection(const UiContext& c);
void drawAnimationSection(const UiContext& c);
void drawViewSection(const UiContext& c);
void drawCompareSection(const UiContext& c);
void drawReferenceSection(const UiContext& c);
void drawEqualTime(const UiContext& c);        // of the section that compares
void drawComparisonTable(const UiContext& c);  // of the same
void drawSaveSection(const UiContext& c);

// --- over the picture

void drawCompareSlider(const UiContext& c);
void drawStatusLine(const UiContext& c);
void drawCaption(const UiContext& c);
void drawColourBar(const UiContext& c);
void drawProgress(const UiContext& c);
void drawToasts(const UiContext& c);
void drawInspector(const UiContext& c);
void drawSceneBrowser(const UiContext& c);
/// The file of the one that was clicked, or nothing.
std::string drawRecentScenes(const std::vector<RecentScene>& scenes);
void drawQuestions(const UiContext& c);
void drawHelpWindow(const UiContext& c);
void drawLogWindow(const UiContext& c);
void drawPlotWindow(const UiContext& c);
void drawProfilerWindow(const UiContext& c);

/// For windows with lines to type into: Tab walks through those while one of them is being typed
/// into. Else it is the panel's key, and must not lead into a line that took the keyboard's focus
/// by appearing or by a click beside it.
ImGuiWindowFlags tabFlags();

/// Begins a window that floats over the picture: `corner` in [0,1]^2 says where in the free area it
/// stands until the hand moves it, and it is held inside the window whatever happens. Call
/// ImGui::End() in any case. The title has a "###name".
bool beginFloating(const UiContext& c, const char* title, bool* open, ImVec2 size, ImVec2 corner);

}  // namespace app

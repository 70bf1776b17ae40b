// The panel and everything else that is drawn over the picture, with Dear ImGui. Parameters draw
// themselves: see param_widgets.h.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "app/gpu/base/device.h"
#include "app/session/actions.h"
#include "app/session/session.h"
#include "app/view/ui/scale.h"

namespace app {

struct UiState;

/// What the loop knows and the session does not.
struct UiFrame {
    WindowLayout layout;                       // as the window is laid out in this frame
    std::span<const gpu::DeviceInfo> devices;  // as gpu::listDevices() gave them; may be empty
    std::span<const float> frameTimes;         // of the last frames, seconds, oldest first
    double inputSeconds = 0;    // from the last input to the first picture that shows it
    uint64_t presentBytes = 0;  // device memory of the window's own device
    std::string presentDevice;
    std::optional<uint64_t> validationMessages;  // of this run so far; absent: they are not checked
    Scale scale;                                 // of what is on display
    std::string problem;                         // why it is not what was asked for, or empty
};

class Ui {
public:
    Ui();
    ~Ui();

    /// Between ImGui::NewFrame and ImGui::Render. Edits the session's parts; what only the loop can
    /// do goes to `app`. A window with room for hardly a letter shows the picture alone, and is
    /// to grow before it can ask. Takes `askQuit` (asks, then sets `quit`), `question` (asks,
    /// then does it), `openPathBox`, `togglePlot` and `escape` and clears them.
    void draw(Session& session, AppRequests& app, const UiFrame& frame);

    /// Whether the mouse holds a control: it should not move away meanwhile.
    bool isHeld() const;

    /// Where the hand has put the windows goes to the settings.
    void keepPlaces(Session& session);

    /// Names of actions that a button asked for and that do not exist: for tests, which demand that
    /// there are none.
    const std::vector<std::string>& unknownActions() const;

private:
    std::unique_ptr<UiState> state_;
};

}  // namespace app

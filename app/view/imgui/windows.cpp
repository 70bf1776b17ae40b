// See windows.h.
#include "app/view/imgui/windows.h"

#include <imgui.h>
#include <imgui_internal.h>

namespace app {

bool closeInnermostPopup()
{
    const int open = ImGui::GetCurrentContext()->OpenPopupStack.Size;
    if (open == 0) return false;
    ImGui::ClosePopupToLevel(open - 1, true);
    return true;
}

void bringToFront()
{
    ImGui::BringWindowToDisplayFront(ImGui::GetCurrentWindow());
}

const char* changedPlaces()
{
    ImGuiIO& io = ImGui::GetIO();
    if (!io.WantSaveIniSettings) return "";
    io.WantSaveIniSettings = false;
    return ImGui::SaveIniSettingsToMemory();
}

void recallPlaces(const char* text, unsigned length)
{
    if (length > 0) ImGui::LoadIniSettingsFromMemory(text, length);
}

}  // namespace app

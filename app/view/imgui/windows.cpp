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

bool lastPlace(const char* name, ImVec2& corner, ImVec2& size)
{
    const ImGuiWindow* window = ImGui::FindWindowByName(name);
    if (window == nullptr || !window->WasActive || window->Hidden) return false;
    corner = window->Pos;
    size = window->SizeFull;
    return true;
}

}  // namespace app

// The actions that read and write files of pictures and camera paths, of the table in actions.cpp.
// A file that is there is replaced where "replace" says so, which those who type a name do by
// asking twice (AppRequests::wouldReplace).
#pragma once

#include "app/session/actions.h"

namespace app {

/// Where frames of a camera path go when nobody says where; in a folder of their own.
inline constexpr const char* kFramePattern = "frames/frame-%04d.exr";

void saveAction(const ActionContext& c);
/// Frames of no name go to a folder that is not there yet.
void exportPathAction(const ActionContext& c);
void savePathAction(const ActionContext& c);
void loadPathAction(const ActionContext& c);
/// With the name of a file, or with nothing that would be lost, the picture in any case.
void saveAndQuitAction(const ActionContext& c);

}  // namespace app

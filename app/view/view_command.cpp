// The window, or frames in files where there is none. See view_command.h.
#include "app/view/view_command.h"

#include <iostream>

#include "app/commands/fly_through.h"
#include "app/files/load.h"
#include "app/session/replay.h"
#include "app/view/frame_loop.h"
#include "core/base/check.h"

namespace app {

namespace {

/// Without a display: what needs one is refused, the rest becomes numbered pictures.
int withoutWindow(const ViewOptions& o, const std::string& reason)
{
    if (!o.script.empty()) (void)Script(o.script);  // what is wrong with a file comes first
    if (!o.replay.empty()) (void)readReplay(o.replay);
    for (const auto& [given, name] :
         {std::pair(!o.script.empty(), "--script"), std::pair(!o.replay.empty(), "--replay"),
          std::pair(!o.path.empty(), "--path")})
        if (given)
            throw core::Error(std::string(name) + " needs a window: " + reason,
                              core::ExitCode::noDevice);
    const int code = flyThrough({.scene = o.scene,
                                 .device = o.device,
                                 .deviceIndex = o.deviceIndex,
                                 .validation = o.validation,
                                 .noCache = o.noCache,
                                 .params = o.params,
                                 .camera = o.camera});
    std::cerr << "there is no window (" << reason << "), so this was a flight in pictures\n";
    return code;
}

}  // namespace

int viewCommand(const ViewOptions& options)
{
    std::string reason;
    if (!Window::displayAvailable(reason)) return withoutWindow(options, reason);
    ViewOptions o = options;
    if (o.scene.file.empty() && o.replay.empty()) o.scene.file = defaultScene();
    return FrameLoop(o).run();
}

}  // namespace app

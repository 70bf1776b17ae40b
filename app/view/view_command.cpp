// What is shown without a window. See view_command.h.
#include "app/view/view_command.h"

#include "app/fly_through.h"
#include "core/check.h"

namespace app {

int viewCommand(const ViewOptions& o)
{
    if (!o.script.empty())
        throw core::Error("--script needs a display: there is none", core::ExitCode::noDevice);
    if (!o.replay.empty())
        throw core::Error("--replay needs a display: there is none", core::ExitCode::noDevice);
    return flyThrough({.scene = o.scene,
                       .device = o.device,
                       .deviceIndex = o.deviceIndex,
                       .validation = o.validation,
                       .params = o.params,
                       .camera = o.camera});
}

}  // namespace app

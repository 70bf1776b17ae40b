// What quitting would lose. One rule for every way of leaving: it is asked first when there is
// anything in this list.
#pragma once

#include <string>
#include <vector>

#include "app/session/session.h"

namespace app {

/// What took more than a minute of rendering and is kept nowhere, as sentences begin: "the picture:
/// 1204 samples per pixel, 3 minutes of rendering". Empty: one may leave at once.
std::vector<std::string> lossesOf(const Session& session);

/// "75 seconds", "3 minutes", "2.5 hours".
std::string spanText(double seconds);

}  // namespace app

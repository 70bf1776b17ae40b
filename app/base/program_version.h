// The program's own version.
#pragma once

namespace app {

extern const char* const kVersion;
extern const char* const kCommit;

}  // namespace app

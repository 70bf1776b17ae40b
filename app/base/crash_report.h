// What is left to tell when the program crashes: which signal, in which thread, from where.
#pragma once

namespace app {

/// From now on a crash writes to standard error, before the program ends by the signal as it would
/// anyway: version and commit, the signal, the thread's name, and the calls that led there as file
/// and offset, which `addr2line -e FILE OFFSET` turns into lines of source. Nothing under a
/// sanitizer, which tells more.
void reportCrashes();

}  // namespace app

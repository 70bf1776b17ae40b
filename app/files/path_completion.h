// Completion of names for a box in which paths are typed.
#pragma once

#include <string>
#include <vector>

namespace app {

/// What the last part of `typed` may become: whole paths that begin as it was typed, files first,
/// then folders with a slash at their end, as listFolder() has them, at most 50. "~" is the home
/// folder, hidden names appear when their dot is typed, case is ignored where no name has the case
/// typed. What cannot be read is empty.
std::vector<std::string> completePath(const std::string& typed,
                                      const std::vector<std::string>& extensions);

/// `typed` with a leading "~" or "~/" replaced by the home folder, when there is one.
std::string expandHome(const std::string& typed);

}  // namespace app

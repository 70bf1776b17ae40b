// What a bug report needs to know of the program: itself, how it was built, the libraries below it
// and the machine.
#pragma once

#include <string>

namespace app {

/// Several lines to read, one fact each.
std::string versionText();

/// The same as one JSON object, "schema": 1.
std::string versionJson();

}  // namespace app

// The report of the laboratory: one page that stands alone, with its style and its pictures in it.
#pragma once

#include <string>

#include "app/lab/results.h"

namespace app::lab {

/// HTML with inline CSS and SVG; refers to nothing outside and needs no script. Empty lists, NaN
/// and infinite values are shown as such.
std::string reportHtml(const LabResults& results);

}  // namespace app::lab

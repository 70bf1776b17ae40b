// The program's icon, a flame of three drops on a dark disc: the same shapes as
// packaging/rekindle.svg, drawn here so that the window needs no file.
#pragma once

#include <cstdint>
#include <vector>

namespace app {

/// `side` by `side` pixels, RGBA rows from the top, colours not multiplied by alpha.
std::vector<uint8_t> iconPixels(int side);

}  // namespace app

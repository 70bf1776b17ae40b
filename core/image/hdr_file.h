// Radiance pictures (.hdr): red, green and blue share one exponent, lines are packed by run
// lengths.
//   G. Ward, "Real Pixels", in Graphics Gems II, Academic Press 1991, pp. 80-83;
//   the format of files after the Radiance reference manual (radsite.lbl.gov, "File Formats").
#pragma once

#include <stop_token>

#include "core/image/raw_image.h"

namespace core {

/// Whether these are the first bytes of a Radiance picture.
bool isHdr(EncodedImage bytes);

/// Three floats per pixel, m * 2^(e - 136) for a mantissa m and the exponent e; rows from the top,
/// whichever of the eight orientations the file has. Both kinds of run lengths are read, and files
/// without. Exposure and primaries are not applied, XYZ is refused, and so is a file that was cut
/// off.
DecodedImage decodeHdr(EncodedImage bytes, const ImageGuards& guards, std::stop_token stop = {});

}  // namespace core

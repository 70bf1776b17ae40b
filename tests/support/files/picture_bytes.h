// Bytes of PNG and JPEG files, put together piece by piece, for tests of what decoders do with
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tests {

using Bytes = std::vector<std::byte>;

Bytes operator+(Bytes a, const Bytes& b);

/// The bytes of a text, as they are.
Bytes bytesOf(const std::string& text);

/// A number as four bytes, the most significant first.
Bytes bigEndian(uint32_t value);

/// A chunk of a PNG with its length and checksum (ISO 15948).
Bytes pngChunk(const std::string& type, const Bytes& content);

/// The PNG with something put behind its header.
Bytes behindHeader(const Bytes& png, const Bytes& chunks);

/// A segment of a JPEG: marker 0xff `marker`, length, content.
Bytes jpegSegment(uint8_t marker, const Bytes& content);

/// The JPEG with something put behind its first marker.
Bytes behindStart(const Bytes& jpeg, const Bytes& segments);

/// Whatever a profile of colours is wrapped in for a JPEG, around `profile`.
Bytes jpegProfile(const Bytes& profile);

/// A progressive JPEG in grey whose first scan is followed by `more` that hold nothing.
Bytes progressiveJpeg(uint16_t width, uint16_t height, size_t more);

}  // namespace tests

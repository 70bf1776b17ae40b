// EXR files of every kind that the format has, written by its own library, for tests of what reads
// them.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tests {

enum class ExrType { unsigned32, half, float32 };

struct ExrPlane {
    std::string name;
    ExrType type = ExrType::float32;
    std::vector<float> values;  // rows from the top; sampled: every second of every second row
    int sampling = 1;
};

struct ExrPicture {
    int width = 1, height = 1;
    std::vector<ExrPlane> planes = {};
    int compression = 3;  // as the format counts them: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, ...
    int tileSide = 0;     // 0: scan lines
    bool levels = false;  // of detail, in tiles
    bool bottomUp = false;
    int left = 0, top = 0;  // of the data window
};

constexpr int kExrCompressions = 10;

std::vector<std::byte> makeExr(const ExrPicture& picture);

/// Two parts, each as wide and high as the picture.
std::vector<std::byte> makeExrOfTwoParts(const ExrPicture& picture);

}  // namespace tests

// libFuzzer entry over the decoders of pictures: PNG, JPEG, OpenEXR and Radiance, chosen by content
// as the loader does, then turned into texels. See run.sh.
#include <cstdint>

#include "core/gltf/texture_image.h"
#include "core/image/png_file.h"

// The fuzzer's contract gives the name.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    const core::EncodedImage bytes = std::as_bytes(std::span(data, size));
    core::ImageGuards guards;
    guards.maxSize = 1024;
    guards.maxBytes = 4 << 20;
    const core::DecodedImage decoded = core::decodeImage(bytes, guards);
    if (decoded.problem.empty()) {
        uint64_t repaired = 0;
        (void)core::makeTexture(decoded.image, true, repaired);
        (void)core::makeRadiance(decoded.image, repaired);
    }
    (void)core::pngText(bytes);
    return 0;
}

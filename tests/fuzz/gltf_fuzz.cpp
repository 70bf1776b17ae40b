// libFuzzer entry over the whole loader with every file access refused. See run.sh.
#include <cstdint>

#include "core/gltf/gltf.h"

// The fuzzer's contract gives the name.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    core::LoadOptions options;
    options.maxMemoryMb = 128;
    options.maxTextureSize = 1024;
    try {
        core::loadGltfFromMemory(std::as_bytes(std::span(data, size)), "fuzz.gltf", options);
    } catch (const core::LoadError&) {
        // A refusal is a correct result; any other exception is a finding.
    }
    return 0;
}

// libFuzzer entry over the program's own JSON files: the first byte chooses between settings, a
// script, a camera, a path and the metadata of a picture. See run.sh.
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/files/camera_file.h"
#include "app/session/replay.h"
#include "app/session/settings.h"
#include "app/view/script.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

// The fuzzer's contract gives the name.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace {

void readAs(unsigned kind, const std::string& text)
{
    static const std::filesystem::path file =
        std::filesystem::temp_directory_path() /
        ("rekindle-fuzz-" + std::to_string(getpid()) + ".json");
    const auto parsed = [&] { return app::parseJson(text, "fuzz.json"); };
    switch (kind % 5) {
    case 0: {
        core::writeFile(file, text);
        std::string problem;
        const app::Settings settings = app::readSettings(file, problem);
        app::writeSettings(file, settings);
        break;
    }
    case 1: {
        core::writeFile(file, text);
        const app::Script script(file);
        break;
    }
    case 2:
        (void)app::cameraFromJson(parsed(), {}, {}, "fuzz.json");
        break;
    case 3: {
        const app::CameraPath path = app::cameraPathFromJson(parsed(), {}, {}, "fuzz.json");
        for (const double frame : {-1.0, 0.5, 1e9}) (void)path.at(frame);
        break;
    }
    default: {
        core::Metadata metadata;
        const nlohmann::ordered_json json = parsed();
        if (!json.is_object()) return;
        for (const auto& [key, value] : json.items())
            metadata[key] = value.is_string() ? value.get<std::string>() : app::jsonText(value);
        (void)app::replayOf(metadata, "fuzz.png");
    }
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    if (size == 0) return 0;
    try {
        readAs(data[0], {reinterpret_cast<const char*>(data) + 1, size - 1});
    } catch (const core::Error&) {
        // A refusal is a correct result; any other exception is a finding.
    }
    return 0;
}

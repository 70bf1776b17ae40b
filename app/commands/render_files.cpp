// See render_files.h.
#include "app/commands/render_files.h"

#include <string>
#include <vector>

#include "app/base/files.h"
#include "app/files/camera_file.h"
#include "app/files/scene_files.h"
#include "app/files/scene_path.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

namespace app {

namespace fs = std::filesystem;

namespace {

struct Input {
    std::string words;  // what it is, in a message
    fs::path file;
};

/// What is there before the command and could be lost; else there is nothing to look for.
bool replacesAny(const RenderOptions& o)
{
    std::error_code none;
    if (!o.stats.empty() && fs::exists(o.stats, none)) return true;
    const FrameRange frames = o.frames.value_or(FrameRange{});
    for (uint32_t index = frames.first; index <= frames.last; ++index)
        if (fs::exists(pictureFile(o, index), none)) return true;
    return false;
}

std::vector<Input> inputsOf(const RenderOptions& o)
{
    const fs::path scene = scenePath(o.scene.file);
    std::vector<Input> inputs{{"the scene's file", scene}};
    if (replacesAny(o))
        for (const fs::path& part : filesNamedBy(scene))
            inputs.push_back({"a file of the scene's", part});
    if (core::isEnvironmentFile(o.scene.load.environment))
        inputs.push_back({"the file of --environment", o.scene.load.environment});
    if (!o.reference.empty()) inputs.push_back({"the file of --reference", o.reference});
    if (isCameraFile(o.camera)) inputs.push_back({"the file of --camera", o.camera});
    if (!o.path.empty()) inputs.push_back({"the file of --path", o.path});
    return inputs;
}

void requireOther(const std::string& option, const fs::path& output, const std::string& words,
                  const fs::path& other)
{
    if (core::sameFile(output, other))
        throw core::Error(option + ' ' + output.string() + ": is " + words +
                              ", too — give another name",
                          core::ExitCode::commandLine);
}

/// What a picture would replace. Only a file that is there can be an input; to look first matters
/// where frames are many.
void checkPicture(const RenderOptions& o, const std::vector<Input>& inputs, const fs::path& picture)
{
    std::error_code none;
    if (fs::exists(picture, none))
        for (const Input& input : inputs) requireOther("-o", picture, input.words, input.file);
    if (!o.stats.empty()) requireOther("--stats", o.stats, "the picture's file", picture);
}

}  // namespace

fs::path pictureFile(const RenderOptions& options, uint32_t index)
{
    return options.frames ? numbered(options.output, index) : options.output;
}

void checkFiles(const RenderOptions& o)
{
    if (o.frames && !isNumbered(o.output))
        throw core::Error("-o " + o.output.string() +
                              ": frames need a place for their number, as in frame-%04d.png",
                          core::ExitCode::commandLine);
    const FrameRange frames = o.frames.value_or(FrameRange{});
    core::requireWritable(pictureFile(o, frames.first));
    if (!o.stats.empty()) core::requireWritableFile(o.stats);
    const std::vector<Input> inputs = inputsOf(o);
    if (!o.stats.empty())
        for (const Input& input : inputs) requireOther("--stats", o.stats, input.words, input.file);
    for (uint32_t index = frames.first; index <= frames.last; ++index)
        checkPicture(o, inputs, pictureFile(o, index));
}

}  // namespace app

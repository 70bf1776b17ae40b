// From a picture's metadata to a view. See replay.h.
#include "app/session/replay.h"

#include <vector>

#include "app/base/json_file.h"
#include "app/files/params_json.h"
#include "core/base/check.h"
#include "core/gltf/gltf.h"
#include "core/image/image_metadata.h"
#include "core/methods/method.h"

namespace app {

namespace fs = std::filesystem;

namespace {

/// Metadata of a picture, whose members are asked for by name.
class Members {
public:
    Members(const core::Metadata& metadata, const fs::path& picture)
        : metadata_(metadata), picture_(picture.string())
    {}

    bool has(const std::string& name) const { return metadata_.count(name) > 0; }
    std::string place(const std::string& name) const { return picture_ + ": " + name; }

    const std::string& text(const std::string& name) const
    {
        const auto found = metadata_.find(name);
        if (found == metadata_.end() || found->second.empty())
            throw core::Error(picture_ + ": does not say its " + name +
                              (has("software") ? "" : " — it was not made by this program"));
        return found->second;
    }

    template <class T> T value(const std::string& name, core::Range range = {}) const
    {
        T result{};
        const std::string& shown = text(name);
        const std::string expected = readValue(shown, range, result);
        if (!expected.empty())
            throw core::Error(place(name) + ": '" + shown + "' is not " + expected);
        return result;
    }

private:
    const core::Metadata& metadata_;
    std::string picture_;
};

/// A file where it was named, seen from here, or beside the picture; one that moved along with the
/// picture is found there by its folder's name or its own. `what` it is, for the message.
fs::path findFile(const char* what, const fs::path& named, const fs::path& picture)
{
    std::vector<fs::path> places{named};
    const fs::path beside = picture.parent_path();
    if (named.is_relative()) places.push_back(beside / named);
    places.push_back(beside / named.parent_path().filename() / named.filename());
    places.push_back(beside / named.filename());
    std::error_code error;
    for (const fs::path& place : places)
        if (fs::is_regular_file(place, error)) return place;
    throw core::Error(picture.string() + ": its " + what + " " + named.string() +
                      " is neither there nor beside the picture — put " +
                      named.filename().string() + " into the picture's folder");
}

/// A panorama where it is now, or the word for something else.
std::string findEnvironment(const std::string& asked, const fs::path& picture)
{
    for (const char* word :
         {core::kOwnEnvironment, core::kAnyEnvironment, core::kNoEnvironment, core::kPlainSky})
        if (asked == word) return asked;
    return findFile("environment", asked, picture).string();
}

core::AnyParams readMethodParams(const Members& members)
{
    const core::MethodInfo* method = core::findMethod(members.text("method"));
    if (method == nullptr)
        throw core::Error(members.place("method") + ": '" + members.text("method") +
                          "' is not one of " + core::methodNames());
    core::AnyParams params = method->defaults;
    const std::string place = members.place("params");
    for (const ParamProblem& problem :
         readParams(parseJson(members.text("params"), place), params, place))
        if (problem.kind != ParamProblem::missing) throw core::Error(problem.text);
    return params;
}

}  // namespace

Replay replayOf(const core::Metadata& metadata, const fs::path& picture)
{
    constexpr core::Range kPixels{1, 65536};
    const Members members(metadata, picture);
    Replay replay;
    const fs::path scene = members.text("scene");
    replay.sceneHash = members.text("scene_hash");
    replay.cameraJson = members.text("camera");
    if (!parseJson(replay.cameraJson, members.place("camera")).is_object())
        throw core::Error(members.place("camera") + ": expected {\"position\": ...}");
    replay.size = {members.value<uint32_t>("width", kPixels),
                   members.value<uint32_t>("height", kPixels)};
    // What was lost on the way is not worth a refusal: a device there is always.
    if (members.has("device") && members.text("device") == "cpu") replay.device = DeviceKind::cpu;
    replay.params = readMethodParams(members);
    replay.samples = members.value<uint64_t>("spp");
    if (members.has("at")) replay.at = members.value<double>("at", {0, 1e9});
    if (members.has("laid_out_at"))
        replay.laidOutAt = members.value<double>("laid_out_at", {0, 1e9});
    replay.follows = members.has("follows");
    if (members.has("environment"))
        replay.environment = findEnvironment(members.text("environment"), picture);
    replay.scene = findFile("scene", scene, picture);
    return replay;
}

Replay readReplay(const fs::path& picture)
{
    return replayOf(core::readMetadata(picture), picture);
}

}  // namespace app

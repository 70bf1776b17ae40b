// Cameras and camera paths as JSON. See camera_file.h.
#include "app/files/camera_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>

#include "app/base/json_file.h"
#include "app/base/nearest.h"
#include "core/base/check.h"

namespace app {

namespace {

using Json = nlohmann::ordered_json;

const std::vector<std::string> kCameraMembers{
    "name",   "position", "target",          "forward",        "up",   "yfov",
    "aspect", "ymag",     "aperture_radius", "focus_distance", "frame"};

const glm::dvec3 kLevel(0, 1, 0);  // up in glTF

constexpr double kMostLength = 1e18;  // as of cameras in glTF
/// Those of glTF go up to 1e6, or are the ratio of two lengths (orthographic).
constexpr double kMostAspect = kMostLength * kMostLength;

/// A place in a file: the file alone, or with a JSON pointer.
struct Place {
    std::string file, pointer;

    Place operator/(const std::string& member) const { return {file, pointer + '/' + member}; }
    [[noreturn]] void fail(const std::string& message) const
    {
        throw core::Error(file + ": " + (pointer.empty() ? "" : pointer + ": ") + message);
    }
};

double readNumber(const Json& json, double low, double high, const Place& place)
{
    const double value = json.is_number() ? json.get<double>() : std::nan("");
    if (!(value >= low && value <= high)) {
        char range[64];
        std::snprintf(range, sizeof range, "a number from %g to %g", low, high);
        place.fail(std::string("expected ") + range);
    }
    return value;
}

glm::dvec3 readVector(const Json& json, const Place& place)
{
    if (!json.is_array() || json.size() != 3) place.fail("expected [x, y, z]");
    glm::dvec3 v;
    for (int i = 0; i < 3; ++i) v[i] = readNumber(json[static_cast<size_t>(i)], -1e30, 1e30, place);
    return v;
}

glm::dvec3 readDirection(const Json& json, const Place& place)
{
    const glm::dvec3 v = readVector(json, place);
    if (!(glm::length(v) > 1e-150)) place.fail("a direction cannot have length zero");
    // What was written by cameraJson is read back to the last bit.
    return std::abs(glm::dot(v, v) - 1) < 1e-14 ? v : glm::normalize(v);
}

/// Near `guess`, the number that `map` takes to `wanted`; `guess` when there is none. Numbers that
/// `map` once made are found again, though rounding took place on the way.
template <class Map> double preimage(double guess, double wanted, Map map)
{
    double below = guess, above = guess;
    for (int i = 0; i < 16; ++i) {
        if (map(below) == wanted) return below;
        if (map(above) == wanted) return above;
        below = std::nextafter(below, -HUGE_VAL);
        above = std::nextafter(above, HUGE_VAL);
    }
    return guess;
}

/// The point of the file's space that becomes exactly `p`, where there is one.
glm::dvec3 pointToFile(const core::Placement& placement, glm::dvec3 p)
{
    const glm::dvec3 guess = placement.toFile(p);
    glm::dvec3 result;
    for (int i = 0; i < 3; ++i)
        result[i] = preimage(guess[i], p[i],
                             [&](double x) { return (x - placement.centre[i]) * placement.scale; });
    return result;
}

double lengthToFile(const core::Placement& placement, double length)
{
    return preimage(length / placement.scale, length,
                    [&](double x) { return x * placement.scale; });
}

/// Rotation whose columns are right, up, backward.
glm::dquat orientation(const core::Camera& camera)
{
    const glm::dvec3 forward = glm::normalize(camera.forward);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
    return glm::normalize(glm::quat_cast(glm::dmat3(right, glm::cross(right, forward), -forward)));
}

/// Change of position per frame at key `i`: the slope between its neighbours.
glm::dvec3 velocity(const std::vector<CameraPath::Key>& keys, size_t i)
{
    const CameraPath::Key& a = keys[i == 0 ? 0 : i - 1];
    const CameraPath::Key& b = keys[std::min(i + 1, keys.size() - 1)];
    return (b.camera.position - a.camera.position) / (b.frame - a.frame);
}

bool isAside(glm::dvec3 forward, glm::dvec3 up)
{
    return glm::length(glm::cross(forward, up)) > 1e-9;
}

/// Two members that say the same thing in different ways: which one was meant is not known.
void refuseBoth(const Json& json, const char* a, const char* b, const Place& place)
{
    if (json.contains(a) && json.contains(b))
        place.fail(std::string("has both \"") + a + "\" and \"" + b + "\" — keep one");
}

/// What a file has said last of members that cameras do not hold as they were said.
struct Said {
    std::optional<glm::dvec3> target;  // in world space; a "forward" ends it
    std::optional<glm::dvec3> up;
};

/// False when nothing is said of where the camera looks.
bool readForward(const Json& json, core::Camera& camera, std::optional<glm::dvec3>& target,
                 const core::Placement& placement, const Place& place)
{
    refuseBoth(json, "target", "forward", place);
    if (json.contains("forward")) {
        camera.forward = readDirection(json["forward"], place / "forward");
        target.reset();
        return true;
    }
    const bool isNew = json.contains("target");
    if (isNew) target = placement.toWorld(readVector(json["target"], place / "target"));
    if (!target) return false;
    const glm::dvec3 towards = *target - camera.position;
    if (!(glm::length(towards) > 1e-12)) {
        if (isNew) (place / "target").fail("is the position itself");
        (place / "position").fail("is the target of a key before — give another, or \"forward\"");
    }
    camera.forward = glm::normalize(towards);
    return true;
}

void readOptics(const Json& json, core::Camera& camera, const core::Placement& placement,
                const Place& place)
{
    refuseBoth(json, "yfov", "ymag", place);
    if (json.contains("yfov")) {
        camera.yfov = glm::radians(readNumber(json["yfov"], 1e-3, 179.9, place / "yfov"));
        camera.orthographic = false;
    }
    if (json.contains("ymag")) {
        camera.ymag =
            readNumber(json["ymag"], 1e-12, kMostLength, place / "ymag") * placement.scale;
        camera.orthographic = true;
    }
    if (json.contains("aspect"))
        camera.aspect = readNumber(json["aspect"], 0, kMostAspect, place / "aspect");
    if (json.contains("aperture_radius"))
        camera.apertureRadius =
            readNumber(json["aperture_radius"], 0, kMostLength, place / "aperture_radius") *
            placement.scale;
    if (json.contains("focus_distance"))
        camera.focusDistance =
            readNumber(json["focus_distance"], 1e-12, kMostLength, place / "focus_distance") *
            placement.scale;
}

}  // namespace

Json vectorJson(glm::dvec3 v)
{
    return Json::array({v.x, v.y, v.z});
}

Json cameraJson(const core::Camera& camera, const core::Placement& placement)
{
    Json json;
    if (!camera.name.empty()) json["name"] = camera.name;
    json["position"] = vectorJson(pointToFile(placement, camera.position));
    json["forward"] = vectorJson(camera.forward);
    json["up"] = vectorJson(camera.up);
    if (camera.orthographic)
        json["ymag"] = lengthToFile(placement, camera.ymag);
    else
        json["yfov"] = preimage(glm::degrees(camera.yfov), camera.yfov,
                                [](double x) { return glm::radians(x); });
    json["aspect"] = camera.aspect;
    json["aperture_radius"] = lengthToFile(placement, camera.apertureRadius);
    json["focus_distance"] = lengthToFile(placement, camera.focusDistance);
    return json;
}

/// A camera as it is described, from `camera` on. Where the file has `said` nothing of "up", a
/// camera that turns is level. What keys say must not depend on how the camera of the key before
/// was rolled: two paths that end in one key end in one view.
static core::Camera readCameraAt(const Json& json, core::Camera camera, Said& said,
                                 const core::Placement& placement, const Place& place)
{
    if (!json.is_object()) place.fail("expected a camera, {\"position\": ...}");
    for (const auto& [name, value] : json.items())
        if (std::find(kCameraMembers.begin(), kCameraMembers.end(), name) == kCameraMembers.end())
            place.fail("a camera has no \"" + name + '"' + suggestion(name, kCameraMembers));
    if (json.contains("name") && json["name"].is_string())
        camera.name = json["name"].get<std::string>();
    if (json.contains("position"))
        camera.position = placement.toWorld(readVector(json["position"], place / "position"));
    const bool turns = readForward(json, camera, said.target, placement, place);
    if (json.contains("up")) said.up = readDirection(json["up"], place / "up");
    if (said.up)
        camera.up = *said.up;
    else if (turns && isAside(camera.forward, kLevel))
        camera.up = kLevel;
    if (!isAside(camera.forward, camera.up))
        (place / "up").fail("is parallel to the direction of view");
    if (std::abs(glm::dot(camera.forward, camera.up)) > 1e-14)
        camera.up =
            glm::cross(glm::normalize(glm::cross(camera.forward, camera.up)), camera.forward);
    readOptics(json, camera, placement, place);
    return camera;
}

core::Camera cameraFromJson(const Json& json, const core::Camera& defaults,
                            const core::Placement& placement, const std::string& file)
{
    Said said;
    return readCameraAt(json, defaults, said, placement, {file, ""});
}

core::Camera readCamera(const std::filesystem::path& file, const core::Camera& defaults,
                        const core::Placement& placement)
{
    return cameraFromJson(readJson(file), defaults, placement, file.string());
}

bool isCameraFile(const std::string& text)
{
    return std::filesystem::path(text).extension() == ".json";
}

core::Camera chooseCamera(const core::World& world, const std::string& text)
{
    CHECK(!world.cameras.empty());
    if (text.empty()) return world.cameras.front();
    if (isCameraFile(text)) return readCamera(text, world.cameras.front(), world.placement);
    std::vector<std::string> names;
    for (const core::Camera& camera : world.cameras) {
        if (camera.name == text) return camera;
        names.push_back(camera.name);
    }
    size_t index = 0;
    const char* end = text.data() + text.size();
    const auto number = std::from_chars(text.data(), end, index);
    if (number.ec == std::errc() && number.ptr == end && index < world.cameras.size())
        return world.cameras[index];
    std::string known;
    for (size_t i = 0; i < std::min<size_t>(names.size(), 20); ++i)
        known += (i ? ", " : "") + std::to_string(i) + " \"" + names[i] + '"';
    throw core::Error("--camera '" + text + "': the scene has no such camera" +
                          suggestion(text, names) + " — it has " + known +
                          "; a file must end in .json",
                      core::ExitCode::commandLine);
}

core::Camera CameraPath::at(double frame) const
{
    CHECK(!keys.empty());
    if (frame <= keys.front().frame) return keys.front().camera;
    if (frame >= keys.back().frame) return keys.back().camera;
    const auto next = std::upper_bound(keys.begin(), keys.end(), frame,
                                       [](double f, const Key& key) { return f < key.frame; });
    const size_t i = static_cast<size_t>(next - keys.begin()) - 1;
    const Key &a = keys[i], &b = keys[i + 1];
    const double length = b.frame - a.frame, t = (frame - a.frame) / length, t2 = t * t,
                 t3 = t2 * t;
    core::Camera camera = a.camera;
    camera.position =
        (2 * t3 - 3 * t2 + 1) * a.camera.position + (t3 - 2 * t2 + t) * length * velocity(keys, i) +
        (3 * t2 - 2 * t3) * b.camera.position + (t3 - t2) * length * velocity(keys, i + 1);
    const glm::dmat3 axes =
        glm::mat3_cast(glm::slerp(orientation(a.camera), orientation(b.camera), t));
    camera.forward = -axes[2];
    camera.up = axes[1];
    camera.yfov = glm::mix(a.camera.yfov, b.camera.yfov, t);
    camera.ymag = glm::mix(a.camera.ymag, b.camera.ymag, t);
    camera.apertureRadius = glm::mix(a.camera.apertureRadius, b.camera.apertureRadius, t);
    camera.focusDistance = glm::mix(a.camera.focusDistance, b.camera.focusDistance, t);
    return camera;
}

CameraPath cameraPathFromJson(const Json& json, const core::Camera& defaults,
                              const core::Placement& placement, const std::string& file)
{
    if (!json.is_object() || !json.contains("keys") || !json["keys"].is_array() ||
        json["keys"].empty())
        throw core::Error(file + ": expected {\"keys\": [{\"frame\": 0, \"position\": ...}, ...]}");
    CameraPath path;
    core::Camera last = defaults;
    Said said;
    for (size_t i = 0; i < json["keys"].size(); ++i) {
        const Place place = Place{file, ""} / "keys" / std::to_string(i);
        const Json& key = json["keys"][i];
        last.name.clear();  // the only member that the next key does not inherit
        last = readCameraAt(key, last, said, placement, place);
        const double frame = key.contains("frame")
                                 ? readNumber(key["frame"], 0, 1e9, place / "frame")
                                 : static_cast<double>(i);
        if (!path.keys.empty() && frame <= path.keys.back().frame)
            (place / "frame").fail("must be after the key before it");
        path.keys.push_back({frame, last});
    }
    return path;
}

CameraPath readCameraPath(const std::filesystem::path& file, const core::Camera& defaults,
                          const core::Placement& placement)
{
    return cameraPathFromJson(readJson(file), defaults, placement, file.string());
}

}  // namespace app

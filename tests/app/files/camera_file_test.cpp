// Cameras as JSON: round trips through the scene's placement, paths through their keys, reported
// mistakes.
#include "app/files/camera_file.h"

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>
#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

namespace {

const core::Placement kPlacement{{100, -20, 3}, 0.25};

core::Camera namedCamera()
{
    core::Camera camera = core::lookAt({1, 2, 3}, {-4, 0.5, 2}, {0.1, 1, 0}, 0.6);
    camera.name = "door";
    camera.aspect = 1.6;
    camera.apertureRadius = 0.01;
    camera.focusDistance = 2.5;
    return camera;
}

void expectNear(const core::Camera& a, const core::Camera& b, double tolerance)
{
    EXPECT_LE(glm::length(a.position - b.position), tolerance);
    EXPECT_LE(glm::length(a.forward - b.forward), tolerance);
    EXPECT_LE(glm::length(a.up - b.up), tolerance);
    EXPECT_NEAR(a.yfov, b.yfov, tolerance);
    EXPECT_NEAR(a.aspect, b.aspect, tolerance);
    EXPECT_NEAR(a.apertureRadius, b.apertureRadius, tolerance);
    EXPECT_NEAR(a.focusDistance, b.focusDistance, tolerance);
    EXPECT_EQ(a.orthographic, b.orthographic);
}

/// The message of a refused camera, empty when it is accepted.
std::string cameraRefusal(const char* text)
{
    try {
        app::cameraFromJson(nlohmann::ordered_json::parse(text), {}, kPlacement, "c.json");
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::badInput);
        return error.what();
    }
    return {};
}

class CameraPathFile : public testing::Test {
protected:
    CameraPathFile()
    {
        folder_ = std::filesystem::path(testing::TempDir()) / "rekindle-camera-path";
        std::filesystem::create_directories(folder_);
    }
    ~CameraPathFile() override { std::filesystem::remove_all(folder_); }

    app::CameraPath read(const std::string& text)
    {
        const std::filesystem::path file = folder_ / "path.json";
        core::writeFile(file, text);
        return app::readCameraPath(file, core::Camera{}, core::Placement{});
    }

private:
    std::filesystem::path folder_;
};

TEST(CameraJson, RoundTripThroughThePlacement)
{
    core::Camera camera = namedCamera();
    const auto json = app::cameraJson(camera, kPlacement);
    EXPECT_NEAR(json["position"][0].get<double>(), 1 / 0.25 + 100, 1e-12);  // in the file's units
    EXPECT_NEAR(json["focus_distance"].get<double>(), 10, 1e-12);
    expectNear(app::cameraFromJson(json, {}, kPlacement, "c"), camera, 1e-12);

    camera.orthographic = true;
    camera.ymag = 3;
    const core::Camera back =
        app::cameraFromJson(app::cameraJson(camera, kPlacement), {}, kPlacement, "c");
    EXPECT_TRUE(back.orthographic);
    EXPECT_NEAR(back.ymag, 3, 1e-12);
}

TEST(CameraJson, EveryAspectThatASceneHasIsReadBack)
{
    core::Camera camera = namedCamera();
    for (const double aspect : {0.0, 1e-18, 20000.0, 1e6, 1e30}) {
        camera.aspect = aspect;
        const core::Camera back =
            app::cameraFromJson(app::cameraJson(camera, kPlacement), {}, kPlacement, "camera.json");
        EXPECT_EQ(back.aspect, aspect);
    }
}

/// glTF has lengths of up to 1e18.
TEST(CameraJson, EveryLengthThatASceneHasIsReadBack)
{
    core::Camera camera;
    camera.orthographic = true;
    camera.ymag = camera.apertureRadius = camera.focusDistance = 1e18;
    const core::Camera back = app::cameraFromJson(app::cameraJson(camera, {}), {}, {}, "c");
    EXPECT_EQ(back.ymag, 1e18);
    EXPECT_EQ(back.apertureRadius, 1e18);
    EXPECT_EQ(back.focusDistance, 1e18);
}

TEST(CameraJson, WhatIsAbsentStays)
{
    const core::Camera camera = namedCamera();
    const auto json = nlohmann::ordered_json::parse(R"({"yfov": 90})");
    core::Camera expected = camera;
    expected.yfov = glm::half_pi<double>();
    expectNear(app::cameraFromJson(json, camera, kPlacement, "c"), expected, 1e-12);
}

TEST(CameraJson, MistakesAreNamed)
{
    EXPECT_NE(cameraRefusal(R"([1,2])").find("expected a camera"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"positon":[0,0,0]})").find("did you mean position"),
              std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"position":[0,0]})").find("/position: expected [x, y, z]"),
              std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"position":[0,0,"x"]})").find("/position"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"position":[1e300,0,0]})").find("/position"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"forward":[0,0,0]})").find("length zero"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"position":[1,2,3],"target":[1,2,3]})").find("position itself"),
              std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"forward":[0,1,0],"up":[0,-2,0]})").find("parallel"),
              std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"yfov":180})").find("/yfov"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"yfov":0})").find("/yfov"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"focus_distance":0})").find("/focus_distance"), std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"target":[1,0,0],"forward":[0,0,-1]})")
                  .find("has both \"target\" and \"forward\" — keep one"),
              std::string::npos);
    EXPECT_NE(cameraRefusal(R"({"yfov":40,"ymag":2})").find("has both \"yfov\" and \"ymag\""),
              std::string::npos);
}

TEST_F(CameraPathFile, PassesThroughItsKeysAndHoldsItsEnds)
{
    const app::CameraPath path = read(R"({"keys": [
        {"frame": 0, "position": [0, 0, 0], "forward": [0, 0, -1], "yfov": 40},
        {"frame": 10, "position": [1, 2, 0], "yfov": 60},
        {"frame": 30, "position": [5, 2, 1], "forward": [1, 0, 0]}]})");
    ASSERT_EQ(path.keys.size(), 3u);
    for (const app::CameraPath::Key& key : path.keys)
        expectNear(path.at(key.frame), key.camera, 1e-12);
    expectNear(path.at(-5), path.keys.front().camera, 0);
    expectNear(path.at(99), path.keys.back().camera, 0);
    EXPECT_NEAR(glm::degrees(path.at(5).yfov), 50, 1e-9);
    // A quarter turn from frame 10 to 30 at even speed: 45 degrees at frame 20.
    const core::Camera middle = path.at(20);
    EXPECT_NEAR(middle.forward.x, std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(middle.forward.z, -std::sqrt(0.5), 1e-9);
    EXPECT_NEAR(glm::dot(middle.forward, middle.up), 0, 1e-12);
}

/// A path on a circle above what it looks at, `step` degrees from key to key, to one last key.
std::string circle(double step, const char* firstUp)
{
    std::string keys;
    for (int i = 12; i >= 0; --i) {
        const double angle = glm::radians(step * i);
        char key[200];
        std::snprintf(key, sizeof key,
                      R"(%s{"frame": %d, "position": [%.17g, 1.5, %.17g], "target": [0, 0, 0]%s})",
                      i == 12 ? "" : ", ", 12 - i, 2 * std::sin(angle), 2 * std::cos(angle),
                      i == 12 ? firstUp : "");
        keys += key;
    }
    return "{\"keys\": [" + keys + "]}";
}

TEST_F(CameraPathFile, PathsThatEndInOneKeyEndInOneView)
{
    const core::Camera level = core::lookAt({0, 1.5, 2}, {0, 0, 0}, {0, 1, 0}, core::Camera{}.yfov);
    for (const double step : {1.0, 4.0, 25.0})
        expectNear(read(circle(step, "")).at(12), level, 1e-15);
    // What a key has said of "up" holds for those after it, too, as it was said.
    const core::Camera tilted =
        core::lookAt({0, 1.5, 2}, {0, 0, 0}, {0.6, 0.8, 0}, core::Camera{}.yfov);
    for (const double step : {1.0, 4.0, 25.0})
        expectNear(read(circle(step, R"(, "up": [0.6, 0.8, 0])")).at(12), tilted, 1e-15);
}

TEST(CameraJson, WhoSaysNothingOfUpIsLevel)
{
    const auto json =
        nlohmann::ordered_json::parse(R"({"position": [0, 0, 0], "target": [2, 1, 0]})");
    const core::Camera level = app::cameraFromJson(json, {}, kPlacement, "c");
    EXPECT_NEAR(glm::cross(level.forward, level.up).y, 0, 1e-15);
    // Whatever view stands behind it: one that looks down, or one that is rolled.
    const core::Camera rolled = core::lookAt({0, 9, 1}, {0, 0, 0}, {1, 0.2, 0}, 0.6);
    EXPECT_EQ(app::cameraFromJson(json, rolled, kPlacement, "c").up, level.up);
    // Straight down there is no level: the view behind it decides.
    const core::Camera down = app::cameraFromJson(
        nlohmann::ordered_json::parse(R"({"forward": [0, -1, 0]})"), rolled, kPlacement, "c");
    EXPECT_NEAR(glm::dot(down.up, down.forward), 0, 1e-15);
    EXPECT_GT(down.up.x, 0.9);
}

/// As every other member: until another is given, or a direction instead.
TEST_F(CameraPathFile, ATargetStaysFromKeyToKey)
{
    const app::CameraPath path = read(R"({"keys": [{"position": [0, 1, 5], "target": [0, 1, 0]},
        {"position": [5, 1, 0]}, {"yfov": 40}, {"position": [0, 9, 1]},
        {"position": [0, 1, 4], "target": [4, 1, 4]}, {"position": [4, 1, 0]},
        {"forward": [0, 0, -1]}, {"position": [7, 7, 7]}]})");
    const auto expectLooks = [&](size_t key, const glm::dvec3& towards) {
        EXPECT_LE(glm::length(path.keys.at(key).camera.forward - glm::normalize(towards)), 1e-15)
            << key;
    };
    expectLooks(0, {0, 0, -1});
    expectLooks(1, {-1, 0, 0});
    expectLooks(2, {-1, 0, 0});
    expectLooks(3, {0, -8, -1});
    expectLooks(4, {1, 0, 0});
    expectLooks(5, {0, 0, 1});
    expectLooks(6, {0, 0, -1});
    expectLooks(7, {0, 0, -1});
    EXPECT_NEAR(path.keys[1].camera.up.y, 1, 1e-15) << "level, as with a target of its own";
    try {
        read(
            R"({"keys": [{"position": [0, 0, 1], "target": [1, 2, 3]}, {"position": [1, 2, 3]}]})");
        ADD_FAILURE() << "accepted";
    } catch (const core::Error& error) {
        EXPECT_NE(std::string(error.what()).find("/keys/1/position: is the target of a key before"),
                  std::string::npos)
            << error.what();
    }
}

TEST_F(CameraPathFile, StraightKeysMakeASteadyStraightLine)
{
    const app::CameraPath path = read(R"({"keys": [{"position": [0, 0, 0]}, {"position": [2, 0, 0]},
                                                   {"position": [4, 0, 0]}, {"position": [6, 0, 0]}]})");
    for (double frame = 0; frame <= 3; frame += 0.125) {
        EXPECT_NEAR(path.at(frame).position.x, 2 * frame, 1e-12);
        EXPECT_NEAR(path.at(frame).position.y, 0, 1e-12);
    }
}

TEST_F(CameraPathFile, VelocityIsContinuousAtKeys)
{
    const app::CameraPath path = read(R"({"keys": [{"frame": 0, "position": [0, 0, 0]},
        {"frame": 4, "position": [1, 3, 0]}, {"frame": 6, "position": [5, 3, 2]}, {"frame": 20, "position": [5, 9, 2]}]})");
    constexpr double h = 1e-5;
    for (const double frame : {4.0, 6.0}) {
        const glm::dvec3 before = (path.at(frame).position - path.at(frame - h).position) / h;
        const glm::dvec3 after = (path.at(frame + h).position - path.at(frame).position) / h;
        EXPECT_LE(glm::length(before - after), 1e-3 * glm::length(before));
    }
}

TEST_F(CameraPathFile, MistakesAreRefused)
{
    EXPECT_THROW(read("{"), core::Error);
    EXPECT_THROW(read("[]"), core::Error);
    EXPECT_THROW(read(R"({"keys": []})"), core::Error);
    EXPECT_THROW(read(R"({"keys": [{"frame": 3}, {"frame": 3}]})"), core::Error);
    EXPECT_THROW(read(R"({"keys": [{"frame": -1}]})"), core::Error);
    EXPECT_THROW(read(R"({"keys": [{"yfov": 40}, {"yfov": 40, "ymag": 2}]})"), core::Error);
    EXPECT_THROW(app::readCameraPath("/nonexistent/path.json", {}, {}), core::Error);
}

}  // namespace

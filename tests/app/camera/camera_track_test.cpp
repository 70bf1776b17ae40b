// A camera path under edit: keys keep their order, playing ends or wraps where it should, files
// restore what was saved.
#include "app/camera/camera_track.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/camera/navigation.h"
#include "core/base/check.h"
#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/statistics/no_numbers.h"

namespace {

using app::CameraTrack;
using tests::kDoubleNan;

core::Camera cameraAt(double x)
{
    return core::lookAt({x, 1, 4}, {0, 0.3, 0}, {0, 1, 0}, 0.7);
}

/// Keys at the given frames, each from a place of its own.
CameraTrack track(std::initializer_list<double> frames)
{
    CameraTrack t;
    for (const double frame : frames) t.addAt(frame, cameraAt(frame));
    return t;
}

std::vector<double> frames(const CameraTrack& t)
{
    std::vector<double> list;
    for (const auto& key : t.keys()) list.push_back(key.frame);
    return list;
}

using Frames = std::vector<double>;

TEST(CameraTrack, KeysFollowASecondApart)
{
    CameraTrack t;
    EXPECT_TRUE(t.empty());
    t.add(cameraAt(0));
    t.add(cameraAt(1));
    t.framesPerSecond = 30;
    t.add(cameraAt(2));
    EXPECT_EQ(frames(t), (Frames{0, 24, 54}));
    t.framesPerSecond = 0.2;
    t.add(cameraAt(3));
    t.framesPerSecond = kDoubleNan;
    t.add(cameraAt(4));
    EXPECT_EQ(frames(t), (Frames{0, 24, 54, 55, 79}));
    EXPECT_EQ(t.keys()[2].camera, cameraAt(2));
}

TEST(CameraTrack, KeysStayInOrderNoTwoOnOneFrame)
{
    CameraTrack t = track({10, 0, 5});
    EXPECT_EQ(frames(t), (Frames{0, 5, 10}));
    t.addAt(5, cameraAt(99));
    EXPECT_EQ(frames(t), (Frames{0, 5, 10}));
    EXPECT_EQ(t.keys()[1].camera, cameraAt(99));
    EXPECT_EQ(t.move(1, 20), 2u);
    EXPECT_EQ(frames(t), (Frames{0, 10, 20}));
    EXPECT_EQ(t.keys()[2].camera, cameraAt(99));
    EXPECT_EQ(t.move(2, 4), 1u);
    EXPECT_EQ(t.keys()[1].camera, cameraAt(99));
    EXPECT_EQ(t.move(1, 10), 1u);  // taken
    EXPECT_EQ(t.move(1, 4), 1u);
    EXPECT_EQ(frames(t), (Frames{0, 4, 10}));
    t.replace(0, cameraAt(7));
    EXPECT_EQ(t.keys()[0].camera, cameraAt(7));
    t.remove(1);
    EXPECT_EQ(frames(t), (Frames{0, 10}));
    t.clear();
    EXPECT_TRUE(t.empty());
    EXPECT_EQ(t.firstFrame(), 0);
    EXPECT_EQ(t.lastFrame(), 0);
}

TEST(CameraTrack, NonsenseIsIgnored)
{
    CameraTrack t = track({0, 10});
    for (const double bad : {kDoubleNan, -1.0, 2e9, std::numeric_limits<double>::infinity()}) {
        t.addAt(bad, cameraAt(1));
        EXPECT_EQ(t.move(0, bad), 0u);
    }
    t.remove(2);
    t.replace(7, cameraAt(1));
    EXPECT_EQ(t.move(2, 3), 2u);
    t.seek(kDoubleNan);
    t.play();
    EXPECT_FALSE(t.advance(kDoubleNan));
    EXPECT_FALSE(t.advance(-1));
    EXPECT_FALSE(t.advance(0));
    EXPECT_EQ(frames(t), (Frames{0, 10}));
    EXPECT_EQ(t.frame(), 0);
}

TEST(CameraTrack, PlaysToItsEndOnce)
{
    CameraTrack t = track({6, 30});
    t.loop = false;
    EXPECT_FALSE(t.advance(1));  // not playing
    t.play();
    EXPECT_TRUE(t.playing());
    EXPECT_TRUE(t.advance(0.5));
    EXPECT_EQ(t.frame(), 18);
    EXPECT_TRUE(t.advance(9));
    EXPECT_EQ(t.frame(), 30);
    EXPECT_FALSE(t.playing());
    t.play();  // again from the start
    EXPECT_EQ(t.frame(), 6);
    t.advance(0.25);
    t.stop();
    t.play();  // from where it was
    EXPECT_EQ(t.frame(), 12);
}

TEST(CameraTrack, Loops)
{
    CameraTrack t = track({6, 30});
    t.play();
    double frame = 6;
    for (int i = 0; i < 100; ++i) {
        EXPECT_TRUE(t.advance(0.3));
        frame += 0.3 * 24;
        while (frame >= 30) frame -= 24;
        EXPECT_NEAR(t.frame(), frame, 1e-9);
        EXPECT_TRUE(t.playing());
    }
    t.advance(1e7);  // after a long sleep, too
    EXPECT_GE(t.frame(), 6);
    EXPECT_LT(t.frame(), 30);
}

TEST(CameraTrack, NothingToPlay)
{
    for (CameraTrack t : {track({}), track({5})}) {
        t.play();
        EXPECT_FALSE(t.playing());
        EXPECT_FALSE(t.advance(1));
        t.seek(3);
        EXPECT_EQ(t.frame(), t.firstFrame());
    }
    CameraTrack t = track({0, 10});
    t.play();
    t.seek(99);
    EXPECT_EQ(t.frame(), 10);
    t.remove(1);  // while it plays
    EXPECT_FALSE(t.playing());
    EXPECT_EQ(t.frame(), 0);
}

TEST(CameraTrack, SavedAndLoadedToTheBit)
{
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = folder / "path.json";
    const core::Placement placements[] = {{}, {{128, -16.5, 3}, 0.25}, {{-5000, 1, 0.125}, 64}};
    std::mt19937 engine(3);
    std::uniform_real_distribution<double> some(-1, 1);
    for (const core::Placement& placement : placements) {
        CameraTrack t;
        t.framesPerSecond = 29.97;
        t.loop = false;
        for (int i = 0; i < 50; ++i) {
            app::Navigation n;
            core::Camera camera = cameraAt(some(engine));
            if (i % 3 == 0) camera.name = "key " + std::to_string(i);
            camera.orthographic = i % 7 == 0;
            camera.apertureRadius = i % 2 == 0 ? 0.01 * std::abs(some(engine)) : 0;
            camera.focusDistance = 2 + some(engine);
            n.set(camera, 3);
            n.orbit(some(engine), some(engine));
            n.dolly(some(engine));
            t.addAt(i + 0.25 * some(engine) + 0.25, n.camera());
        }
        t.save(file, placement);
        CameraTrack once;
        once.load(file, {}, placement);
        EXPECT_EQ(once.framesPerSecond, 29.97);
        EXPECT_FALSE(once.loop);
        ASSERT_EQ(once.keys().size(), t.keys().size());
        const double unit = 1e-15 * (glm::length(placement.centre) * placement.scale + 10);
        for (size_t i = 0; i < t.keys().size(); ++i) {
            const core::Camera &a = t.keys()[i].camera, &b = once.keys()[i].camera;
            EXPECT_EQ(a.name, b.name);
            EXPECT_EQ(a.forward, b.forward);
            EXPECT_EQ(a.up, b.up);
            EXPECT_EQ(a.apertureRadius, b.apertureRadius);
            EXPECT_EQ(a.focusDistance, b.focusDistance);
            EXPECT_EQ(a.orthographic, b.orthographic);
            EXPECT_EQ(t.keys()[i].frame, once.keys()[i].frame);
            // The file's space is coarser far from its origin: one rounding, and only once.
            EXPECT_LE(glm::distance(a.position, b.position), unit);
            EXPECT_NEAR(a.yfov, b.yfov, 2e-16);
        }
        once.save(file, placement);
        CameraTrack twice;
        twice.load(file, {}, placement);
        for (size_t i = 0; i < t.keys().size(); ++i)
            EXPECT_EQ(once.keys()[i].camera, twice.keys()[i].camera) << i;
    }
}

TEST(CameraTrack, OneThatIsClearedHasNoFile)
{
    const tests::TemporaryFolder folder;
    CameraTrack t = track({0, 24});
    t.save(folder / "path.json", {});
    EXPECT_EQ(t.file(), folder / "path.json");
    EXPECT_FALSE(t.unsaved());
    t.clear();
    EXPECT_TRUE(t.file().empty()) << "another path may not replace it unasked";
    EXPECT_FALSE(t.unsaved());
    for (const double frame : {0.0, 24.0}) t.addAt(frame, cameraAt(frame));
    EXPECT_TRUE(t.unsaved());
}

TEST(CameraTrack, FilesOfTheCommandLineAreReadAndBadOnesChangeNothing)
{
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = folder / "path.json";
    core::writeFile(file, R"({"keys": [{"position": [0, 0, 5]}, {"frame": 9, "yfov": 30}]})");
    CameraTrack t = track({1, 2, 3});
    t.framesPerSecond = 12;
    t.play();
    t.load(file, cameraAt(0), {});
    EXPECT_EQ(frames(t), (Frames{0, 9}));
    EXPECT_EQ(t.framesPerSecond, 12);  // it names none
    EXPECT_FALSE(t.playing());
    EXPECT_EQ(t.frame(), 0);
    for (const char* bad : {"", "[]", R"({"keys": []})", R"({"keys": [{"yfov": 0}]})",
                            R"({"keys": [{"yfov": 1e999}]})", R"({"keys": [{}], "loop": 1})",
                            R"({"keys": [{}], "frames_per_second": 0})",
                            R"({"keys": [{}], "frames_per_second": "24"})"}) {
        core::writeFile(file, bad);
        EXPECT_THROW(t.load(file, cameraAt(0), {}), core::Error) << bad;
        EXPECT_EQ(frames(t), (Frames{0, 9})) << bad;
        EXPECT_EQ(t.framesPerSecond, 12);
    }
    EXPECT_THROW(t.load(folder / "none.json", cameraAt(0), {}), core::Error);
    EXPECT_THROW(CameraTrack().save(file, {}), core::Error);
    EXPECT_THROW(t.save("/proc/none/path.json", {}), core::Error);
}

}  // namespace

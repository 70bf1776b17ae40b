// The window's loop when its own device is lost: once in a while it goes on, else it ends and keeps
// what a question would have named.
#include "app/view/frame_loop.h"

#include <filesystem>
#include <fstream>
#include <set>

#include "core/base/check.h"
#include "tests/support/files/source_folder.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/window_fixture.h"

namespace {

using namespace tests;
namespace fs = std::filesystem;

std::set<int> lossesAtPresents;  // the calls at which the window's device is lost
int presents = 0;

/// The window's loop in a folder of its own, with a script that draws every frame anew.
class FrameLoopTest : public WindowFixture {
protected:
    void SetUp() override
    {
        WindowFixture::SetUp();
        fs::current_path(folder.path());
        gpu::vk.QueuePresentKHR = [](auto queue, auto info) {
            const VkResult result = vkQueuePresentKHR(queue, info);
            return lossesAtPresents.contains(presents++) ? VK_ERROR_DEVICE_LOST : result;
        };
    }
    ~FrameLoopTest() override { fs::current_path(before_); }

    /// Two keys of a camera path, then `frames` frames.
    int run(const std::set<int>& losses, int frames)
    {
        lossesAtPresents = losses;
        presents = 0;
        std::ofstream("script.json")
            << R"({"steps": [{"wait": "loaded"}, {"do": "add-key", "frame": 0},
                             {"do": "orbit", "dx": 0.1}, {"do": "add-key", "frame": 24},
                             {"repeat": )"
            << frames / 2 << R"(, "steps": [{"do": "set", "name": "exposure", "value": 1},
                                            {"do": "set", "name": "exposure", "value": 0}]}]})";
        app::ViewOptions options;
        options.scene.file = kAssets / "cornell-diffuse.gltf";
        options.device = app::DeviceKind::cpu;
        options.noSettings = options.noCache = true;
        options.size = {160, 120};
        options.script = "script.json";
        testing::internal::CaptureStdout();
        int code = -1;
        try {
            code = app::FrameLoop(options).run();
        } catch (const core::Error& error) {
            EXPECT_EQ(error.code(), core::ExitCode::deviceLost);
        }
        testing::internal::GetCapturedStdout();
        return code;
    }

    TemporaryFolder folder;

private:
    fs::path before_ = fs::current_path();
};

TEST_F(FrameLoopTest, ALossNowAndThenIsNoEnd)
{
    EXPECT_EQ(run({60, 175}, 200), 0);
    EXPECT_GT(presents, 176) << "the test needs both losses";
    EXPECT_EQ(folder.count(), 1u) << "the script: a path may be lost by its end";
}

TEST_F(FrameLoopTest, ALossAfterALossEndsItAndLosesNothingElse)
{
    EXPECT_EQ(run({60, 75}, 200), -1);
    EXPECT_EQ(presents, 76);
    EXPECT_EQ(folder.count(), 2u) << "the script and the camera path";
}

}  // namespace

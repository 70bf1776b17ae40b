// What a person sees on stderr: lines in a file, a bar that keeps its place on a terminal.
#include <chrono>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "app/base/log.h"
#include "tests/support/files/text_search.h"

namespace {

using testing::internal::CaptureStderr;
using testing::internal::GetCapturedStderr;
using tests::countOf;

/// After the silent beginning of a stage.
void work(app::Log& log)
{
    log.progress("building", 0.1);
    std::this_thread::sleep_for(std::chrono::milliseconds(550));
    log.progress("building", 0.5);
    log.progress("building", 0.51);  // too soon to be read
    log.line("a line");
    std::this_thread::sleep_for(std::chrono::milliseconds(120));
    log.progress("building", 0.75);
}

TEST(Log, AnUnknownShareIsNoNumber)
{
    CaptureStderr();
    {
        app::Log log(false, false);
        log.progress("placing meshes", core::kUnknownShare);
        std::this_thread::sleep_for(std::chrono::milliseconds(550));
        log.progress("placing meshes", core::kUnknownShare);
    }
    EXPECT_EQ(GetCapturedStderr(), "placing meshes ...\n");
}

TEST(Log, InAFileProgressIsLinesOfPlainText)
{
    CaptureStderr();
    {
        app::Log log(false, false);
        work(log);
    }
    EXPECT_EQ(GetCapturedStderr(), "building: 50 %\na line\n");
}

TEST(Log, OnATerminalTheBarKeepsItsPlaceAndLinesStandAlone)
{
    CaptureStderr();
    {
        app::Log log(false, true);
        work(log);
    }
    const std::string text = GetCapturedStderr();
    EXPECT_EQ(countOf(text, "█"), 15u + 23u) << text;
    EXPECT_EQ(countOf(text, "░"), 15u + 7u) << text;
    EXPECT_NE(text.find("50 %  building"), std::string::npos);
    EXPECT_EQ(text.find("51 %"), std::string::npos);
    EXPECT_NE(text.find("\r\033[Ka line\n"), std::string::npos) << "the bar must go before a line";
    EXPECT_EQ(countOf(text, "\n"), 1u);
    EXPECT_TRUE(text.ends_with("\r\033[K")) << "nothing of the bar is left at the end";
}

TEST(Log, QuietSaysNothingButWarnings)
{
    CaptureStderr();
    {
        app::Log log(true, true);
        work(log);
        log.warning("look");
    }
    EXPECT_EQ(GetCapturedStderr(), "warning: look\n");
}

TEST(Log, StderrOfTestsIsNoTerminal)
{
    CaptureStderr();
    EXPECT_FALSE(app::Log::onTerminal());
    GetCapturedStderr();
}

}  // namespace

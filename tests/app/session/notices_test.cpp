// Messages of the window: kept in order, counted when equal, never more than fit, from any thread.
#include "app/session/notices.h"

#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace {

using app::Notice, app::Notices, app::Severity;

TEST(Notices, KeepsThemInOrder)
{
    Notices notices;
    notices.quiet = true;
    EXPECT_EQ(notices.count(), 0u);
    notices.tell(Severity::news, "loaded");
    notices.tell(Severity::error, "a.gltf: no such file\nlook elsewhere");
    const std::vector<Notice> list = notices.list();
    ASSERT_EQ(list.size(), 2u);
    EXPECT_EQ(list[0].number, 1u);
    EXPECT_EQ(list[0].severity, Severity::news);
    EXPECT_EQ(list[1].number, 2u);
    EXPECT_EQ(list[1].severity, Severity::error);
    EXPECT_EQ(list[1].text, "a.gltf: no such file\nlook elsewhere");
    EXPECT_GE(list[1].seconds, list[0].seconds);
    EXPECT_GT(list[0].seconds, 0);
}

TEST(Notices, EqualOnesInARowAreCounted)
{
    Notices notices;
    notices.quiet = true;
    for (int i = 0; i < 1000; ++i) notices.tell(Severity::warning, "device lost");
    ASSERT_EQ(notices.list().size(), 1u);
    EXPECT_EQ(notices.list()[0].times, 1000u);
    EXPECT_EQ(notices.list()[0].number, 1000u);  // so that whoever has seen 999 hears of it
    EXPECT_EQ(notices.count(), 1000u);
    notices.tell(Severity::error, "device lost");  // not the same
    notices.tell(Severity::warning, "device lost");
    EXPECT_EQ(notices.list().size(), 3u);
}

TEST(Notices, TheOldestGoAndNumbersGoOn)
{
    Notices notices;
    notices.quiet = true;
    for (int i = 1; i <= 1234; ++i) notices.tell(Severity::news, std::to_string(i));
    ASSERT_EQ(notices.list().size(), 500u);
    EXPECT_EQ(notices.list().front().text, "735");
    EXPECT_EQ(notices.list().back().text, "1234");
    notices.clear();
    EXPECT_TRUE(notices.list().empty());
    EXPECT_EQ(notices.count(), 1234u);
    notices.tell(Severity::news, "again");
    EXPECT_EQ(notices.list().back().number, 1235u);
}

TEST(Notices, GoesToStderrOnceUnlessQuiet)
{
    Notices notices;
    testing::internal::CaptureStderr();
    notices.tell(Severity::error, "a: b");
    notices.tell(Severity::error, "a: b");
    notices.tell(Severity::news, "c");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "error: a: b\nc\n");
    notices.quiet = true;
    testing::internal::CaptureStderr();
    notices.tell(Severity::error, "d");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(Notices, FromManyThreads)
{
    Notices notices;
    notices.quiet = true;
    {
        std::vector<std::jthread> threads;
        for (int t = 0; t < 4; ++t)
            threads.emplace_back([&notices, t] {
                for (int i = 0; i < 500; ++i) {
                    notices.tell(Severity::news, std::to_string(t) + ' ' + std::to_string(i));
                    if (i % 50 == 0) notices.list();
                }
            });
    }
    EXPECT_EQ(notices.count(), 2000u);
    const std::vector<Notice> list = notices.list();
    ASSERT_EQ(list.size(), 500u);
    for (size_t i = 1; i < list.size(); ++i) EXPECT_EQ(list[i].number, list[i - 1].number + 1);
}

TEST(Notices, FilesAreNamedWithTheirWholePath)
{
    Notices notices;
    notices.quiet = true;
    notices.tell(Severity::news, "saved", "pictures/../a.png");
    notices.tell(Severity::news, "saved", "b.png");
    notices.tell(Severity::news, "saved");
    const std::vector<Notice> list = notices.list();
    ASSERT_EQ(list.size(), 3u) << "of three files, one of which is none";
    EXPECT_EQ(list[0].file, (std::filesystem::current_path() / "a.png").string());
    EXPECT_EQ(list[1].file, app::wholePath("b.png"));
    EXPECT_EQ(list[2].file, "");
    EXPECT_EQ(app::wholePath("/tmp/x.png"), "/tmp/x.png");
}

}  // namespace

// Going back to views that one has rested at, and forward again.
#include "app/camera/view_history.h"

#include <gtest/gtest.h>

namespace {

using app::ViewHistory;
using app::Viewpoint;

Viewpoint viewpointAt(double x)
{
    Viewpoint v;
    v.camera.position = {x, 0, 0};
    return v;
}

double xOf(const std::optional<Viewpoint>& v)
{
    return v ? v->camera.position.x : -1;
}

/// As a window would: a view for so many seconds, sixty times each.
void rest(ViewHistory& history, double x, double seconds, double& now)
{
    for (int i = 0; i < seconds * 60; ++i) history.observe(viewpointAt(x), now += 1.0 / 60);
}

TEST(ViewHistory, RemembersWhereOneRestedNotWhereOnePassed)
{
    ViewHistory history;
    double now = 0;
    rest(history, 1, 1, now);
    for (int i = 0; i < 100; ++i) rest(history, 2 + i, 0.1, now);
    rest(history, 500, 1, now);
    EXPECT_EQ(xOf(history.back(viewpointAt(500))), 1);
    EXPECT_EQ(xOf(history.back(viewpointAt(1))), -1) << "there is nothing before the first";
    EXPECT_EQ(xOf(history.forward(viewpointAt(1))), 500);
    EXPECT_EQ(xOf(history.forward(viewpointAt(500))), -1);
}

TEST(ViewHistory, EveryStepCanBeTakenBackAlsoFromAViewThatHasNotSettled)
{
    ViewHistory history;
    double now = 0;
    rest(history, 1, 1, now);
    rest(history, 2, 1, now);
    EXPECT_EQ(xOf(history.back(viewpointAt(3))), 2);
    EXPECT_EQ(xOf(history.forward(viewpointAt(2))), 3);
    EXPECT_EQ(xOf(history.back(viewpointAt(3))), 2);
    rest(history, 2, 2, now);  // resting where one went back to adds nothing
    EXPECT_EQ(xOf(history.back(viewpointAt(2))), 1);
    rest(history, 7, 1, now);  // another way from there
    EXPECT_EQ(xOf(history.forward(viewpointAt(7))), -1);
    EXPECT_EQ(xOf(history.back(viewpointAt(7))), 1);
}

TEST(ViewHistory, IsARing)
{
    ViewHistory history;
    double now = 0;
    for (int i = 0; i < 1000; ++i) rest(history, i, 0.6, now);
    int steps = 0;
    double x = 999;
    for (auto v = history.back(viewpointAt(x)); v; v = history.back(viewpointAt(x))) {
        EXPECT_EQ(xOf(v), x - 1);
        x = xOf(v);
        ++steps;
    }
    EXPECT_EQ(steps, 63);
    history.clear();
    EXPECT_EQ(xOf(history.back(viewpointAt(x))), -1);
}

TEST(ViewHistory, AnotherPivotIsNoOtherView)
{
    ViewHistory history;
    Viewpoint turned = viewpointAt(1);
    history.settle(viewpointAt(1));
    turned.pivot = {5, 5, 5};
    turned.camera.name = "kept";
    EXPECT_EQ(xOf(history.back(turned)), -1);
}

}  // namespace

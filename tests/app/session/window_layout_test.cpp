// Where things stand in the window: the areas never overlap and leave nothing out, whatever the
// window and the settings; and where a picture of another shape is shown.
#include "app/session/window_layout.h"

#include <cmath>

#include <gtest/gtest.h>

#include "app/camera/navigation.h"

namespace {

using app::Area;
using app::layOut;
using app::PanelFold;
using app::PanelParams;
using app::PanelSide;
using app::WindowLayout;

float surface(const Area& area)
{
    return area.size.x * area.size.y;
}

bool overlap(const Area& a, const Area& b)
{
    return !a.empty() && !b.empty() && a.corner.x < b.end().x && b.corner.x < a.end().x &&
           a.corner.y < b.end().y && b.corner.y < a.end().y;
}

TEST(WindowLayout, AreasShareTheWindowAndNoneLiesOverAnother)
{
    for (const glm::vec2 window : {glm::vec2(1280, 720),
                                   {640, 360},
                                   {320, 200},
                                   {3840, 2160},
                                   {1300, 130},
                                   {97, 701},
                                   {40, 30},
                                   {1, 1},
                                   {811.6f, 453.2f}})
        for (const float letter : {0.0f, 13.0f, 15.0f, 37.5f})
            for (const PanelSide side : {PanelSide::left, PanelSide::right})
                for (const PanelFold fold :
                     {PanelFold::automatic, PanelFold::open, PanelFold::folded})
                    for (const float width : {0.0f, 1.0f, 18.0f, 400.0f})
                        for (const bool shown : {true, false}) {
                            PanelParams panels;
                            panels.panel = shown;
                            panels.side = side;
                            panels.fold = fold;
                            panels.width = width;
                            const WindowLayout l = layOut(window, letter, panels);
                            SCOPED_TRACE(testing::Message() << window.x << 'x' << window.y << ' '
                                                            << letter << ' ' << width);
                            EXPECT_FALSE(overlap(l.picture, l.panel));
                            EXPECT_FALSE(overlap(l.picture, l.status));
                            EXPECT_FALSE(overlap(l.panel, l.status));
                            EXPECT_EQ(surface(l.picture) + surface(l.panel) + surface(l.status),
                                      l.window.x * l.window.y);
                            EXPECT_GE(l.picture.size.x, 1);
                            EXPECT_GE(l.picture.size.y, 1);
                            for (const Area& a : {l.picture, l.panel, l.status}) {
                                EXPECT_EQ(a.corner, glm::floor(a.corner));
                                EXPECT_EQ(a.size, glm::floor(a.size));
                                EXPECT_LE(a.end().x, l.window.x);
                                EXPECT_LE(a.end().y, l.window.y);
                            }
                            if (!shown || fold == PanelFold::folded) {
                                EXPECT_TRUE(l.panel.empty());
                            }
                        }
}

TEST(WindowLayout, ThePictureHasWhatThePanelGivesUp)
{
    PanelParams panels;
    const WindowLayout open = layOut({1280, 720}, 15, panels);
    EXPECT_EQ(open.picture.corner.x, open.panel.size.x);
    EXPECT_GT(open.panel.size.x, 300);
    panels.side = PanelSide::right;
    const WindowLayout right = layOut({1280, 720}, 15, panels);
    EXPECT_EQ(right.picture.corner, glm::vec2(0));
    EXPECT_EQ(right.picture.size, open.picture.size);
    EXPECT_EQ(right.panel.corner.x, right.picture.end().x);
    panels.fold = PanelFold::folded;
    EXPECT_EQ(layOut({1280, 720}, 15, panels).picture.size.x, 1280);
    panels.panel = false;
    EXPECT_EQ(layOut({1280, 720}, 15, panels).picture.size, glm::vec2(1280, 720));
}

TEST(WindowLayout, NarrowWindowsBeginFoldedAndSmallOnesShowThePictureAlone)
{
    PanelParams panels;
    EXPECT_TRUE(layOut({320, 200}, 13, panels).panel.empty());
    EXPECT_FALSE(layOut({320, 200}, 13, panels).status.empty());
    panels.fold = PanelFold::open;
    EXPECT_FALSE(layOut({320, 200}, 13, panels).panel.empty());
    EXPECT_EQ(layOut({100, 200}, 13, panels).picture.size, glm::vec2(100, 200));
    EXPECT_TRUE(app::hasRoomForText({320, 200}, 13));
    EXPECT_FALSE(app::hasRoomForText({100, 200}, 13));
    EXPECT_TRUE(app::hasRoomForText(app::roomForQuestion(13), 13));
}

TEST(WindowLayout, ADraggedEdgeStaysUnderTheHand)
{
    for (const PanelSide side : {PanelSide::left, PanelSide::right})
        for (const float x : {400.0f, 555.0f, 700.0f}) {
            PanelParams panels;
            panels.side = side;
            panels.width = app::panelWidthAt(x, 1280, 15, side);
            const WindowLayout l = layOut({1280, 720}, 15, panels);
            EXPECT_NEAR(side == PanelSide::left ? l.panel.end().x : l.panel.corner.x, x, 1);
        }
}

TEST(WindowLayout, FractionsAreThoseOfTheArea)
{
    const Area area{{375, 0}, {905, 690}};
    EXPECT_EQ(area.fraction({375, 690}), glm::dvec2(0, 1));
    EXPECT_TRUE(area.contains({375, 0}));
    EXPECT_FALSE(area.contains({374, 0}));
    EXPECT_FALSE(area.contains({1280, 0}));
    EXPECT_EQ(Area().fraction({3, 4}), glm::dvec2(0));
}

TEST(PicturePlace, APictureOfAnotherShapeIsSeenWholeInTheMiddle)
{
    const Area all{{0, 0}, {1, 1}};
    EXPECT_EQ(app::whole({905, 690}, {905, 690}), all);
    EXPECT_EQ(app::whole({113, 86}, {905, 690}), all) << "rounded to whole pixels";
    EXPECT_EQ(app::whole({1, 1}, {1, 1}), all);
    const Area wide = app::whole({200, 100}, {100, 100});
    EXPECT_EQ(wide.corner, glm::vec2(0, 0.25f));
    EXPECT_EQ(wide.size, glm::vec2(1, 0.5f));
    const Area high = app::whole({100, 200}, {400, 200});
    EXPECT_EQ(high.corner, glm::vec2(0.375f, 0));
    EXPECT_EQ(high.size, glm::vec2(0.25f, 1));
}

/// In [0,1]^2 of a picture of that shape.
glm::dvec2 seen(const core::Camera& camera, glm::dvec3 point, double aspect)
{
    const glm::dvec3 offset = point - camera.position;
    const double half = camera.orthographic
                            ? camera.ymag
                            : glm::dot(offset, camera.forward) * std::tan(0.5 * camera.yfov);
    return {0.5 + 0.5 * glm::dot(offset, glm::cross(camera.forward, camera.up)) / half / aspect,
            0.5 - 0.5 * glm::dot(offset, camera.up) / half};
}

/// What is in the old picture is drawn where the next one will have it, whatever the camera's own
/// frame, the old area and the new one.
TEST(PicturePlace, WhatIsInBothPicturesStaysInItsPlace)
{
    for (const bool orthographic : {false, true})
        for (const double frame : {0.0, 1.0, 16.0 / 9, 2.4})
            for (const glm::uvec2 before : {glm::uvec2(905, 690), {1280, 720}, {300, 600}})
                for (const glm::uvec2 after : {glm::uvec2(905, 690), {1280, 720}, {500, 200}}) {
                    core::Camera camera = core::lookAt({3, 1, 4}, {0, 0.5, 0}, {0, 1, 0}, 0.7);
                    camera.aspect = frame;
                    camera.orthographic = orthographic;
                    camera.ymag = 1.3;
                    const double old = double(before.x) / before.y, now = double(after.x) / after.y;
                    const core::Camera of = app::framed(camera, old);
                    const core::Camera next = app::framed(camera, now);
                    const Area place = app::kept(before, of, after, next);
                    for (const glm::dvec3 point : {glm::dvec3(0, 0.5, 0), {0.4, 0.9, 0.2}}) {
                        const glm::dvec2 drawn = glm::dvec2(place.corner) +
                                                 seen(of, point, old) * glm::dvec2(place.size);
                        const glm::dvec2 will = seen(next, point, now);
                        EXPECT_NEAR(drawn.x, will.x, 0.004);
                        EXPECT_NEAR(drawn.y, will.y, 0.004);
                    }
                }
}

TEST(PlaceBar, DoesNotLieUnderWhatIsThere)
{
    const Area area{{100, 50}, {800, 600}};
    const glm::vec2 size(300, 60);
    const float gap = 10;
    const auto placed = [&](const Area& taken) {
        const Area bar = app::placeBar(area, size, 150, taken, gap);
        EXPECT_GE(bar.corner.x, area.corner.x);
        EXPECT_GE(bar.corner.y, area.corner.y);
        EXPECT_LE(bar.end().x, area.end().x);
        EXPECT_LE(bar.end().y, area.end().y);
        const bool apart = bar.end().x <= taken.corner.x || bar.corner.x >= taken.end().x ||
                           bar.end().y <= taken.corner.y || bar.corner.y >= taken.end().y;
        EXPECT_TRUE(taken.empty() || apart);
        return bar;
    };
    const Area usual = placed({});
    EXPECT_EQ(usual, (Area{{110, 580}, {300, 60}}));
    EXPECT_EQ(placed({{500, 300}, {390, 340}}), usual) << "it is in nobody's way";
    const Area narrow = placed({{350, 300}, {540, 340}});
    EXPECT_EQ(narrow, (Area{{110, 580}, {230, 60}}));
    EXPECT_EQ(placed({{110, 300}, {400, 340}}).end().x, 890) << "at the other side";
    EXPECT_EQ(placed({{110, 300}, {780, 340}}), (Area{{110, 230}, {300, 60}})) << "above it";
    // Nowhere: all the same in its place, and never outside.
    EXPECT_EQ(app::placeBar(area, size, 150, area, gap), usual);
    const Area small = app::placeBar({{0, 0}, {50, 30}}, size, 150, {}, gap);
    EXPECT_EQ(small, (Area{{10, 10}, {30, 10}}));
}

}  // namespace

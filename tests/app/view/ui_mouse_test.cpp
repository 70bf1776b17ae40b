// The mouse over the picture: what a hand drags, and what it does not.
#include "app/view/input.h"
#include "tests/support/session/desk.h"

namespace {

using namespace tests;

/// One pixel would begin the picture anew.
TEST(Ui, AHandThatTremblesMovesNoCamera)
{
    Desk desk(deskOptions("animated.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    const app::Viewpoint before = session.navigation.viewpoint();
    const app::Area& picture = desk.loop.layout.picture;
    const glm::vec2 middle = picture.corner + 0.5f * picture.size;
    const auto hand = [&](float right, bool down) {
        app::AppRequests requests;
        ImGuiIO& io = ImGui::GetIO();
        io.MousePos = {middle.x + right, middle.y};
        io.MouseDown[0] = down;
        io.DeltaTime = 1;  // two clicks are no double click
        ImGui::NewFrame();
        app::handleInput(session, requests, picture, 1 / 60.0);
        ImGui::Render();
        return session.navigation.viewpoint();
    };
    for (const bool down : {false, true}) hand(0, down);
    EXPECT_EQ(hand(2, true), before);
    EXPECT_EQ(hand(2, false), before);
    EXPECT_FALSE(session.isMoving());
    for (const bool down : {false, true}) hand(0, down);
    EXPECT_EQ(hand(2, true), before);
    const app::Viewpoint dragged = hand(10, true);
    EXPECT_NE(dragged, before);
    session.navigation.go(before);
    session.navigation.orbit(10 / static_cast<double>(picture.size.y), 0);
    EXPECT_EQ(session.navigation.viewpoint(), dragged) << "all of the way counts";
    EXPECT_NE(hand(11, true), dragged) << "from then on each pixel does";
    hand(11, false);
    EXPECT_EQ(hand(60, false), session.navigation.viewpoint());
}

/// A closed box, within which a drag of its width would lead far outside.
TEST(Ui, AMouseLeadsThroughNoWall)
{
    Desk desk(deskOptions("furnace-80.gltf"));
    ASSERT_TRUE(desk.framesUntil([&] { return desk.hasPicture(); }));
    app::Session& session = desk.session;
    const core::World& world = *session.document()->world;
    const glm::dvec3 low(world.boundsLow), high(world.boundsHigh);
    for (const app::Walls walls : {app::Walls::stop, app::Walls::pass})
        for (const int button : {0, 1, 2}) {
            session.settings.view.walls = walls;
            session.goHome();
            const core::Camera& camera = session.navigation.camera();
            session.navigation.setPivot(camera.position + 3.0 * camera.forward);
            ImGuiIO& io = ImGui::GetIO();
            const app::Area& picture = desk.loop.layout.picture;
            for (int i = 0; i <= 20; ++i) {
                app::AppRequests requests;
                io.MousePos = {picture.corner.x + picture.size.x * (0.5f + 0.05f * float(i)),
                               picture.corner.y + 0.5f * picture.size.y};
                io.MouseDown[button] = i > 0 && i < 20;
                ImGui::NewFrame();
                app::handleInput(session, requests, picture, 1 / 60.0);
                ImGui::Render();
            }
            const glm::dvec3 at = session.navigation.camera().position;
            const bool inside =
                glm::all(glm::lessThan(at, high)) && glm::all(glm::greaterThan(at, low));
            EXPECT_EQ(inside, walls == app::Walls::stop) << button;
        }
}

}  // namespace

// Single widgets of the panel under the mouse: what they show, what they let do, what Esc closes of
// them.
#include <filesystem>
#include <fstream>
#include <initializer_list>

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>
#include <nlohmann/json.hpp>

#include "tests/support/files/source_folder.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/desk.h"

namespace {

using namespace tests;
namespace fs = std::filesystem;
using WidgetJson = nlohmann::ordered_json;

/// A panel with one section open.
struct UiWidgets : testing::Test {
    void open(const fs::path& scene, bool app::SectionParams::*section)
    {
        app::SessionOptions with = deskOptions();
        with.scene.file = scene;
        desk = std::make_unique<Desk>(with, ImVec2{1280, 900});
        app::SectionParams& sections = desk->session.settings.sections;
        app::SectionParams::visit(sections, [](const core::Field&, bool& is) { is = false; });
        sections.*section = true;
        ASSERT_TRUE(desk->framesUntil([&] { return desk->hasPicture(); }));
    }

    /// Moves the mouse over the panel until it is on the widget that these ids lead to.
    bool find(std::initializer_list<const char*> ids) const
    {
        const ImGuiWindow* panel = ImGui::FindWindowByName("Rekindle###panel");
        if (panel == nullptr) return false;
        ImGuiID id = panel->ID;
        for (const char* part : ids) id = ImHashStr(part, 0, id);
        for (const float across : {0.25f, 0.7f})
            for (float y = 5; y < panel->Size.y; y += 6) {
                ImGui::GetIO().MousePos = {panel->Pos.x + across * panel->Size.x, panel->Pos.y + y};
                desk->frame();
                if (ImGui::GetCurrentContext()->HoveredId == id) return true;
            }
        return false;
    }
    void press() const
    {
        for (const bool down : {true, false}) {
            ImGui::GetIO().MouseDown[0] = down;
            desk->frames(2);
        }
    }
    void typeInto(std::initializer_list<const char*> ids, const std::string& text) const
    {
        ASSERT_TRUE(find(ids));
        app::sendKey(*app::findKey("Ctrl"), true);
        press();
        app::sendKey(*app::findKey("Ctrl"), false);
        desk->type(text);
        desk->key(kEnter);
    }

    TemporaryFolder folder;
    std::unique_ptr<Desk> desk;
};

/// The box, 300 times as large: its world is scaled.
fs::path largeBox(const TemporaryFolder& folder)
{
    const std::string name = "cornell-diffuse";
    fs::copy_file(kAssets / (name + ".bin"), folder / (name + ".bin"));
    std::ifstream file(kAssets / (name + ".gltf"));
    WidgetJson scene = WidgetJson::parse(file);
    scene["nodes"].push_back(
        {{"scale", {300, 300, 300}}, {"children", scene["scenes"][0]["nodes"]}});
    scene["scenes"][0]["nodes"] = {scene["nodes"].size() - 1};
    std::ofstream(folder / (name + ".gltf")) << scene.dump();
    return folder / (name + ".gltf");
}

TEST_F(UiWidgets, LengthsAreMetresInScaledWorlds)
{
    open(largeBox(folder), &app::SectionParams::camera);
    app::Session& session = desk->session;
    const double scale = session.document()->world->placement.scale;
    ASSERT_LT(scale, 0.5) << "the test needs another unit";
    typeInto({"Camera", "focus", "##value"}, "40");
    EXPECT_DOUBLE_EQ(session.navigation.camera().focusDistance, 40 * scale);
    typeInto({"Camera", "aperture", "##value"}, "2");
    EXPECT_DOUBLE_EQ(session.navigation.camera().apertureRadius, 2 * scale);
    typeInto({"Camera", "speed", "##value"}, "30");
    EXPECT_DOUBLE_EQ(session.navigation.speed(), 30 * scale);
}

TEST(UiFields, NumbersHaveTheirUnits)
{
    const core::Field exposure{"exposure", ""}, depth{"max-depth", ""};
    const app::FieldUnit units[] = {{"exposure", "stops"}};
    const app::FieldOptions with{.units = units};
    EXPECT_EQ(app::fieldPattern(exposure, "%.4g", with), "%.4g stops");
    EXPECT_EQ(app::fieldPattern(depth, "%u", with), "%u");
    EXPECT_EQ(app::fieldPattern(exposure, "%.4g", {}), "%.4g");
}

TEST_F(UiWidgets, TheReferenceOfThePanelIsThatOfItsKeyAndCanBeBegunAnew)
{
    open(kAssets / "animated.gltf", &app::SectionParams::reference);
    app::Session& session = desk->session;
    typeInto({"Reference", "reference", "##samples"}, "1000000");
    EXPECT_EQ(session.referenceSamples, 1000000u);
    app::runAction("reference", session, desk->requests);
    ASSERT_TRUE(desk->framesUntil([&] { return session.reference() != nullptr; }));
    EXPECT_EQ(session.reference()->params.sppLimit, 1000000u);
    const uint64_t job = session.coreThread().generation;
    ASSERT_TRUE(find({"Reference", "reference", "Render in the background"}));
    press();
    EXPECT_GT(session.coreThread().generation, job) << "as the key begins it anew";
    session.cancel();
}

TEST_F(UiWidgets, EscClosesTheListOfEnvironmentsAndNothingThatIsNotSeen)
{
    open(kAssets / "animated.gltf", &app::SectionParams::scene);
    const auto escape = [&] {
        desk->requests.escape = true;
        desk->frames(2);
        return std::exchange(desk->requests.leave, false);
    };
    const auto elsewhere = [&] {  // which leaves the list open
        const app::Area& picture = desk->loop.layout.picture;
        ImGui::ClearActiveID();
        ImGui::GetIO().MousePos = {picture.corner.x + 9, picture.corner.y + 9};
        desk->frames(2);
    };
    ASSERT_TRUE(find({"Scene", "environment", "##path"}));
    press();
    desk->type((kAssets / "").string());
    elsewhere();
    EXPECT_FALSE(escape()) << "the list";
    EXPECT_TRUE(escape());

    ASSERT_TRUE(find({"Scene", "scene", "##path"}));
    press();
    desk->type((kAssets / "hall.gltf").string());
    elsewhere();
    EXPECT_TRUE(escape()) << "what is typed in full has no list";

    ASSERT_TRUE(find({"Scene", "environment", "##path"}));
    press();
    elsewhere();
    desk->session.settings.sections.scene = false;
    desk->frames(3);
    EXPECT_TRUE(escape()) << "its section is folded";
}

}  // namespace

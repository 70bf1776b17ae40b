// Comparisons in the viewer without its window: errors of A and B, what each is rendered with,
// references of other methods and devices, FLIP.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/pictures/save_picture.h"
#include "app/view/picture_view.h"
#include "core/base/check.h"
#include "core/image/flip.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/session/pretender.h"
#include "tests/support/session/session_steps.h"

namespace {

using namespace tests;
using Source = app::PictureComparison::Source;

ActionJson depthOf(int depth)
{
    return {{"max-depth", depth}};
}

TEST(SessionCompare, EqualTimeTellsErrorsWithAndWithoutAReference)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    EXPECT_EQ(session.comparison(), nullptr);
    act(session, "equal-time", {{"seconds", 0.2}, {"a", depthOf(1)}, {"b", depthOf(6)}});
    ASSERT_TRUE(until(session, [&] { return session.comparison() != nullptr; }));
    auto found = session.comparison();
    ASSERT_EQ(found->source, Source::variance) << found->whyNot;
    for (size_t side = 0; side < 2; ++side) {
        EXPECT_EQ(found->sides[side].samples, session.slots[side].picture->samples);
        EXPECT_GE(found->sides[side].seconds, 0.2);
        EXPECT_GT(found->sides[side].rmse.value, 0);
        EXPECT_LT(found->sides[side].rmse.low, found->sides[side].rmse.high);
    }

    // A reference is used as soon as there is one, and again when it has become better.
    act(session, "set", {{"name", "max-depth"}, {"value", 6}});
    act(session, "reference", {{"spp", 64}});
    ASSERT_TRUE(until(session, [&] {
        return session.reference() && session.reference()->samples == 64 && session.comparison() &&
               session.comparison()->source == Source::reference &&
               session.comparison()->referenceNoise == app::referenceNoise(*session.reference());
    }));
    found = session.comparison();
    EXPECT_GT(found->sides[0].rmse.value, 0);
    EXPECT_GE(found->sides[0].rmse.high, found->sides[0].rmse.value);
    EXPECT_GT(found->referenceNoise, 0);

    // Another view's reference says nothing of these pictures.
    act(session, "orbit", {{"dx", 0.2}, {"dy", 0}});
    act(session, "reference", {{"spp", 4}});
    ASSERT_TRUE(until(session, [&] {
        return session.comparison() && session.comparison()->source == Source::variance;
    }));
    act(session, "load", {{"file", (kAssets / "animated.gltf").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "animated.gltf"); }));
    session.update(0.01, kArea);
    EXPECT_EQ(session.comparison(), nullptr);
}

TEST(SessionCompare, SidesAreChosenBesideThePanel)
{
    Session session(options("cornell-diffuse.gltf"));
    const auto depth = [](const app::RenderParams& params) {
        return params.method.as<core::PathParams>().maxDepth;
    };
    act(session, "set", {{"name", "max-depth"}, {"value", 3}});
    EXPECT_EQ(depth(session.sideParams(0)), 3u) << "as the panel says";
    act(session, "params-a");
    act(session, "params-b", {{"params", {{"max-depth", 5}, {"device", "cpu"}}}});
    act(session, "set", {{"name", "max-depth"}, {"value", 9}});
    EXPECT_EQ(depth(session.sideParams(0)), 3u);
    EXPECT_EQ(depth(session.sideParams(1)), 5u);
    ASSERT_EQ(app::differences(session.sideParams(0), session.sideParams(1)).size(), 1u);
    act(session, "use-params", {{"side", "b"}});
    EXPECT_EQ(depth(session.render), 5u);
    EXPECT_THROW(act(session, "use-params", {{"side", "c"}}), core::Error);

    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "equal-time", {{"seconds", 0.02}});
    ASSERT_TRUE(until(session, [&] { return !session.equalTime().running(); }));
    EXPECT_EQ(depth(session.slots[0].picture->params), 3u);
    EXPECT_EQ(depth(session.slots[1].picture->params), 5u);
    act(session, "params-b", {{"params", depthOf(7)}});
    act(session, "equal-time", {{"seconds", 0.02}});
    ASSERT_TRUE(until(session, [&] { return !session.equalTime().running(); }));
    EXPECT_EQ(depth(session.slots[1].picture->params), 7u) << "also where there is a picture";
    act(session, "clear-slots");
    EXPECT_EQ(depth(session.sideParams(1)), 5u) << "as the panel says";
}

TEST(SessionCompare, ThePictureOfOneMethodIsTheReferenceOfAnother)
{
    Session session(options("cornell-diffuse.gltf"));
    act(session, "set", {{"name", "spp-limit"}, {"value", 8}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    const core::Image kept = session.picture()->mean;
    act(session, "keep-reference");
    ASSERT_TRUE(until(session, [&] { return session.reference() != nullptr; }));
    EXPECT_EQ(session.reference()->mean.pixels, kept.pixels);
    EXPECT_EQ(session.reference()->samples, 8u);
    EXPECT_GT(app::referenceNoise(*session.reference()), 0);
    EXPECT_EQ(session.reference()->noise, app::referenceNoise(*session.reference()));
    EXPECT_NE(session.reference()->origin.find("path, cpu"), std::string::npos);
    act(session, "set", {{"name", "seed"}, {"value", 5}});
    ASSERT_TRUE(until(session, [&] {
        return settled(session) && session.picture()->finished &&
               session.picture()->curve.back().rmse > 0;
    }));
    EXPECT_TRUE(session.referenceFits());

    // One of a named method, as deep as the picture.
    act(session, "set", {{"name", "max-depth"}, {"value", 3}});
    act(session, "reference", {{"spp", 2}, {"method", "guided"}});
    ASSERT_TRUE(until(session, [&] {
        return session.reference() &&
               session.reference()->origin.find("guided") != std::string::npos;
    }));
    EXPECT_GT(session.reference()->noise, 0);
    EXPECT_EQ(session.reference()->noise, app::referenceNoise(*session.reference()));
    EXPECT_THROW(act(session, "reference", {{"method", "magic"}}), core::Error);
}

TEST(SessionCompare, TheReferenceIsThePictureThatWasOnShow)
{
    Book book;
    app::SessionOptions o = options("cornell-diffuse.gltf");
    o.factory = [&](const app::RenderParams&, bool) { return std::make_unique<Pretender>(book); };
    o.render.sppLimit = 8;
    Session session(o);
    session.settings.sections.compare = false;
    const auto finished = [&] { return settled(session) && session.picture()->finished; };
    ASSERT_TRUE(until(session, finished));
    ASSERT_EQ(session.picture()->variance, nullptr) << "the test needs one to wait for";
    const app::RenderParams params = session.picture()->params;
    act(session, "keep-reference");
    act(session, "set", {{"name", "max-depth"}, {"value", 3}});
    ASSERT_TRUE(until(session, [&] { return session.reference() != nullptr; }));
    EXPECT_EQ(session.reference()->params, params) << "not what was rendered later";
    EXPECT_EQ(session.reference()->samples, 8u);

    ASSERT_TRUE(until(session, finished));
    act(session, "restart");
    session.update(0.01, kArea);
    ASSERT_TRUE(until(session, finished));
    act(session, "keep-reference");
    session.referenceSamples = 1000000;
    act(session, "reference");
    ASSERT_TRUE(until(session, [&] { return session.reference() != nullptr; }));
    EXPECT_NE(session.reference()->origin.find("rendered here"), std::string::npos);
    EXPECT_EQ(session.reference()->params.sppLimit, 1000000u) << "as the panel says";
    EXPECT_TRUE(session.coreThread().active()) << "what was wanted before does not end it";
    session.cancel();
}

TEST(SessionCompare, FlipComesWhenItIsOnShow)
{
    Session session(options("cornell-diffuse.gltf"));
    act(session, "set", {{"name", "spp-limit"}, {"value", 4}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    act(session, "show-flip");
    act(session, "reference", {{"spp", 32}});
    ASSERT_TRUE(until(session, [&] {
        return session.flip() && session.flip()->reference == session.reference() &&
               session.reference()->samples == 32;
    }));
    const auto flip = session.flip();
    const core::FlipResult same = core::flipHdr(session.picture()->mean, session.reference()->mean);
    EXPECT_EQ(flip->map.pixels, same.map.pixels);
    EXPECT_EQ(flip->mean, same.mean);
    EXPECT_GT(flip->mean, 0);
    app::PictureView view;
    const app::DisplayInputs inputs = view.inputs(session);
    ASSERT_NE(inputs.a, nullptr);
    EXPECT_EQ(inputs.a->pixels, flip->map.pixels);  // perhaps of a newer picture, as good
    EXPECT_EQ(inputs.settings.show, shared::kShowScalar);
    EXPECT_EQ(inputs.settings.low, 0);
    EXPECT_EQ(inputs.settings.high, 1);
    EXPECT_EQ(inputs.settings.logarithmic, 0u);
    EXPECT_NE(view.scale().label.find("at 4 spp"), std::string::npos) << view.scale().label;
    act(session, "show-color");
    session.update(0.01, kArea);
    EXPECT_EQ(session.flip(), nullptr);
}

TEST(SessionCompare, AReferenceFromAFileTellsWhetherItIsOfThisView)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "kept.exr";
    Session session(options("cornell-diffuse.gltf"));
    act(session, "set", {{"name", "spp-limit"}, {"value", 4}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    act(session, "save", {{"file", file.string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, file.string() + ": saved"); }));
    act(session, "load-reference", {{"file", file.string()}});
    ASSERT_TRUE(session.reference());
    EXPECT_EQ(session.reference()->samples, 4u);
    EXPECT_GT(session.reference()->noise, 0);
    EXPECT_EQ(session.reference()->noise, app::referenceNoise(*session.reference()));
    EXPECT_NEAR(session.reference()->seconds, session.picture()->seconds, 6e-4);
    EXPECT_TRUE(session.isSaved(session.reference())) << "it is in a file";
    EXPECT_FALSE(told(session, "than what is on show"));

    act(session, "orbit", {{"dx", 0.1}});
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "load-reference", {{"file", file.string()}});
    EXPECT_TRUE(told(session, "another camera than what is on show"));
    EXPECT_TRUE(session.reference()) << "it may be meant all the same";
    act(session, "load", {{"file", (kAssets / "animated.gltf").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "animated.gltf: "); }));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "load-reference", {{"file", file.string()}});
    EXPECT_TRUE(told(session, "another scene than what is on show"));
}

TEST(SessionCompare, AReferenceOfAnotherSizeIsRefusedBeforeItsPixelsAreRead)
{
    const TemporaryFolder folder;
    const fs::path file = folder / "large.exr";
    core::Image pixels(200, 100, 3);
    for (size_t i = 0; i < pixels.pixels.size(); ++i) pixels.pixels[i] = float(i * 7919 % 1009);
    core::writeExr(file, {{{"", pixels}}, {}});
    fs::resize_file(file, fs::file_size(file) / 2);  // what reads the pixels says that
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "load-reference", {{"file", file.string()}});
    EXPECT_TRUE(told(session, "is 200x100, the picture is 48x32"));
    EXPECT_EQ(session.reference(), nullptr);
}

TEST(SessionCompare, AViewThatIsAskedForTakesThePlaceOfTheSlider)
{
    Session session(options(""));
    const app::Show& show = session.settings.view.show;
    for (const bool again : {false, true}) {
        act(session, "compare");
        act(session, "show-depth");
        EXPECT_FALSE(session.comparing);
        EXPECT_EQ(show, app::Show::depth) << "it was not to be seen before: " << again;
    }
    act(session, "show-depth");
    EXPECT_EQ(show, app::Show::color) << "the same key goes back";
    act(session, "set", {{"name", "method"}, {"value", "reuse"}});
    for (int i = 0; i < 2; ++i) {
        act(session, "compare");
        act(session, "next-map");
        EXPECT_FALSE(session.comparing);
        EXPECT_EQ(show, app::Show::methodMap);
        EXPECT_EQ(session.settings.view.methodMap, 0u);
    }
    act(session, "compare");
    act(session, "show-color");
    EXPECT_FALSE(session.comparing);
}

TEST(SessionCompare, AMethodWithoutMapsSaysSoAndThePictureStays)
{
    Session session(options(""));
    session.render.method = core::methodNamed("path").defaults;
    act(session, "next-map");
    EXPECT_EQ(session.settings.view.show, app::Show::color);
    ASSERT_FALSE(session.notices.list().empty());
    EXPECT_EQ(session.notices.list().back().text, "the method path has no maps of its own");
}

TEST(SessionCompare, SavedFilesAreNamedWithTheirFolderAndHoldWhatThereIs)
{
    const TemporaryFolder folder;
    Session session(options("cornell-diffuse.gltf"));
    act(session, "set", {{"name", "spp-limit"}, {"value", 4}});
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    EXPECT_FALSE(session.pictureMetadata().empty());
    const fs::path file = folder / "kept.exr";
    act(session, "save", {{"file", file.string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, file.string() + ": saved"); }));
    EXPECT_EQ(session.notices.list().back().file, file.string());
    const core::ImageFile image = core::readExr(file);
    for (const char* layer : {"variance", "depth", "normal", "albedo", "ids"})
        EXPECT_TRUE(image.hasLayer(layer)) << layer;
    EXPECT_EQ(session.pictureMetadata(), image.metadata) << "a screenshot tells the same";
}

TEST(SessionCompare, WhoLooksAtPixelsHasFirstHitsAndDeviations)
{
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(
        until(session, [&] { return settled(session) && session.picture()->samples >= 2; }));
    EXPECT_FALSE(session.picture()->aovs);
    session.inspecting = true;
    ASSERT_TRUE(until(session, [&] {
        return settled(session) && session.picture()->aovs && session.picture()->variance;
    }));
    EXPECT_GE(session.picture()->samples, 2u) << "nothing began anew";
}

TEST(SessionCompare, SwappedSidesTakeTheirParametersAlong)
{
    Session session(options("cornell-diffuse.gltf"));
    const auto depth = [&](size_t side) {
        return session.sideParams(side).method.as<core::PathParams>().maxDepth;
    };
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    act(session, "equal-time", {{"seconds", 0.02}, {"a", depthOf(1)}, {"b", depthOf(6)}});
    session.update(0.01, kArea);
    act(session, "swap");
    EXPECT_EQ(depth(0), 1u) << "not while the sides are being filled";
    ASSERT_TRUE(until(session, [&] { return !session.equalTime().running(); }));
    act(session, "swap");
    for (const size_t side : {size_t(0), size_t(1)}) {
        EXPECT_EQ(depth(side), side == 0 ? 6u : 1u);
        ASSERT_TRUE(session.slots[side].picture);
        EXPECT_EQ(session.slots[side].picture->params.method, session.sideParams(side).method);
    }
}

/// With Compare open pictures carry their variance, previews as well.
TEST(SessionCompare, ACoarsePictureIsKeptOnlyUntilTheWholeOneIsThere)
{
    Book book;
    app::SessionOptions o = options("cornell-diffuse.gltf");
    o.factory = [&](const app::RenderParams&, bool) { return std::make_unique<Pretender>(book); };
    Session session(o);
    session.settings.sections.compare = true;
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    book.set(&Book::secondsPerPixel, 0.5 / (kArea.x * kArea.y));
    bool coarse = false;
    for (int i = 0; i < 500 && !coarse; ++i) {
        act(session, "orbit", {{"dx", 0.01}});
        ASSERT_TRUE(
            until(session, [&] { return session.picture()->generation >= session.generation(); }));
        coarse = session.picture()->preview && session.picture()->variance;
    }
    ASSERT_TRUE(coarse) << "the test needs a preview with a variance";
    act(session, "store-a");
    EXPECT_TRUE(session.slots[0].picture->preview);
    ASSERT_TRUE(until(session, [&] { return !session.slots[0].picture->preview; }));
    EXPECT_EQ(session.slots[0].picture->mean.width, kArea.x);
}

/// As a sample of it goes on some pixels have had one more, which no number beside it tells.
TEST(SessionCompare, ASideIsOfWholeSamples)
{
    Book book;
    app::SessionOptions o = options("cornell-diffuse.gltf");
    o.factory = [&](const app::RenderParams&, bool) { return std::make_unique<Pretender>(book); };
    Session session(o);
    session.settings.sections.compare = false;
    session.render.sppLimit = 8;
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    book.set(&Book::secondsPerPixel, 10.0 / (kArea.x * kArea.y));
    session.render.sppLimit = 1000;
    const auto inSample = [&] {
        return session.picture()->fraction > 0 && session.picture()->samples > 0;
    };
    ASSERT_TRUE(until(session, inSample));
    act(session, "store-a");
    ASSERT_TRUE(session.slots[0].picture);
    EXPECT_TRUE(isWhole(*session.slots[0].picture));
    EXPECT_EQ(session.slots[0].picture->samples, session.picture()->samples);
}

/// A scene that moves, of which a renderer pretends to take four samples.
app::SessionOptions animation(Book& book)
{
    app::SessionOptions o = options("animated.gltf");
    o.factory = [&](const app::RenderParams&, bool) { return std::make_unique<Pretender>(book); };
    o.render.sppLimit = 4;
    return o;
}

TEST(SessionCompare, NoSideIsOfTheSceneBefore)
{
    Book book;
    Session session(animation(book));
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    const auto before = session.picture();
    book.set(&Book::endlessWorld, true);
    const double time = session.document()->time;
    act(session, "animation", {{"play", false}, {"time", 0.5}});
    ASSERT_TRUE(until(session, [&] { return session.document()->time != time; }));
    act(session, "store-a");
    EXPECT_EQ(session.slots[0].picture, nullptr) << "another instant";
    EXPECT_TRUE(told(session, "there is no picture to keep yet"));
    EXPECT_FALSE(told(session, "is kept as A"));

    act(session, "load", {{"file", (kAssets / "furnace-50.gltf").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "furnace-50.gltf: "); }));
    act(session, "store-b");
    EXPECT_EQ(session.slots[1].picture, nullptr) << "another scene";
    EXPECT_EQ(session.picture(), before) << "the test needs one of the scene before";

    book.set(&Book::endlessWorld, false);
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    act(session, "store-b");
    EXPECT_EQ(session.slots[1].picture, session.picture());
    EXPECT_TRUE(told(session, "is kept as B"));
}

/// What is on show then is of an instant before the one that is being rendered.
TEST(SessionCompare, WhileAnAnimationPlaysThePictureOnShowIsKept)
{
    Book book;
    Session session(animation(book));
    ASSERT_TRUE(until(session, [&] { return settled(session) && session.picture()->finished; }));
    act(session, "animation", {{"play", false}, {"time", 0.5}});
    ASSERT_TRUE(until(session, [&] {
        return settled(session) && session.picture()->finished && session.picture()->time == 0.5;
    }));
    book.set(&Book::endlessWorld, true);
    act(session, "animation", {{"play", true}});
    ASSERT_TRUE(until(session, [&] { return session.document()->time > 0.5; }));
    EXPECT_EQ(session.pictureMetadata()["at"], "0.5");
    act(session, "store-a");
    ASSERT_EQ(session.slots[0].picture, session.picture());
    EXPECT_EQ(session.slots[0].time, 0.5);

    act(session, "load", {{"file", (kAssets / "furnace-50.gltf").string()}});
    ASSERT_TRUE(until(session, [&] { return told(session, "furnace-50.gltf: "); }));
    session.player.playing = true;
    act(session, "store-b");
    EXPECT_EQ(session.slots[1].picture, nullptr) << "another scene";
    EXPECT_TRUE(session.pictureMetadata().empty());
    book.set(&Book::endlessWorld, false);
}

/// As `compare` reads it.
TEST(SessionCompare, AReferenceOfAnotherProgramNeedNotHaveThreeChannels)
{
    const TemporaryFolder folder;
    Session session(options("cornell-diffuse.gltf"));
    ASSERT_TRUE(until(session, [&] { return settled(session); }));
    const auto numbered = [](uint32_t channels) {
        core::Image image(kArea.x, kArea.y, channels);
        for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = float(i);
        return image;
    };
    const auto load = [&](const char* name, uint32_t channels, uint32_t ofVariance) {
        core::writeExr(folder / name,
                       {{{"", numbered(channels)}, {"variance", numbered(ofVariance)}}, {}});
        act(session, "load-reference", {{"file", (folder / name).string()}});
        return session.reference() && session.reference()->origin == name;
    };
    ASSERT_TRUE(load("rgba.exr", 4, 4));
    EXPECT_EQ(session.reference()->mean.channels, 3u);
    EXPECT_EQ(session.reference()->mean.at(1, 0)[2], 6);
    EXPECT_EQ(session.reference()->variance.channels, 3u);
    EXPECT_EQ(session.reference()->variance.at(2, 0)[0], 8);
    ASSERT_TRUE(load("grey.exr", 1, 1));
    EXPECT_EQ(session.reference()->mean.channels, 3u);
    EXPECT_EQ(session.reference()->mean.at(1, 0)[2], 1) << "which counts for all three";
    EXPECT_TRUE(session.reference()->variance.pixels.empty()) << "that of luminance says nothing";
    EXPECT_EQ(session.reference()->noise, 0);

    core::writeExr(folder / "layers.exr", {{{"depth", numbered(1)}}, {}});
    act(session, "load-reference", {{"file", (folder / "layers.exr").string()}});
    EXPECT_TRUE(told(session, "layers.exr: has no channels R, G, B outside of layers"));
}

}  // namespace

// The page on flights, and its numbers: well-formed whatever was measured, and what it says of
// errors and of paths is what they were.
#include "app/bench/flythrough/flight_page.h"

#include <cmath>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/bench/flythrough/flight_files.h"
#include "tests/support/files/markup.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/text_search.h"

namespace app::flight {
namespace {

using tests::contains;

Row discardRow(uint32_t n, double seconds, double relMse)
{
    Row row{.strategy = "discard", .samples = n, .seconds = seconds};
    row.errors.relMse.value = relMse;
    return row;
}

/// Every value that a measurement can have, in a result of every part.
Results hostileResults()
{
    const double odd[] = {kUnknown, HUGE_VAL, -HUGE_VAL, 0, -1, 1e300, 1e-300};
    size_t i = 0;
    const auto next = [&] { return odd[i++ % std::size(odd)]; };
    const auto errors = [&] {
        PictureErrors e;
        for (Measured* m : {&e.mse, &e.relMse, &e.signedError}) *m = {next(), next()};
        e.variance = next();
        e.trimmed = {next(), next()};
        return e;
    };
    Results r;
    r.version = "<0>";
    r.strategies = {"discard", "naive", "ra", "of tomorrow"};
    r.leftOut = {{"x&y", "needs <more>"}};
    r.params = core::ReuseParams{};
    r.steps = {0.25, 4};
    r.frames = {1, 4, 30};
    r.seeds = 2;
    r.quick = r.interrupted = true;
    for (const char* name : {"a<b", "\"c\"&d"}) {
        SceneResult scene;
        scene.name = name;
        scene.unit = "degrees";
        scene.shownStep = 4;
        scene.radiance = next();
        for (const std::string& strategy : r.strategies)
            for (const double step : r.steps)
                for (const uint32_t frame : r.frames)
                    scene.rows.push_back({.strategy = strategy,
                                          .step = step,
                                          .distance = next(),
                                          .frame = frame,
                                          .rays = next(),
                                          .seconds = next(),
                                          .errors = errors(),
                                          .ratio = {next(), next()},
                                          .trimmedRatio = {next(), next()},
                                          .mseRatio = next(),
                                          .timeRatio = next(),
                                          .trimmedTimeRatio = next()});
        scene.atRest = {discardRow(1, next(), next())};
        scene.shots = {{"reference", 1, 0, next(), "none.png", "none.png"},
                       {"ra", 4, next(), next(), "none.png", "none.png"}};
        r.scenes.push_back(scene);
    }
    for (const double value : {0.0, 1.0, 4.0})
        r.sweeps.push_back({"history",
                            value,
                            4,
                            value == 1,
                            next(),
                            errors(),
                            {next(), next()},
                            {next(), next()}});
    return r;
}

TEST(FlightPage, StaysWellFormedWhateverItIsGiven)
{
    const tests::TemporaryFolder folder;
    for (const Results& results : {hostileResults(), Results{}}) {
        const std::string page = tests::withoutPictures(resultsPage(results, folder.path()));
        const tests::Markup markup = tests::readMarkup(page);
        EXPECT_EQ(markup.problem, "");
        const size_t nan = page.find("nan");
        EXPECT_EQ(nan, std::string::npos) << page.substr(nan < 60 ? 0 : nan - 60, 120);
        EXPECT_FALSE(resultsJson(results).empty());
        rowsCsv(results);
        resultsTable(results);
    }
}

TEST(FlightPage, TellsErrorsOfTheWindowByWhatTheWindowShows)
{
    Results results;
    results.strategies = {"discard"};
    results.frames = {2};
    SceneResult scene;
    scene.name = "x";
    scene.radiance = 2;
    scene.windowRadiance = 1;
    scene.window = {{.strategy = "discard", .target = 0.1}};
    scene.window[0].errors.signedError = {0.01, 0.001};
    scene.window[0].shownRatio = {0.345, 0.012};
    scene.window[0].underWayRatio = {0.456, 0.013};
    scene.window[0].bySizeRatio = {0.217, 0.001};
    results.scenes = {scene};
    const std::string page = resultsPage(results, {});
    EXPECT_TRUE(contains(page, "1.0 %")) << page.substr(page.find("In the window's own loop"));
    EXPECT_FALSE(contains(page, "0.50 %"));
    const auto json = nlohmann::json::parse(resultsJson(results));
    EXPECT_EQ(json.at("scenes")[0].at("window").at("mean_reference"), 1);
    EXPECT_TRUE(contains(page, "as shown")) << page;
    const auto& row = json.at("scenes")[0].at("window").at("rows").at(0);
    EXPECT_EQ(row.at("shown_mse_ratio"), 0.345);
    EXPECT_EQ(row.at("shown_mse_ratio_se"), 0.012);
    EXPECT_EQ(row.at("shown_mse_by_size_ratio"), 0.217);
    EXPECT_TRUE(contains(page, "by size") && contains(page, "0.217")) << page;
    EXPECT_TRUE(contains(page, "under way") && contains(page, "0.46 ± 0.01")) << page;
    EXPECT_EQ(row.at("under_way_mse_ratio"), 0.456);
    EXPECT_EQ(row.at("under_way_mse_ratio_se"), 0.013);
    EXPECT_TRUE(contains(resultsTable(results), "0.345 +- 0.012    0.456 +- 0.013    0.217"))
        << resultsTable(results);
}

TEST(FlightPage, TellsHowManyPathsThereWere)
{
    Results results;
    results.strategies = {"discard"};
    results.frames = {2};
    SceneResult scene;
    scene.name = "x";
    scene.radiance = 1;
    for (const uint32_t n : {1u, 2u, 4u}) scene.atRest.push_back(discardRow(n, n, 1.0 / n));
    results.scenes = {scene};
    const auto page = [&](double rays) {
        results.rays = rays;
        return resultsPage(results, {});
    };
    const std::string usual = page(1), more = page(3), fewer = page(0.25);
    EXPECT_TRUE(contains(usual, "Equal rays: one new path per pixel and frame for everyone"));
    EXPECT_TRUE(contains(usual, "with 1, 2 and 4 paths per pixel"));
    EXPECT_TRUE(contains(more, "Equal rays: 3 new paths per pixel and frame for everyone"));
    EXPECT_TRUE(contains(more, "each frame may trace 3 new paths per pixel."));
    EXPECT_TRUE(contains(more, "with 3, 4 and 6 paths per pixel"));
    EXPECT_TRUE(contains(more, ", 4: relMSE "));
    EXPECT_FALSE(contains(more, "one new path"));
    EXPECT_TRUE(contains(fewer, "Rays are not equal"));
    EXPECT_TRUE(contains(fewer, "as few as 0.25"));
    EXPECT_FALSE(contains(fewer, "at equal rays"));
}

}  // namespace
}  // namespace app::flight

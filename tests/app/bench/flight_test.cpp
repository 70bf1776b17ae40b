// Flights, errors against a noisy reference, equal time, swept values, what is measured: what
// `rekindle bench flythrough` is made of, on values that are known.
#include "app/bench/flight.h"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "app/bench/flythrough/flight_measure.h"
#include "app/bench/picture_error.h"
#include "app/report/text.h"
#include "core/gltf/load.h"
#include "core/trace/pick.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/text_search.h"
#include "tests/support/scenes/instanced_scenes.h"

namespace app::flight {
namespace {

using glm::dvec3;
using tests::contains;

std::shared_ptr<const core::World> world(const std::string& name)
{
    return core::makeWorld(
        core::loadGltf(std::string(REKINDLE_SOURCE_DIR "/assets/") + name + ".gltf"));
}

double degreesBetween(const dvec3& a, const dvec3& b)
{
    return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

TEST(Flight, EndsInOneViewWhateverItsStep)
{
    const auto box = world("cornell-glossy");
    const core::Camera end = box->cameras.front();
    const Flight flight = Flight::around(box, end, {64, 64}, 16);
    EXPECT_EQ(flight.end(), end);
    const double reach = core::pick(*box, end, {64, 64}, {0.5, 0.5})->distance;
    const dvec3 target = end.position + reach * end.forward;
    for (const double step : {0.25, 1.0, 16.0}) {
        EXPECT_EQ(flight.whyNot(step, 30), "");
        EXPECT_EQ(flight.before(step, 0), end);
        for (uint32_t i = 0; i < 40; ++i) {
            const core::Camera a = flight.before(step, i), b = flight.before(step, i + 1);
            EXPECT_NEAR(degreesBetween(a.position - target, b.position - target), step, 1e-4);
            EXPECT_NEAR(glm::length(b.position - target), reach, 1e-6);
            EXPECT_NEAR(degreesBetween(b.forward, target - b.position), 0, 1e-4);
            EXPECT_NEAR(glm::dot(b.forward, b.up), 0, 1e-9);
        }
        EXPECT_NEAR(flight.distance(step), 2 * reach * std::sin(glm::radians(step) / 2), 1e-6);
    }
    EXPECT_NE(flight.whyNot(60, 2), "");
    EXPECT_EQ(Flight::around(box, end, {64, 64}, 60).whyNot(60, 2), "");
}

/// A camera close to a wall: the circle is smaller, or lies on another side.
TEST(Flight, DoesNotLeaveTheRoom)
{
    const auto room = world("furnace-50");
    core::Camera camera = room->cameras.front();
    const dvec3 low(room->boundsLow), high(room->boundsHigh), middle = 0.5 * (low + high);
    for (const dvec3& corner : {low, high, dvec3(low.x, high.y, low.z)}) {
        const dvec3 place = middle + 0.9 * (corner - middle);
        camera = core::lookAt(place, middle, {0, 1, 0}, 0.7);
        const Flight flight = Flight::around(room, camera, {32, 32}, 1);
        ASSERT_EQ(flight.whyNot(0.5, 2), "");
        for (uint32_t i = 0; i < 60; ++i) {
            const dvec3 p = flight.before(0.5, i).position;
            EXPECT_TRUE(glm::all(glm::greaterThan(p, low)) && glm::all(glm::lessThan(p, high)));
        }
    }
}

/// A camera at `eye`, a wall that it looks at, and many small squares of one mesh about `shown`, in
/// a plane across x.
tests::SceneBuilder squares(const dvec3& eye, const dvec3& shown)
{
    constexpr int kSide = 8;  // squares; 6 m
    tests::SceneBuilder builder;
    const int white = builder.material(tests::lambert(glm::vec3(0.5f)));
    builder.quad(glm::vec3(eye) - glm::vec3(5, 5, 4), {10, 0, 0}, {0, 10, 0}, white);
    // The corners of all: the world's origin is in the middle of it.
    for (const float corner : {-50.0f, 50.0f})
        builder.quad(glm::vec3(corner), {-0.01f * corner, 0, 0}, {0, -0.01f * corner, 0}, white);
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;
    for (uint32_t i = 0; i < 9; ++i)
        positions.push_back(0.375f * glm::vec3(0, float(i % 3) - 1, float(i / 3) - 1));
    for (const uint32_t i : {0u, 1u, 3u, 4u}) {
        triangles.emplace_back(i, i + 1, i + 4);
        triangles.emplace_back(i, i + 4, i + 3);
    }
    const int mesh = builder.looseMesh(positions, triangles, white);
    for (int y = 0; y < kSide; ++y)
        for (int z = 0; z < kSide; ++z) {
            const dvec3 cell(0, y - 0.5 * (kSide - 1), z - 0.5 * (kSide - 1));
            builder.node(glm::translate(glm::dmat4(1), shown + 0.75 * cell), {mesh});
        }
    builder.camera(eye, eye - dvec3(0, 0, 4), 0.8);
    return builder;
}

/// Meshes that are stored once stand in the way where they are shown, and not where they are in
/// the space of their own, which is about the origin. The circle that is tried first lies on the
/// right.
TEST(Flight, SeesInstancesWhereTheyAre)
{
    const dvec3 far(30, 0, 0), near(-0.05, 0, 0);
    for (const bool blocked : {true, false}) {
        const tests::SceneBuilder scene =
            blocked ? squares(far, far + dvec3(0.5, 0, 0)) : squares(near, far);
        const auto kept = tests::worldOf(scene, core::Instancing::kept),
                   flat = tests::worldOf(scene, core::Instancing::flat);
        ASSERT_FALSE(kept->prototypes.empty());
        ASSERT_EQ(kept->placement.centre, dvec3(0));
        const core::Camera end = kept->cameras.front();
        const Flight a = Flight::around(kept, end, {32, 32}, 1),
                     b = Flight::around(flat, end, {32, 32}, 1);
        EXPECT_EQ(a.words(), b.words());
        for (const uint32_t i : {1u, 5u, 20u})
            EXPECT_LT(glm::length(a.before(0.5, i).position - b.before(0.5, i).position), 1e-4);
        EXPECT_EQ(a.before(0.5, 20).position.x < end.position.x, blocked);
    }
}

TEST(Flight, FollowsAPathToItsEnd)
{
    app::CameraPath path;
    for (int i = 0; i < 5; ++i) {
        core::Camera camera;
        camera.position = {double(i), 0, 0};
        path.keys.push_back({3.0 * i, camera});
    }
    const Flight flight = Flight::along(path);
    EXPECT_NEAR(flight.end().position.x, 4, 1e-12);
    EXPECT_NEAR(flight.before(1.5, 4).position.x, 2, 1e-12);
    EXPECT_EQ(flight.whyNot(1, 13), "");
    EXPECT_NE(flight.whyNot(1, 14).find("--frames"), std::string::npos);
    EXPECT_NE(flight.whyNot(4, 5), "");
}

core::Image image(uint32_t width, uint32_t height, float value)
{
    core::Image result(width, height, 3);
    std::ranges::fill(result.pixels, value);
    return result;
}

TEST(FlightErrors, HaveTheirKnownValues)
{
    const core::Image reference = image(10, 9, 0.5f), exact = image(10, 9, 0);
    ErrorSum sum(reference, exact);
    sum.add(image(10, 9, 0.7f));
    sum.add(image(10, 9, 0.4f));
    const PictureErrors e = sum.errors();
    EXPECT_EQ(e.pictures, 2u);
    EXPECT_NEAR(e.mse.value, (0.04 + 0.01) / 2, 1e-7);
    EXPECT_NEAR(e.relMse.value, (0.04 + 0.01) / 2 / 0.26, 1e-7);
    EXPECT_NEAR(e.trimmed.value, (0.04 + 0.01) / 2 / 0.26, 1e-7);
    EXPECT_NEAR(e.signedError.value, 0.05, 1e-7);
    EXPECT_NEAR(e.variance, 0.045, 1e-7);  // of .7 and .4, unbiased
    ErrorSum one(reference, exact);
    one.add(exact);
    EXPECT_TRUE(std::isnan(one.errors().variance));
    EXPECT_TRUE(std::isnan(one.errors().relMse.error));
}

/// What is dropped as a firefly takes the reference's noise along that made it one.
TEST(FlightErrors, TrimmingDropsTheNoiseOfWhatItDrops)
{
    core::Image reference = image(40, 30, 1), variance = image(40, 30, 0),
                picture = image(40, 30, 1.1f);
    std::fill_n(reference.at(7, 5), 3, 40.0f);
    std::fill_n(variance.at(7, 5), 3, 1000.0f);
    const core::Image level = image(40, 30, 1);
    ErrorSum sum(reference, variance, level);
    sum.add(picture);
    EXPECT_NEAR(sum.errors().trimmed.value, 0.01 / 1.01, 1e-6);
}

/// Pictures and references with normal noise: errors come without the reference's part, and
/// standard errors are what the numbers vary by.
TEST(FlightErrors, KnowTheNoiseOfTheReferenceAndTheirOwn)
{
    constexpr int kTrials = 400;
    constexpr float kNoise = 0.3f, kReferenceNoise = 0.2f;
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const core::Image variance = image(32, 24, kReferenceNoise * kReferenceNoise);
    double mse = 0, mseZ = 0, signedZ = 0;
    for (int t = 0; t < kTrials; ++t) {
        core::Image reference = image(32, 24, 1);
        // Channels of a pixel vary together, as those of a path tracer do.
        for (size_t i = 0; i < reference.pixels.size(); i += 3) {
            const float x = kReferenceNoise * normal(random);
            for (size_t k = i; k < i + 3; ++k) reference.pixels[k] += x;
        }
        ErrorSum sum(reference, variance);
        for (int seed = 0; seed < 3; ++seed) {
            core::Image picture = image(32, 24, 1);
            for (float& x : picture.pixels) x += kNoise * normal(random);
            sum.add(picture);
        }
        const PictureErrors e = sum.errors();
        const double truth = double(kNoise) * double(kNoise);
        mse += e.mse.value / kTrials;
        mseZ += std::pow((e.mse.value - truth) / e.mse.error, 2) / kTrials;
        signedZ += std::pow(e.signedError.value / e.signedError.error, 2) / kTrials;
        EXPECT_NEAR(e.variance, truth, 0.15 * truth);
    }
    // Without the reference's part it would be .13. One mean of 768 x 3 x 3 x 400 squares varies by
    // a part in a thousand and the reference's by a little more.
    EXPECT_NEAR(mse, 0.09, 0.002);
    // The square of a normal number varies by sqrt(2/400) = 7 %; 4.21 of them, and few degrees of
    // freedom in the standard errors. What is left of the reference's noise is not in mse's.
    EXPECT_NEAR(signedZ, 1, 0.35);
    EXPECT_GT(mseZ, 0.7);
}

/// Errors that reach over 32 pixels, as those of a window's spread light do, wherever the blotches
/// begin.
core::Image blotches(uint32_t width, uint32_t height, std::mt19937& random)
{
    constexpr uint32_t kSide = 32;
    std::normal_distribution<float> normal;
    const uint32_t left = uint32_t(random()) % kSide, top = uint32_t(random()) % kSide;
    const uint32_t across = width / kSide + 2;
    std::vector<float> values(size_t(across) * (height / kSide + 2));
    for (float& value : values) value = 1 + 0.3f * normal(random);
    core::Image picture(width, height, 3);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            std::fill_n(picture.at(x, y), 3,
                        values[size_t((y + top) / kSide) * across + (x + left) / kSide]);
    return picture;
}

/// Standard errors against what the numbers vary by. Tiles of 64 pixels miss a sixth of that, those
/// of 8 three quarters.
TEST(FlightErrors, OfAWindowReachFurtherThanSmallTiles)
{
    constexpr int kTrials = 200;
    constexpr uint32_t kWidth = 384, kHeight = 320;
    EXPECT_EQ(windowTileSide(kWidth, kHeight), 64u);
    EXPECT_EQ(windowTileSide(640, 360), 64u);
    EXPECT_EQ(windowTileSide(160, 120), 29u);  // 6 x 5 of them
    EXPECT_EQ(windowTileSide(16, 16), kTileSide);
    std::mt19937 random(7);
    const core::Image reference = image(kWidth, kHeight, 1), exact = image(kWidth, kHeight, 0);
    constexpr std::array<Measured PictureErrors::*, 3> kWhich{
        &PictureErrors::mse, &PictureErrors::relMse, &PictureErrors::signedError};
    double sums[3]{}, squares[3]{}, reported[3]{};
    for (int t = 0; t < kTrials; ++t) {
        ErrorSum sum(reference, exact, windowTileSide(kWidth, kHeight));
        for (int seed = 0; seed < 2; ++seed) sum.add(blotches(kWidth, kHeight, random));
        const PictureErrors e = sum.errors();
        for (size_t i = 0; i < kWhich.size(); ++i) {
            const Measured& m = e.*kWhich[i];
            sums[i] += m.value / kTrials;
            squares[i] += m.value * m.value / kTrials;
            reported[i] += m.error * m.error / kTrials;
        }
    }
    // The spread is known to 1 / sqrt(2 x 200) = 5 %; 5/6 of it are less 3 and more 3 of those.
    for (size_t i = 0; i < kWhich.size(); ++i) {
        const double spread = std::sqrt(squares[i] - sums[i] * sums[i]);
        EXPECT_GT(std::sqrt(reported[i]), 0.7 * spread) << i;
        EXPECT_LT(std::sqrt(reported[i]), 1.05 * spread) << i;
    }
}

TEST(FlightTime, IsComparedAlongWhatDiscardWouldReach)
{
    const std::vector<Reached> known{{1, 1}, {2, 0.5}, {4, 0.25}};
    EXPECT_NEAR(equalTimeRatio(known, {1, 0.5}), 0.5, 1e-12);
    EXPECT_NEAR(equalTimeRatio(known, {2, 0.5}), 1, 1e-12);
    EXPECT_NEAR(equalTimeRatio(known, {3, 0.1}), 0.3, 1e-12);
    EXPECT_NEAR(equalTimeRatio(known, {0.5, 1}), 0.5, 1e-12);
    EXPECT_NEAR(equalTimeRatio(known, {16, 1}), 16, 1e-9);
    EXPECT_TRUE(std::isnan(equalTimeRatio({known[0]}, {1, 1})));
    EXPECT_TRUE(std::isnan(equalTimeRatio({known[0], {1, 0.5}}, {2, 1})));
    EXPECT_TRUE(std::isnan(equalTimeRatio({known[0], {2, 0}}, {2, 1})));
    EXPECT_TRUE(std::isnan(equalTimeRatio(known, {0, 1})));
}

TEST(ReportText, ColumnsStayApartWhateverIsInThem)
{
    EXPECT_EQ(report::padded("ra", 4), "ra  ");
    EXPECT_EQ(report::padded("svgf", 4), "svgf ");
    EXPECT_EQ(report::padded("0.00917 +- 0.0047", 14) + "0.0821", "0.00917 +- 0.0047 0.0821");
}

TEST(FlightSweep, ChangesOneParameterWithinItsRange)
{
    const core::ReuseParams usual;
    const auto swept = sweptValues(usual, false);
    EXPECT_TRUE(swept.contains("records") && swept.contains("candidates"));
    EXPECT_TRUE(swept.contains("history") && swept.contains("protection"));
    EXPECT_FALSE(swept.contains("seed") || swept.contains("max-depth"));
    for (const auto& one : swept) {
        const std::string& name = one.first;  // clang 14 captures no structured bindings
        const auto& values = one.second;
        EXPECT_GE(values.size(), 2u) << name;
        EXPECT_TRUE(std::ranges::is_sorted(values)) << name;
        size_t standard = 0;
        for (const double value : values) {
            const core::ReuseParams changed = withValue(usual, name, value);
            standard += changed == usual ? 1u : 0u;
            core::ReuseParams::visit(changed, [&](const core::Field& field, const auto& member) {
                using Member = std::remove_cvref_t<decltype(member)>;
                if constexpr (std::is_arithmetic_v<Member>)
                    if (name == field.name) {
                        EXPECT_EQ(double(member), value) << name;
                        EXPECT_GE(value, field.range.low) << name;
                        EXPECT_LE(value, field.range.high) << name;
                    }
            });
        }
        EXPECT_EQ(standard, 1u) << name;
    }
    EXPECT_LT(sweptValues(usual, true).at("history").size(), swept.at("history").size());
}

/// Two flights of two frames of 16x16 pixels on the CPU.
app::FlightBenchOptions smallFlights(const std::filesystem::path& scene,
                                     const std::filesystem::path& output)
{
    app::FlightBenchOptions options;
    options.scenes.resize(1);
    options.scenes[0].file = scene;
    options.output = output;
    options.device = app::DeviceKind::cpu;
    options.size = glm::uvec2(16, 16);
    options.frames = 2;
    options.steps = {1};
    options.seeds = 2;
    options.params = core::ReuseParams{};
    return options;
}

/// Errors in units of Discard's are known no better than these.
TEST(FlightMeasurement, SweepsKnowWhatTheirUnitIsWorth)
{
    const tests::TemporaryFolder folder;
    app::FlightBenchOptions options =
        smallFlights(REKINDLE_SOURCE_DIR "/assets/cornell-diffuse.gltf", folder.path());
    options.referenceSpp = 64;
    options.quick = true;
    options.strategies = {core::ReuseStrategy::discard, core::ReuseStrategy::ra};
    Measurement measurement(options, {.progress = [](const std::string&) {},
                                      .warn = [](const std::string& w) { ADD_FAILURE() << w; },
                                      .loading = {},
                                      .stop = {}});
    measurement.measureScene(0);
    measurement.sweep();
    ASSERT_FALSE(measurement.results().sweeps.empty());
    const PictureErrors& unit = measurement.results().scenes.at(0).atRest.front().errors;
    const auto expectRatio = [](const Measured& ratio, const Measured& a, const Measured& b) {
        EXPECT_DOUBLE_EQ(ratio.value, a.value / b.value);
        EXPECT_NEAR(ratio.error, ratio.value * std::hypot(a.error / a.value, b.error / b.value),
                    1e-9 * ratio.error);
        EXPECT_GT(ratio.error, ratio.value * b.error / b.value);
    };
    for (const SweepPoint& point : measurement.results().sweeps) {
        SCOPED_TRACE(point.parameter + ' ' + std::to_string(point.value));
        expectRatio(point.ratio, point.errors.relMse, unit.relMse);
        expectRatio(point.trimmedRatio, point.errors.trimmed, unit.trimmed);
    }
}

TEST(FlightMeasurement, WindowsAreFlownByWhatWasMeasured)
{
    const auto crews = [](const std::vector<std::string>& names, float rays) {
        std::string text;
        for (const Crew& crew : crewsOf(names, rays))
            text += std::string(core::enumName(crew.strategy)) + ' ' +
                    app::report::printed("%g", double(crew.rays)) + ',';
        return text;
    };
    EXPECT_EQ(crews({"discard", "naive", "reweighting", "ra", "svgf"}, 1),
              "discard 1,naive 1,ra 1,ra 0.5,ra 0.25,svgf 1,");
    EXPECT_EQ(crews({"discard", "naive"}, 0.3f), "discard 0.3,naive 0.3,");
}

/// What was measured of a scene stays when its window cannot be opened.
TEST(FlightMeasurement, OutlivesAWindowThatCannotBe)
{
    const tests::TemporaryFolder folder;
    const std::filesystem::path assets = REKINDLE_SOURCE_DIR "/assets/";
    for (const char* name : {"cornell-diffuse.gltf", "cornell-diffuse.bin"})
        std::filesystem::copy_file(assets / name, folder.path() / name);
    app::FlightBenchOptions options =
        smallFlights(folder.path() / "cornell-diffuse.gltf", folder.path());
    options.referenceSpp = 2;
    options.window = glm::uvec2(16, 16);
    options.strategies = {core::ReuseStrategy::discard};
    std::string warnings;
    Measurement measurement(options, {.progress = [](const std::string&) {},
                                      .warn = [&](const std::string& w) { warnings += w; },
                                      .loading = {},
                                      .stop = {}});
    measurement.measureScene(0);
    ASSERT_EQ(measurement.results().scenes.size(), 1u);
    EXPECT_EQ(warnings, "");
    std::filesystem::remove(options.scenes[0].file);
    measurement.measureWindow(0);
    EXPECT_TRUE(contains(warnings, "no flights in the window's loop")) << warnings;
    EXPECT_TRUE(contains(warnings, "cornell-diffuse.gltf")) << warnings;
    ASSERT_EQ(measurement.results().scenes.size(), 1u);
    EXPECT_FALSE(measurement.results().scenes[0].rows.empty());
    EXPECT_TRUE(measurement.results().scenes[0].window.empty());
}

}  // namespace
}  // namespace app::flight

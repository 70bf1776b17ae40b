// The laboratory's page: codes go with names, links lead to files and columns that are there, maps
// are whole, the picture shows the values of the run; well-formed whatever was measured.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/lab/flatland_picture.h"
#include "app/lab/functions.h"
#include "app/lab/lab_files.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/report.h"
#include "app/lab/report_data.h"
#include "app/report/map.h"
#include "app/report/text.h"
#include "core/image/png_file.h"
#include "tests/support/files/markup.h"
#include "tests/support/files/pattern.h"
#include "tests/support/files/temporary_folder.h"
#include "tests/support/files/text_search.h"
#include "tests/support/methods/lab_results.h"

namespace app::lab {
namespace {

using tests::cellOf;
using tests::contains;
using tests::hostileResults;
using tests::Markup;
using tests::Pattern;
using tests::readMarkup;
using tests::someResults;
using Json = nlohmann::json;

bool isPicture(const std::string& reference)
{
    return reference.starts_with("data:image/png;base64,");
}

/// Every piece of the page from `first` to the next `last`, with both. A regular expression would
/// need a stack as deep as the piece is long.
std::vector<std::string> pieces(const std::string& html, const std::string& first,
                                const std::string& last)
{
    std::vector<std::string> found;
    size_t at = 0;
    while ((at = html.find(first, at)) != std::string::npos) {
        const size_t end = html.find(last, at);
        if (end == std::string::npos) break;
        found.push_back(html.substr(at, end + last.size() - at));
        at = end;
    }
    return found;
}

/// What a person reads: text and tooltips, without style, addresses and ids.
std::string readText(const std::string& html)
{
    std::string text = html.substr(html.find("</style>"));
    text = Pattern("<[^>]*title=\"([^\"]*)\"[^>]*>").replace(text, " $1 ");
    return Pattern("<[^>]*>").replace(text, " ");
}

const std::map<std::string, std::string>& names()
{
    static const std::map<std::string, std::string> known = [] {
        std::map<std::string, std::string> list;
        for (const Pair& pair : pairs()) list[pair.id] = pair.name;
        for (const TestFunction& f : functions()) list[f.id] = f.name;
        return list;
    }();
    return known;
}

/// Codes that stand without their name, with some text around them.
std::vector<std::string> lonelyCodes(const std::string& html)
{
    const std::string text = readText(html);
    std::vector<std::string> lonely;
    for (size_t at = 0; at + 1 < text.size(); ++at) {
        const auto name = names().find(text.substr(at, 2));
        const bool inWord = at > 0 && std::isalnum(static_cast<unsigned char>(text[at - 1]));
        const bool goesOn =
            at + 2 < text.size() && std::isalnum(static_cast<unsigned char>(text[at + 2]));
        if (name == names().end() || inWord || goesOn) continue;
        const size_t behind = text.find_first_not_of(" \n", at + 2);
        const std::string before = name->second + " (";
        const bool follows = behind != std::string::npos &&
                             text.compare(behind, name->second.size(), name->second) == 0;
        const bool precedes =
            at >= before.size() && text.compare(at - before.size(), before.size(), before) == 0;
        if (!follows && !precedes) lonely.push_back(text.substr(at < 30 ? 0 : at - 30, 60));
    }
    return lonely;
}

void expectReadable(const std::string& html)
{
    const Markup m = readMarkup(html);
    EXPECT_EQ(m.problem, "");
    std::set<std::string> files{"lab.json"};
    for (const LabFile& file : labFiles()) files.insert(file.name);
    for (const std::string& reference : m.references) {
        ASSERT_FALSE(reference.empty());
        if (reference[0] == '#')
            EXPECT_TRUE(m.ids.count(reference.substr(1))) << reference;
        else
            EXPECT_TRUE(isPicture(reference) || files.count(reference)) << reference;
    }
    for (const char* foreign : {"script", "link", "img", "iframe", "object"})
        EXPECT_FALSE(m.names.count(foreign)) << foreign;
    EXPECT_FALSE(contains(html, "@import"));
    EXPECT_FALSE(contains(html, "url("));
    const auto number =
        Pattern(R"([^a-z](nan|inf|infinity)[^a-z])", true).find(tests::withoutPictures(html));
    EXPECT_FALSE(number) << number->front();
}

TEST(LabPage, IsWellFormedAndStandsAlone)
{
    const std::string html = reportHtml(someResults());
    expectReadable(html);
    for (const char* id :
         {"picture", "summary", "idea", "winners", "losses", "methods", "densities", "table",
          "checks", "sweeps", "majorisation", "lobes", "flatland", "traps", "files"})
        EXPECT_TRUE(contains(html, std::string("<section id=\"") + id + "\"")) << id;
    for (const Method& m : methods())
        EXPECT_TRUE(contains(html, app::report::escapeMarkup(m.formula))) << m.id;
    EXPECT_TRUE(contains(html, "prefers-color-scheme:dark"));
    EXPECT_FALSE(contains(html, "A quick run"));
    LabResults quick = someResults();
    quick.quick = true;
    EXPECT_TRUE(contains(reportHtml(quick), "A quick run"));
}

TEST(LabPage, SurvivesWhateverWasMeasured)
{
    expectReadable(reportHtml(hostileResults()));
    expectReadable(reportHtml(LabResults{}));
    LabResults sparse;  // lists with one entry, entries with nothing in them
    sparse.cells.resize(1);
    sparse.overC.resize(1);
    sparse.overK.resize(1);
    sparse.majorisation.resize(1);
    sparse.lobes.resize(1);
    sparse.flatland.resize(1);
    sparse.picture.strips.resize(1);
    sparse.picture.pixels = 2;
    sparse.picture.width = 1;
    sparse.traps.resize(1);
    expectReadable(reportHtml(sparse));
}

// --- names

TEST(LabPage, EveryCodeStandsWithItsName)
{
    std::set<std::string> different;
    for (const auto& [code, name] : names()) different.insert(name);
    EXPECT_EQ(different.size(), kPairs + kFunctions);
    LabResults r = someResults();
    r.cells[5].mean = 2;  // off, and named in the summary
    const std::string html = reportHtml(r);
    for (const std::string& place : lonelyCodes(html)) ADD_FAILURE() << place;
    for (const auto& [code, name] : names()) EXPECT_TRUE(contains(html, code + " " + name)) << code;
    // The search sees what it is for.
    EXPECT_EQ(lonelyCodes("</style><p>wins in D3 and F2</p>").size(), 2u);
    EXPECT_EQ(lonelyCodes("</style><td title=\"D3\">1</td>").size(), 1u);
    EXPECT_TRUE(lonelyCodes("</style><b>D3</b> <i>large shift</i>, box (F4), DF4").empty());
}

// --- links

std::vector<std::string> split(const std::string& line)
{
    std::vector<std::string> fields;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
}

/// "picture.strips.noise": the first of each list is asked.
bool holdsKey(Json json, const std::string& path)
{
    std::stringstream stream(path);
    for (std::string key; std::getline(stream, key, '.');) {
        if (json.is_array()) json = json.at(0);
        if (!json.contains(key)) return false;
        json = Json(json.at(key));
    }
    return true;
}

std::string textOf(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(LabPage, LinksLeadToFilesAndColumnsOfTheRun)
{
    const tests::TemporaryFolder folder;
    writeLabFiles(folder.path(), someResults());
    const std::string html = textOf(folder / "index.html");
    for (const std::string& reference : readMarkup(html).references) {
        if (reference[0] == '#' || isPicture(reference)) continue;
        EXPECT_TRUE(std::filesystem::is_regular_file(folder / reference)) << reference;
    }
    const Json json = Json::parse(textOf(folder / "lab.json"));
    std::set<std::string> linked;
    for (const std::string& line : pieces(html, "<p class=\"data\">", "</p>")) {
        const auto file = Pattern("href=\"([^\"]*)\"").find(line);
        ASSERT_TRUE(file) << line;
        const std::string name = file->at(1);
        linked.insert(name);
        const std::string text = textOf(folder / name);
        const std::vector<std::string> columns = split(text.substr(0, text.find('\n')));
        for (const auto& column : Pattern("<code>(.*?)</code>").findAll(line)) {
            const bool there = name == "lab.json" ? holdsKey(json, column[1])
                                                  : std::find(columns.begin(), columns.end(),
                                                              column[1]) != columns.end();
            EXPECT_TRUE(there) << name << ": " << column[1];
        }
    }
    for (const LabFile& file : labFiles()) {
        EXPECT_TRUE(linked.count(file.name)) << file.name << " is linked from nowhere";
        for (const std::string& key : split(Pattern(" ").replace(file.key, "")))
            EXPECT_TRUE(holdsKey(json, key)) << key;
    }
}

TEST(LabPage, NoPlotIsWithoutItsData)
{
    for (const std::string& section :
         pieces(reportHtml(someResults()), "<section id=", "</section>"))
        for (const char* shown : {"<svg", "<table"}) {
            const size_t last = section.rfind(shown);
            if (last == std::string::npos || section.starts_with("<section id=\"files\"")) continue;
            EXPECT_TRUE(section.find("class=\"data\"", last) != std::string::npos)
                << section.substr(0, 30) << ": " << shown;
        }
}

// --- maps

TEST(LabPage, MapsHaveACellForEveryRowAndColumn)
{
    const std::string html = reportHtml(someResults());
    const std::vector<std::string> maps = pieces(html, "<figure class=\"map\"", "</figure>");
    EXPECT_GE(maps.size(), 10u);
    for (const std::string& map : maps) {
        const size_t rows = Pattern("class=\"label maprow\"").findAll(map).size(),
                     columns = Pattern("class=\"label maphead\"").findAll(map).size(),
                     cells = Pattern("<rect [^>]*class=\"heat ").findAll(map).size(),
                     titles = Pattern("<title>[^<]+</title>").findAll(map).size();
        EXPECT_TRUE(columns == kFunctions || columns == kPairs);
        EXPECT_EQ(cells, rows * columns);
        EXPECT_EQ(titles, cells);
        EXPECT_TRUE(Pattern("<figcaption>[^<]+</figcaption>").find(map)) << map.substr(0, 99);
    }
}

TEST(LabPage, MapsOfOutcomesSayWhatTheCellsSay)
{
    LabResults r = someResults();
    size_t wins = 0, losses = 0;
    for (size_t i = 0; i < r.cells.size(); ++i) {
        const Cell& ra = r.cells[i];
        if (ra.method != "ra" || ra.beta != Beta::none) continue;
        for (const Cell& c : r.cells)
            if (c.method == "discard" && c.pair == ra.pair && c.function == ra.function) {
                wins += ra.expectedVariance < c.expectedVariance;
                losses += ra.expectedVariance > c.expectedVariance;
            }
    }
    const std::string html = reportHtml(r);
    const std::vector<std::string> found =
        pieces(html, "<figure class=\"map\" id=\"duel-ra-discard\">", "</figure>");
    ASSERT_EQ(found.size(), 1u);
    const std::string& map = found[0];
    // Signs, so that grey says the same as colour.
    EXPECT_EQ(Pattern(">\\+</text>").findAll(map).size(), wins);
    EXPECT_EQ(Pattern(">−</text>").findAll(map).size(), losses);
    EXPECT_EQ(Pattern("heat fill c-blue").findAll(map).size(), wins);
    EXPECT_EQ(Pattern("heat fill c-red").findAll(map).size(), losses);
}

TEST(LabPage, WorthIsTheMedianOfRatiosToDiscard)
{
    LabResults r;
    std::vector<Row> rows;
    const double variances[] = {3, 0.5, 0.25, kInfinite};
    for (size_t i = 0; i < std::size(variances); ++i) {
        const std::string f = functions()[i].id;
        rows.push_back({"D2", f});
        r.cells.push_back(cellOf("D2", f, "discard", 1));
        r.cells.push_back(cellOf("D2", f, "ra", variances[i]));
    }
    const Column ra{"ra", Beta::none, 4};
    const Worth all = worthOf(CellTable(r, 1), ra, rows);
    EXPECT_EQ(all.rows, 4u);
    EXPECT_DOUBLE_EQ(all.median, 1.75);
    EXPECT_TRUE(all.withinBudget);
    r.cells[0].expectedVariance = kInfinite;  // of Discard where R-A has 3
    r.cells[3].expectedMean = 2;              // biased: left out
    r.cells[5].rays = 30;
    const Worth some = worthOf(CellTable(r, 1), ra, rows);
    EXPECT_EQ(some.rows, 3u);  // 0, 0.25, infinite
    EXPECT_DOUBLE_EQ(some.median, 0.25);
    EXPECT_FALSE(some.withinBudget);
    EXPECT_EQ(worthOf(CellTable(r, 1), {"mis"}, rows).rows, 0u);
    EXPECT_EQ(app::report::ratioStyle(1.01), "none");
    EXPECT_EQ(app::report::ratioStyle(0.5), "b2");
    EXPECT_EQ(app::report::ratioStyle(kInfinite), "w3");
    EXPECT_EQ(app::report::ratioStyle(0), "b3");
}

// --- the picture

std::vector<std::byte> fromBase64(const std::string& text)
{
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<std::byte> bytes;
    uint32_t bits = 0, count = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6 | static_cast<uint32_t>(letters.find(c));
        count += 6;
        if (count < 8) continue;
        count -= 8;
        bytes.push_back(static_cast<std::byte>(bits >> count & 255));
    }
    return bytes;
}

/// The embedded pictures of a page.
std::vector<core::RawImage> picturesOf(const std::string& html)
{
    std::vector<core::RawImage> images;
    for (const auto& found : Pattern("base64,([^\"]*)").findAll(html)) {
        const core::DecodedImage decoded = core::decodePng(fromBase64(found[1]), {});
        EXPECT_EQ(decoded.problem, "");
        images.push_back(decoded.image);
    }
    return images;
}

TEST(LabPage, PictureShowsTheValuesOfTheRun)
{
    const LabResults r = someResults();
    const std::vector<core::RawImage> images = picturesOf(reportHtml(r));
    ASSERT_EQ(images.size(), r.picture.strips.size());
    std::map<double, int> greys;
    for (size_t s = 0; s < images.size(); ++s) {
        const std::vector<double>& values = r.picture.strips[s].values;
        EXPECT_EQ(images[s].width, r.picture.pixels);
        EXPECT_EQ(images[s].channels, 1u);
        ASSERT_EQ(images[s].pixels.size(), values.size());
        for (size_t i = 0; i < values.size(); ++i)
            greys[values[i]] = static_cast<int>(images[s].pixels[i]);
    }
    EXPECT_EQ(greys.begin()->first, 0);
    EXPECT_EQ(greys.begin()->second, 0);  // black
    int last = -1;
    for (const auto& [value, shade] : greys) {
        EXPECT_GT(shade, last) << value;
        last = shade;
    }
    EXPECT_TRUE(contains(reportHtml(r), "would need 4.0 times as many"));
}

/// What is wrong and does not show is not called right.
TEST(LabPage, PicturesDoNotCallTheWrongWayRight)
{
    const auto saying = [](const LabResults& r, const std::string& words) {
        const std::string html = reportHtml(r);
        size_t count = 0;
        for (size_t at = html.find(words); at != std::string::npos; at = html.find(words, at + 1))
            ++count;
        return count;
    };
    LabResults r = someResults();
    const size_t right = saying(r, "right on average, as far as can be seen");
    EXPECT_EQ(saying(r, "its error on average does not show"), 0u);
    FlatlandStrip& wrong = r.picture.strips.back();
    ASSERT_FALSE(wrong.unbiased);
    wrong.biasSeen = false;
    EXPECT_EQ(saying(r, "right on average, as far as can be seen"), right);
    EXPECT_EQ(saying(r, "its error on average does not show"), 1u);
}

TEST(LabPage, PictureIsRenderedByTheLaboratory)
{
    const FlatlandPicture p = flatlandPicture(1);
    const auto strip = [&p](const std::string& name) -> const FlatlandStrip& {
        return *std::find_if(p.strips.begin(), p.strips.end(),
                             [&](const FlatlandStrip& s) { return s.name == name; });
    };
    ASSERT_EQ(p.strips.size(), 6u);
    ASSERT_EQ(p.truth.size(), p.pixels);
    for (const FlatlandStrip& s : p.strips) {
        ASSERT_EQ(s.values.size(), static_cast<size_t>(p.pixels) * (s.exact ? 1 : p.rows));
        EXPECT_EQ(s.biasSeen, !s.unbiased) << s.name << ' ' << s.bias;
    }
    EXPECT_EQ(strip("after").values, p.truth);
    // The glint was at the left and is at the right.
    const auto brightest = [](const std::vector<double>& values) {
        return std::max_element(values.begin(), values.end()) - values.begin();
    };
    EXPECT_LT(brightest(strip("before").values) + 30, brightest(p.truth));
    // Reuse is smoother than starting anew, and the average of old values is smooth and wrong.
    const double anew = strip("discard").noise;
    EXPECT_LT(strip("exact, 32 old, corrected").noise, 0.7 * anew);
    EXPECT_LT(strip("old values").noise, 0.7 * anew);
    EXPECT_GT(strip("old values").bias, 0.3);
    size_t fresh = 0;
    for (const FlatlandSample& s : p.samples) {
        fresh += s.fresh;
        EXPECT_GE(s.weight, 0);
        EXPECT_LE(s.weight, 1 + 1e-9);
        EXPECT_TRUE(s.ground >= 0.08 && s.ground < 0.16) << s.ground;
    }
    EXPECT_TRUE(fresh >= 1 && fresh <= 4 && fresh < p.samples.size());
    EXPECT_EQ(flatlandPicture(1).strips[2].values, p.strips[2].values);
    EXPECT_NE(flatlandPicture(2).strips[2].values, p.strips[2].values);
}

}  // namespace
}  // namespace app::lab

// The laboratory's report and files on made-up results: what they count, and that they stay
// well-formed whatever they are given.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/lab/lab_files.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/report.h"
#include "app/lab/report_data.h"
#include "app/report/svg.h"
#include "app/report/text.h"
#include "tests/support/markup.h"
#include "tests/support/pattern.h"

namespace {

using namespace app::lab;
using namespace app::report;
using tests::Markup;
using tests::readMarkup;
using Json = nlohmann::json;

constexpr double kNaN = kUnknown;

bool contains(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

Cell cellOf(const std::string& pair, const std::string& function, const std::string& method,
            double expected)
{
    Cell c;
    c.pair = pair;
    c.function = function;
    c.method = method;
    c.oldSamples = 8;
    c.newSamples = methodOf(method).fresh ? 8 : 0;
    c.rays = c.newSamples;
    c.candidates = method == "ra" ? 4 : 0;
    c.trials = 1000;
    c.truth = 1;
    c.mean = 1.001;
    c.standardError = 0.001;
    c.expectedVariance = c.variance = expected;
    c.varianceError = 0.01;
    c.ess = 7;
    return c;
}

/// All pairs and functions with a few methods, their variances drawn at random.
LabResults someResults()
{
    LabResults r;
    r.trials = 1000;
    r.seed = 5;
    r.seconds = 1.5;
    r.version = "0.0.1";
    r.commit = "c0ffee";
    std::mt19937 random(7);
    std::uniform_real_distribution<double> size(0.1, 2);
    for (const Pair& pair : pairs())
        for (const TestFunction& f : functions()) {
            for (const char* method : {"discard", "reweighting", "ra", "mis"})
                r.cells.push_back(cellOf(pair.id, f.id, method, size(random)));
            for (const Beta beta : {Beta::ideal, Beta::own})
                for (const char* method : {"ra", "mis"}) {
                    Cell c = cellOf(pair.id, f.id, method, size(random));
                    c.beta = beta;
                    if (beta == Beta::own) c.expectedVariance = kNaN;
                    r.cells.push_back(c);
                }
        }
    for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0})
        r.overC.push_back({"D2", "F1", factor, 4, size(random), 0.02, size(random), 0.3});
    for (const uint32_t k : {1u, 4u, 16u})
        r.overK.push_back({"D2", "F2", 1, k, size(random), 0.02, size(random), 0.3});
    for (int i = 0; i < 5; ++i)
        r.majorisation.push_back({0.45 + 0.1 * i, 1 + i * 1.0, 1 + i * 2.0, 0.5, 2, 0.1 * i, 0.5});
    for (const bool unbiased : {true, false}) {
        LobeSequence s{0.01, unbiased ? "R-A" : "equal weights", 8, unbiased, {}, 0.1, 0.107, 0.01};
        for (int i = 0; i < 40; ++i) s.frames.push_back({0.001 * i, 0.1 * i, 1 / (1.0 + i)});
        r.lobes.push_back(s);
    }
    for (const double step : {0.01, 0.04}) r.stores.push_back({step, 16, 64, 1, 0.08, 2});
    r.stores.push_back({0.01, 16, 16, 0, 0.2, 1});
    r.flatland.push_back({"exact", "with all that it takes", true, 1.58516, 1.585, -1e-4, -0.4,
                          0.1005, 0.001, 0, 0.1, 1, 1000});
    r.traps.push_back({"a trap", "this way", "that way", -0.0052, -17, 1e-5, 0.2, -0.0052, 2000});
    return r;
}

/// Every value that a measurement can have, and text that looks like markup.
LabResults hostileResults()
{
    LabResults r = someResults();
    const double odd[] = {kNaN, kInfinite, -kInfinite, 0, -1, 1e300, 1e-300};
    size_t i = 0;
    const auto next = [&] { return odd[i++ % std::size(odd)]; };
    for (Cell& c : r.cells)
        for (double* x : {&c.c, &c.mean, &c.standardError, &c.variance, &c.varianceError,
                          &c.expectedVariance, &c.expectedMean, &c.rays, &c.densities, &c.ess})
            *x = next();
    for (auto* list : {&r.overC, &r.overK})
        for (SweepPoint& p : *list)
            for (double* x : {&p.variance, &p.varianceError, &p.expectedVariance, &p.z})
                *x = next();
    for (MajorisationPoint& p : r.majorisation)
        for (double* x : {&p.position, &p.rejection, &p.augmentation, &p.c, &p.growth,
                          &p.totalVariation, &p.reweightingEss})
            *x = next();
    for (LobeSequence& s : r.lobes) {
        for (double* x : {&s.lateVarianceRatio, &s.expectedRatio, &s.largestBias}) *x = next();
        for (LobeFrame& f : s.frames)
            for (double* x : {&f.bias, &f.z, &f.varianceRatio}) *x = next();
    }
    for (StoreResult& s : r.stores)
        for (double* x : {&s.lateVarianceRatio, &s.largestZ}) *x = next();
    for (FlatlandResult& f : r.flatland)
        for (double* x : {&f.truth, &f.mean, &f.bias, &f.z, &f.variance, &f.varianceError,
                          &f.expectedBias, &f.expectedVariance, &f.meanWeight})
            *x = next();
    for (Trap& t : r.traps)
        for (double* x : {&t.wrongBias, &t.wrongZ, &t.rightBias, &t.rightZ, &t.expectedBias})
            *x = next();
    const std::string markup = "a,b \"<svg onload='x'>&amp;\n</td>";
    r.version = r.commit = markup;
    r.cells[0].pair = r.cells[0].function = markup;
    r.cells[1].method = r.lobes[0].method = r.flatland[0].variant = r.traps[0].wrong = markup;
    r.seconds = kNaN;
    return r;
}

void expectReadable(const std::string& html)
{
    const Markup m = readMarkup(html);
    EXPECT_EQ(m.problem, "");
    for (const std::string& reference : m.references) {
        ASSERT_FALSE(reference.empty());
        EXPECT_EQ(reference[0], '#') << reference;
        EXPECT_TRUE(m.ids.count(reference.substr(1))) << reference;
    }
    for (const char* foreign : {"script", "link", "img", "image", "iframe", "object"})
        EXPECT_FALSE(m.names.count(foreign)) << foreign;
    EXPECT_FALSE(contains(html, "@import"));
    EXPECT_FALSE(contains(html, "url("));
    const auto number = tests::Pattern(R"([^a-z](nan|inf|infinity)[^a-z])", true).find(html);
    EXPECT_FALSE(number) << number->front();
}

TEST(LabReport, StoresAreATableOfDesignsBySpeed)
{
    const std::string html = reportHtml(someResults());
    const size_t start = html.find("<h3>What to keep</h3>");
    ASSERT_NE(start, std::string::npos);
    const std::string part = html.substr(start, html.find("</table>", start) - start);
    EXPECT_TRUE(contains(part, "16 kept, N up to 64, bright ones spared (η = 1)</td><td "
                               "class=\"n\">0.0800</td><td class=\"n\">0.0800</td>"))
        << part;
    EXPECT_TRUE(contains(part, "16 kept, N up to 16</td><td class=\"n\">0.200</td><td "
                               "class=\"n\">·</td>"))
        << part;
}

TEST(LabReport, PageIsWellFormedAndStandsAlone)
{
    const std::string html = reportHtml(someResults());
    expectReadable(html);
    for (const char* id : {"summary", "idea", "winners", "losses", "methods", "densities", "table",
                           "checks", "sweeps", "majorisation", "lobes", "flatland", "traps"})
        EXPECT_TRUE(contains(html, std::string("<section id=\"") + id + "\"")) << id;
    for (const Method& m : methods()) EXPECT_TRUE(contains(html, escapeMarkup(m.formula))) << m.id;
    EXPECT_TRUE(contains(html, "prefers-color-scheme:dark"));
    EXPECT_FALSE(contains(html, "A quick run"));
    LabResults quick = someResults();
    quick.quick = true;
    EXPECT_TRUE(contains(reportHtml(quick), "A quick run"));
}

TEST(LabReport, SurvivesWhateverWasMeasured)
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
    sparse.traps.resize(1);
    expectReadable(reportHtml(sparse));
}

// --- what is counted

TEST(LabReport, SummaryCountsWhatTheCellsSay)
{
    LabResults r = someResults();
    size_t wins = 0, losses = 0, misLosses = 0, correctedLosses = 0;
    std::string lost;
    const auto varianceOf = [&r](const Cell& like, const char* method, Beta beta) {
        for (const Cell& c : r.cells)
            if (c.pair == like.pair && c.function == like.function && c.method == method &&
                c.beta == beta)
                return c.expectedVariance;
        return kNaN;
    };
    for (const Cell& c : r.cells) {
        if (c.method != "discard") continue;
        const double plain = varianceOf(c, "ra", Beta::none);
        wins += plain < c.expectedVariance;
        losses += plain > c.expectedVariance;
        misLosses += plain > varianceOf(c, "mis", Beta::none);
        correctedLosses += varianceOf(c, "ra", Beta::ideal) > c.expectedVariance;
        if (plain > c.expectedVariance && c.pair == "D3")
            lost += (lost.empty() ? "D3: " : ", ") + c.function;
    }
    ASSERT_GT(wins, 0u);
    ASSERT_GT(losses, 0u);
    ASSERT_FALSE(lost.empty());
    std::string html = reportHtml(r);
    EXPECT_TRUE(contains(html, "against Discard: lower in " + std::to_string(wins) +
                                   " of 72 rows, higher in " + std::to_string(losses) + " ("));
    EXPECT_TRUE(contains(html, lost));
    EXPECT_TRUE(contains(html, "<b>" + std::to_string(misLosses) +
                                   " of 72</b>rows in which plain "
                                   "R-A loses to MIS"));
    EXPECT_TRUE(contains(html, "R-A loses to Discard in " + std::to_string(correctedLosses) +
                                   " of 72 rows instead of " + std::to_string(losses)));
    EXPECT_TRUE(contains(html, "In none of them is the mean farther"));
    EXPECT_TRUE(contains(html, std::to_string(r.cells.size()) + " cells"));

    // A mean and a variance that are off are named.
    for (Cell& c : r.cells)
        if (c.pair == "D5" && c.function == "F7" && c.method == "mis" && c.beta == Beta::none)
            c.mean = 1.0046;
        else if (c.pair == "D6" && c.function == "F2" && c.method == "discard")
            c.variance += 0.06;
    html = reportHtml(r);
    EXPECT_TRUE(contains(html, "In 1 the mean is farther"));
    EXPECT_TRUE(contains(html, "D5 F7 MIS"));
    EXPECT_TRUE(contains(html, "not in D6 F2 Discard"));
    const Verdict v = verdict(r);
    EXPECT_EQ(v.meansOff.size(), 1u);
    EXPECT_EQ(v.variancesOff.size(), 1u);
    // Of beta own and of old samples that miss the new support (D9) the bias is known.
    EXPECT_EQ(v.biased, 2u * 72 + 8);
    EXPECT_EQ(v.meansJudged, r.cells.size() - v.biased);
}

TEST(LabReport, VariancesAreComparedByWhatIsKnown)
{
    const auto compare = [](double expectedA, double measuredA, double expectedB,
                            double measuredB) {
        Cell a = cellOf("D2", "F1", "ra", expectedA), b = cellOf("D2", "F1", "mis", expectedB);
        a.variance = measuredA;
        b.variance = measuredB;
        EXPECT_EQ(compareVariance(a, b), -compareVariance(b, a));
        return compareVariance(a, b);
    };
    EXPECT_EQ(compare(1, 9, 2, 1), -1);  // the formula decides
    EXPECT_EQ(compare(1, 1, 1 + 1e-9, 2), 0);
    EXPECT_EQ(compare(0, 0, 1e-16, 0), 0);  // rounding
    EXPECT_EQ(compare(kInfinite, 0.1, 1, 1), 1);
    EXPECT_EQ(compare(kInfinite, 0.1, kInfinite, 1), 0);
    EXPECT_EQ(compare(kNaN, 1, 1, 1.02), 0);  // within the errors
    EXPECT_EQ(compare(kNaN, 1, 1, 1.2), -1);
}

TEST(LabReport, WinnersAreUnbiasedFiniteAndNotDear)
{
    LabResults r;
    r.cells = {cellOf("D9", "F1", "reweighting", 0.1), cellOf("D9", "F1", "discard", kInfinite),
               cellOf("D9", "F1", "full", 0.2),        cellOf("D9", "F1", "mis", 0.5),
               cellOf("D9", "F1", "ra", 0.6),          cellOf("D9", "F1", "mis", 0.3)};
    r.cells[2].rays = 15;
    r.cells[5].beta = Beta::ideal;
    const CellTable table(r, 1);
    ASSERT_EQ(table.rows().size(), 1u);
    const auto best = [&](const std::vector<Beta>& betas) {
        return winners(table, table.rows()[0], betas);
    };
    EXPECT_EQ(best({Beta::none}), std::vector<Column>{{"mis"}});
    EXPECT_EQ(best({Beta::none, Beta::ideal}), (std::vector<Column>{{"mis", Beta::ideal}}));
    EXPECT_TRUE(best({Beta::own}).empty());
    r.cells[3].expectedVariance = 0.6;
    EXPECT_EQ(best({Beta::none}).size(), 2u);  // a tie
}

TEST(LabReport, TablesAreByRatioOfNewToOldSamples)
{
    LabResults r;
    r.cells = {cellOf("D2", "F1", "discard", 1), cellOf("D2", "F1", "discard", 4),
               cellOf("D2", "F1", "reweighting", 2)};
    r.cells[1].newSamples = 2;
    EXPECT_EQ(ratios(r), (std::vector<double>{1, 0.25}));
    const CellTable full(r, 1), quarter(r, 0.25);
    const Row row{"D2", "F1"};
    EXPECT_EQ(full.find(row, {"discard"}), &r.cells[0]);
    EXPECT_EQ(quarter.find(row, {"discard"}), &r.cells[1]);
    EXPECT_EQ(full.find(row, {"reweighting"}), &r.cells[2]);  // has no n
    EXPECT_EQ(quarter.find(row, {"reweighting"}), &r.cells[2]);
    EXPECT_EQ(full.find(row, {"mis"}), nullptr);
}

// --- files

TEST(LabFiles, JsonHasTheNamesAndNoNaN)
{
    const LabResults r = someResults();
    const Json json = Json::parse(labJson(r));
    for (const char* key :
         {"schema", "command", "version", "commit", "trials", "seed", "quick", "seconds", "methods",
          "cells", "sweep_c", "sweep_k", "majorisation", "lobes", "stores", "flatland", "traps"})
        EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json["command"], "lab");
    EXPECT_EQ(json["cells"].size(), r.cells.size());
    EXPECT_EQ(json["methods"].size(), methods().size());
    const Json& cell = json["cells"][2];
    for (const char* key :
         {"pair", "f", "method", "beta", "k", "n", "N", "c", "trials", "truth", "mean", "z",
          "n_var", "n_var_se", "expected_n_var", "rays", "densities", "ess"})
        EXPECT_TRUE(cell.contains(key)) << key;
    EXPECT_EQ(cell["method"], "ra");
    EXPECT_EQ(cell["k"], 4);
    EXPECT_EQ(cell["N"], 8);
    EXPECT_EQ(cell["beta"], "none");
    EXPECT_TRUE(cell["c"].is_null());
    EXPECT_NEAR(cell["z"].get<double>(), 1, 1e-9);
    EXPECT_EQ(cell["n_var"].get<double>(), r.cells[2].variance);  // to the last bit
    EXPECT_EQ(json["lobes"][0]["frames"].size(), 40u);

    LabResults odd = someResults();
    odd.cells[0].expectedVariance = kInfinite;
    odd.cells[1].expectedVariance = kNaN;
    const Json oddJson = Json::parse(labJson(odd));
    EXPECT_EQ(oddJson["cells"][0]["expected_n_var"], "infinite");
    EXPECT_TRUE(oddJson["cells"][1]["expected_n_var"].is_null());
    EXPECT_TRUE(Json::accept(labJson(hostileResults())));
    EXPECT_TRUE(Json::parse(labJson({}))["cells"].empty());
}

/// Fields of every record, quotes undone.
std::vector<std::vector<std::string>> readCsv(const std::string& text)
{
    std::vector<std::vector<std::string>> records;
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (size_t i = 0; i < text.size(); ++i) {
        if (quoted && text[i] == '"' && i + 1 < text.size() && text[i + 1] == '"')
            fields.back() += text[++i];
        else if (text[i] == '"')
            quoted = !quoted;
        else if (!quoted && text[i] == ',')
            fields.emplace_back();
        else if (!quoted && text[i] == '\n') {
            records.push_back(fields);
            fields.assign(1, "");
        } else
            fields.back() += text[i];
    }
    EXPECT_FALSE(quoted);
    EXPECT_EQ(fields, std::vector<std::string>(1)) << "no newline at the end";
    return records;
}

TEST(LabFiles, TablesHaveARowForEverything)
{
    const LabResults r = hostileResults();
    const std::vector<size_t> expected{
        r.cells.size(), r.overC.size() + r.overK.size(), r.majorisation.size(), 80, 3, 1, 1};
    const auto tables = labTables(r), none = labTables({});
    ASSERT_EQ(tables.size(), expected.size());
    for (size_t t = 0; t < tables.size(); ++t) {
        SCOPED_TRACE(tables[t].first);
        const auto records = readCsv(tables[t].second);
        ASSERT_EQ(records.size(), expected[t] + 1);
        for (const auto& record : records) EXPECT_EQ(record.size(), records[0].size());
        const std::set<std::string> names(records[0].begin(), records[0].end());
        EXPECT_EQ(names.size(), records[0].size());
        const auto empty = readCsv(none[t].second);
        ASSERT_EQ(empty.size(), 1u);
        EXPECT_EQ(empty[0], records[0]);
    }
    const auto cells = readCsv(tables[0].second);
    EXPECT_EQ(tables[0].first, "cells.csv");
    EXPECT_EQ(cells[0][0], "pair");
    EXPECT_EQ(cells[1][0], r.cells[0].pair);  // commas, quotes, line break and all
    const auto column = static_cast<size_t>(std::find(cells[0].begin(), cells[0].end(), "n_var") -
                                            cells[0].begin());
    ASSERT_LT(column, cells[0].size());
    for (size_t i = 0; i < r.cells.size(); ++i) {
        const double variance = r.cells[i].variance;
        const std::string& field = cells[i + 1][column];
        if (std::isfinite(variance)) {
            EXPECT_EQ(std::strtod(field.c_str(), nullptr), variance);
        } else {
            EXPECT_EQ(field, std::isnan(variance) ? "" : variance > 0 ? "infinite" : "-infinite");
        }
    }
}

}  // namespace

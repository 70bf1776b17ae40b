// The laboratory's report and files on made-up results: what they count.
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
#include "tests/support/files/text_search.h"
#include "tests/support/methods/lab_results.h"

namespace app::lab {
namespace {

using namespace report;
using tests::cellOf;
using tests::contains;
using tests::hostileResults;
using tests::someResults;
using Json = nlohmann::json;

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

// --- what is counted

/// A mean whose variance is infinite proves nothing, however far away its standard error says it
/// is.
TEST(LabReport, InfiniteVariancesHaveNoScore)
{
    Cell cell = cellOf("D2", "F1", "reweighting", 1);
    cell.mean = 1.5;
    cell.standardError = 0.01;
    EXPECT_NEAR(cell.z(), 50, 1e-9);
    cell.expectedVariance = kInfinite;
    EXPECT_EQ(cell.z(), 0);
}

TEST(LabReport, SummaryCountsWhatTheCellsSay)
{
    LabResults r = someResults();
    size_t wins = 0, losses = 0, misLosses = 0, correctedLosses = 0;
    const auto varianceOf = [&r](const Cell& like, const char* method, Beta beta) {
        for (const Cell& c : r.cells)
            if (c.pair == like.pair && c.function == like.function && c.method == method &&
                c.beta == beta)
                return c.expectedVariance;
        return kUnknown;
    };
    for (const Cell& c : r.cells) {
        if (c.method != "discard") continue;
        const double plain = varianceOf(c, "ra", Beta::none);
        wins += plain < c.expectedVariance;
        losses += plain > c.expectedVariance;
        misLosses += plain > varianceOf(c, "mis", Beta::none);
        correctedLosses += varianceOf(c, "ra", Beta::ideal) > c.expectedVariance;
    }
    ASSERT_GT(wins, 0u);
    ASSERT_GT(losses, 0u);
    std::string html = reportHtml(r);
    EXPECT_TRUE(contains(html, "against Discard: lower in " + std::to_string(wins) +
                                   " of 72 rows, higher in " + std::to_string(losses) +
                                   " (<a href=\"#duel-ra-discard\">map</a>)"));
    EXPECT_TRUE(contains(html, "Won " + std::to_string(wins) + ", tied 0, lost " +
                                   std::to_string(losses) + " of 72."));
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
    EXPECT_TRUE(contains(html, "widening (D5), ripples (F7), MIS"));
    EXPECT_TRUE(contains(html, "not in flat to ramp (D6), slope (F2), Discard"));
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
    EXPECT_EQ(compare(kUnknown, 1, 1, 1.02), 0);  // within the errors
    EXPECT_EQ(compare(kUnknown, 1, 1, 1.2), -1);
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
         {"schema",  "command",  "version", "commit",    "trials",    "seed",         "quick",
          "seconds", "methods",  "cells",   "sweep_c",   "sweep_k",   "majorisation", "lobes",
          "stores",  "flatland", "traps",   "densities", "functions", "picture"})
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
    odd.cells[1].expectedVariance = kUnknown;
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
    const std::vector<size_t> expected{r.cells.size(),
                                       pairs().size(),
                                       functions().size(),
                                       methods().size(),
                                       r.overC.size() + r.overK.size(),
                                       r.majorisation.size(),
                                       80,
                                       3,
                                       1,
                                       3 + 3 * 6,
                                       2,
                                       1};
    const auto tables = labTables(r), none = labTables({});
    ASSERT_EQ(tables.size(), expected.size());
    for (size_t t = 0; t < tables.size(); ++t) {
        SCOPED_TRACE(tables[t].first);
        const auto records = readCsv(tables[t].second);
        ASSERT_EQ(records.size(), expected[t] + 1);
        for (const auto& record : records) EXPECT_EQ(record.size(), records[0].size());
        const std::set<std::string> names(records[0].begin(), records[0].end());
        EXPECT_EQ(names.size(), records[0].size());
        EXPECT_EQ(tables[t].first, labFiles()[t].name);
        const auto empty = readCsv(none[t].second);
        // What is compared is known without a run.
        const bool fixed = t >= 1 && t <= 3;
        ASSERT_EQ(empty.size(), fixed ? records.size() : 1u);
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
}  // namespace app::lab

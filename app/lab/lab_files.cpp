// JSON and CSV of the laboratory. See lab_files.h.
#include "app/lab/lab_files.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <nlohmann/json.hpp>

#include "app/base/files.h"
#include "app/base/json_file.h"
#include "app/lab/functions.h"
#include "app/lab/methods.h"
#include "app/lab/pairs.h"
#include "app/lab/report.h"
#include "core/base/check.h"
#include "core/base/output_file.h"

namespace app::lab {

namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinities and no NaN.
Json number(double value)
{
    if (std::isnan(value)) return nullptr;
    if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
    return value;
}

Json cellJson(const Cell& c)
{
    return {{"pair", c.pair},
            {"f", c.function},
            {"method", c.method},
            {"beta", betaName(c.beta)},
            {"k", c.candidates},
            {"n", c.newSamples},
            {"N", c.oldSamples},
            {"c", number(c.c)},
            {"trials", c.trials},
            {"truth", number(c.truth)},
            {"mean", number(c.mean)},
            {"se", number(c.standardError)},
            {"z", number(c.z())},
            {"n_var", number(c.variance)},
            {"n_var_se", number(c.varianceError)},
            {"expected_mean", number(c.expectedMean)},
            {"expected_n_var", number(c.expectedVariance)},
            {"rays", number(c.rays)},
            {"densities", number(c.densities)},
            {"ess", number(c.ess)}};
}

Json sweepJson(const SweepPoint& p)
{
    return {{"pair", p.pair},
            {"f", p.function},
            {"c_factor", number(p.cFactor)},
            {"k", p.candidates},
            {"n_var", number(p.variance)},
            {"n_var_se", number(p.varianceError)},
            {"expected_n_var", number(p.expectedVariance)},
            {"z", number(p.z)}};
}

Json majorisationJson(const MajorisationPoint& p)
{
    return {{"position", number(p.position)},
            {"rejection", number(p.rejection)},
            {"augmentation", number(p.augmentation)},
            {"c", number(p.c)},
            {"growth", number(p.growth)},
            {"total_variation", number(p.totalVariation)},
            {"reweighting_ess", number(p.reweightingEss)}};
}

Json storeJson(const StoreResult& s)
{
    return {{"step", number(s.step)},
            {"kept", s.kept},
            {"cap", number(s.cap)},
            {"brightness", number(s.brightness)},
            {"late_variance_ratio", number(s.lateVarianceRatio)},
            {"largest_z", number(s.largestZ)}};
}

Json lobeJson(const LobeSequence& s)
{
    Json frames = Json::array();
    for (const LobeFrame& frame : s.frames)
        frames.push_back({{"bias", number(frame.bias)},
                          {"z", number(frame.z)},
                          {"variance_ratio", number(frame.varianceRatio)}});
    return {{"step", number(s.step)},
            {"method", s.method},
            {"k", s.candidates},
            {"unbiased", s.unbiased},
            {"late_variance_ratio", number(s.lateVarianceRatio)},
            {"expected_ratio", number(s.expectedRatio)},
            {"largest_bias", number(s.largestBias)},
            {"frames", frames}};
}

Json flatlandJson(const FlatlandResult& f)
{
    return {{"variant", f.variant},
            {"meaning", f.meaning},
            {"unbiased", f.unbiased},
            {"truth", number(f.truth)},
            {"mean", number(f.mean)},
            {"bias", number(f.bias)},
            {"expected_bias", number(f.expectedBias)},
            {"z", number(f.z)},
            {"variance", number(f.variance)},
            {"variance_se", number(f.varianceError)},
            {"expected_variance", number(f.expectedVariance)},
            {"mean_weight", number(f.meanWeight)},
            {"trials", f.trials}};
}

Json trapJson(const Trap& t)
{
    return {{"name", t.name},
            {"wrong", t.wrong},
            {"right", t.right},
            {"wrong_bias", number(t.wrongBias)},
            {"wrong_z", number(t.wrongZ)},
            {"expected_bias", number(t.expectedBias)},
            {"right_bias", number(t.rightBias)},
            {"right_z", number(t.rightZ)},
            {"trials", t.trials}};
}

/// Five decimals: a picture needs no more, and a text of them all stays short.
double rounded(double value)
{
    return std::isfinite(value) ? std::round(value * 1e5) / 1e5 : value;
}

Json stripJson(const FlatlandStrip& s)
{
    Json values = Json::array();
    for (const double value : s.values) values.push_back(number(rounded(value)));
    return {{"name", s.name},          {"meaning", s.meaning},     {"exact", s.exact},
            {"unbiased", s.unbiased},  {"noise", number(s.noise)}, {"bias", number(s.bias)},
            {"bias_seen", s.biasSeen}, {"values", values}};
}

Json sampleJson(const FlatlandSample& s)
{
    return {{"sample", s.fresh ? "new" : "old"},
            {"ground", number(s.ground)},
            {"direction", number(s.direction)},
            {"share", number(s.weight)}};
}

/// One pixel of one row of a strip.
Json pixelRow(const FlatlandPicture& picture, const FlatlandStrip& strip, size_t index)
{
    const size_t pixels = std::max<size_t>(picture.pixels, 1), pixel = index % pixels;
    const double share = (static_cast<double>(pixel) + 0.5) / static_cast<double>(pixels);
    const double truth = pixel < picture.truth.size() ? picture.truth[pixel] : kUnknown;
    const double value = index < strip.values.size() ? strip.values[index] : kUnknown;
    return {{"strip", strip.name},
            {"row", index / pixels},
            {"pixel", pixel},
            {"ground", number(rounded(picture.low + share * picture.width))},
            {"value", number(rounded(value))},
            {"truth", number(rounded(truth))}};
}

Json pairJson(const Pair& pair)
{
    const double c = pair.bestC(1, 1);
    return {{"pair", pair.id},
            {"name", pair.name},
            {"meaning", pair.meaning},
            {"formula", pair.formula},
            {"rejection", number(pair.rejectionConstant())},
            {"augmentation", number(pair.augmentationConstant())},
            {"total_variation", number(pair.residual(1))},
            {"c", number(c)},
            {"growth", number(1 / c)}};
}

Json functionJson(const TestFunction& f)
{
    return {{"f", f.id},
            {"name", f.name},
            {"formula", f.formula},
            {"integral", integrateFunctions(0, 1)[functionIndex(f.id)]}};
}

Json methodJson(const Method& m)
{
    return {{"id", m.id},           {"name", m.name},   {"formula", m.formula},
            {"meaning", m.meaning}, {"needs", m.needs}, {"unbiased", m.unbiased}};
}

std::string quoted(const std::string& text)
{
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string field = "\"";
    for (const char c : text) {
        if (c == '"') field += c;
        field += c;
    }
    return field + '"';
}

/// A value of a flat JSON object as a field of a table.
std::string field(const Json& value)
{
    if (value.is_null()) return {};
    return value.is_string() ? quoted(value.get<std::string>()) : value.dump();
}

/// Rows of a table from JSON objects with the same keys: so that both files use the same names.
class Table {
public:
    /// The names come from `sample`, so that a table without rows has them, too.
    explicit Table(const Json& sample)
    {
        for (const auto& [name, value] : sample.items()) {
            if (!text_.empty()) text_ += ',';
            text_ += quoted(name);
        }
        text_ += '\n';
    }
    void row(const Json& object)
    {
        bool first = true;
        for (const auto& [name, value] : object.items()) {
            if (!first) text_ += ',';
            text_ += field(value);
            first = false;
        }
        text_ += '\n';
    }
    const std::string& text() const { return text_; }

private:
    std::string text_;
};

Json withSweep(const char* over, const SweepPoint& point)
{
    Json row{{"sweep", over}};
    row.update(sweepJson(point));
    return row;
}

Json frameRow(const LobeSequence& sequence, size_t frame, const LobeFrame& values)
{
    return {{"step", number(sequence.step)},
            {"method", sequence.method},
            {"k", sequence.candidates},
            {"unbiased", sequence.unbiased},
            {"frame", frame},
            {"bias", number(values.bias)},
            {"z", number(values.z)},
            {"variance_ratio", number(values.varianceRatio)}};
}

/// What is one object: `"picture": {...}` with its lists.
std::string pictureText(const FlatlandPicture& p)
{
    Json truth = Json::array(), strips = Json::array(), samples = Json::array();
    for (const double value : p.truth) truth.push_back(number(rounded(value)));
    for (const FlatlandStrip& strip : p.strips) strips.push_back(stripJson(strip));
    for (const FlatlandSample& sample : p.samples) samples.push_back(sampleJson(sample));
    return ",\n \"picture\": " + jsonText(Json{{"low", number(p.low)},
                                               {"width", number(p.width)},
                                               {"pixels", p.pixels},
                                               {"rows", p.rows},
                                               {"truth", truth},
                                               {"strips", strips},
                                               {"samples", samples}});
}

/// `"name": [` and one line for each object.
std::string listText(const char* name, const std::vector<Json>& objects)
{
    std::string text = std::string(",\n \"") + name + "\": [";
    for (size_t i = 0; i < objects.size(); ++i)
        text += (i ? ",\n  " : "\n  ") + jsonText(objects[i]);
    return text + "]";
}

template <class T, class ToJson> std::vector<Json> each(const T& items, ToJson toJson)
{
    std::vector<Json> objects;
    for (const auto& item : items) objects.push_back(toJson(item));
    return objects;
}

}  // namespace

const char* betaName(Beta beta)
{
    switch (beta) {
    case Beta::none:
        return "none";
    case Beta::ideal:
        return "ideal";
    case Beta::own:
        return "own";
    }
    return "";
}

std::string labJson(const LabResults& r)
{
    const Json head{{"schema", 1},          {"command", "lab"},
                    {"version", r.version}, {"commit", r.commit},
                    {"trials", r.trials},   {"seed", r.seed},
                    {"quick", r.quick},     {"seconds", number(r.seconds)}};
    std::string text = "{";
    for (const auto& [name, value] : head.items())
        text += (text.size() > 1 ? ",\n " : "\n ") + Json(name).dump() + ": " + jsonText(value);
    text += listText("methods", each(methods(), methodJson));
    text += listText("densities", each(pairs(), pairJson));
    text += listText("functions", each(functions(), functionJson));
    text += listText("cells", each(r.cells, cellJson));
    text += listText("sweep_c", each(r.overC, sweepJson));
    text += listText("sweep_k", each(r.overK, sweepJson));
    text += listText("majorisation", each(r.majorisation, majorisationJson));
    text += listText("lobes", each(r.lobes, lobeJson));
    text += listText("stores", each(r.stores, storeJson));
    text += listText("flatland", each(r.flatland, flatlandJson));
    text += pictureText(r.picture);
    text += listText("traps", each(r.traps, trapJson));
    return text + "\n}\n";
}

std::span<const LabFile> labFiles()
{
    static constexpr LabFile kFiles[] = {
        {"cells.csv", "cells",
         "every method on every function under every change of density: mean, N·Var, their errors "
         "and predictions, cost"},
        {"densities.csv", "densities",
         "the changes of density: code, name, formula and exact constants"},
        {"functions.csv", "functions", "the functions: code, name, formula, integral over [0, 1]"},
        {"methods.csv", "methods", "the methods: name, formula, what they need"},
        {"sweeps.csv", "sweep_c, sweep_k",
         "R-A at multiples of the best c, and with k from 1 to 32"},
        {"majorisation.csv", "majorisation", "constants as a lobe moves away; exact"},
        {"lobes.csv", "lobes", "the moving lobe, frame by frame: bias and variance"},
        {"stores.csv", "stores", "what a history keeps, by the speed of the lobe"},
        {"flatland.csv", "flatland", "samples from another camera, in one pixel"},
        {"picture.csv", "picture", "the pixels of the picture at the top of the page, one by one"},
        {"samples.csv", "picture.samples", "the samples that are drawn in the scene above it"},
        {"traps.csv", "traps", "what looks right and is not: biases of both ways"},
    };
    return kFiles;
}

std::vector<std::pair<std::string, std::string>> labTables(const LabResults& r)
{
    Table cells(cellJson({})), densities(pairJson(pairs()[0])),
        shapes(functionJson(functions()[0])), ways(methodJson(methods()[0])),
        sweeps(withSweep("", {})), majorisation(majorisationJson({})), lobes(frameRow({}, 0, {})),
        stores(storeJson({})), flatland(flatlandJson({})), picture(pixelRow({}, {}, 0)),
        samples(sampleJson({})), traps(trapJson({}));
    for (const Cell& cell : r.cells) cells.row(cellJson(cell));
    for (const Pair& pair : pairs()) densities.row(pairJson(pair));
    for (const TestFunction& f : functions()) shapes.row(functionJson(f));
    for (const Method& method : methods()) ways.row(methodJson(method));
    for (const SweepPoint& point : r.overC) sweeps.row(withSweep("c", point));
    for (const SweepPoint& point : r.overK) sweeps.row(withSweep("k", point));
    for (const MajorisationPoint& point : r.majorisation) majorisation.row(majorisationJson(point));
    for (const LobeSequence& sequence : r.lobes)
        for (size_t i = 0; i < sequence.frames.size(); ++i)
            lobes.row(frameRow(sequence, i, sequence.frames[i]));
    for (const StoreResult& store : r.stores) stores.row(storeJson(store));
    for (const FlatlandResult& variant : r.flatland) flatland.row(flatlandJson(variant));
    for (const FlatlandStrip& strip : r.picture.strips)
        for (size_t i = 0; i < strip.values.size(); ++i) picture.row(pixelRow(r.picture, strip, i));
    for (const FlatlandSample& sample : r.picture.samples) samples.row(sampleJson(sample));
    for (const Trap& trap : r.traps) traps.row(trapJson(trap));
    const Table* tables[] = {&cells, &densities, &shapes,   &ways,    &sweeps,  &majorisation,
                             &lobes, &stores,    &flatland, &picture, &samples, &traps};
    CHECK(std::size(tables) == labFiles().size());
    std::vector<std::pair<std::string, std::string>> files;
    for (const LabFile& file : labFiles())
        files.emplace_back(file.name, tables[files.size()]->text());
    return files;
}

void writeLabFiles(const std::filesystem::path& folder, const LabResults& results)
{
    auto files = labTables(results);
    files.emplace_back("lab.json", labJson(results));
    files.emplace_back("index.html", reportHtml(results));
    for (const auto& [name, text] : files) core::writeFile(folder / name, text);
}

}  // namespace app::lab

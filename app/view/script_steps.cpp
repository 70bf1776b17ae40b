// See script_steps.h.
#include "app/view/script_steps.h"

#include <algorithm>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/base/nearest.h"
#include "app/session/actions.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

bool isPoint(const Json& p)
{
    return p.is_array() && p.size() == 2 && p[0].is_number() && p[1].is_number();
}

/// What a member of a step has to be.
struct Kind {
    const char* expected;
    bool (*holds)(const Json&);
};

constexpr Kind kNumberKind{"a number", [](const Json& j) { return j.is_number(); }};
constexpr Kind kTextKind{"a text", [](const Json& j) { return j.is_string(); }};
constexpr Kind kPointKind{"[x, y]", isPoint};
constexpr Kind kPointsKind{"[[x, y], [x, y]]", [](const Json& j) {
                               return j.is_array() && j.size() == 2 && isPoint(j[0]) &&
                                      isPoint(j[1]);
                           }};
constexpr Kind kCountKind{"a whole number from 0 to 1000000", [](const Json& j) {
                              return j.is_number_unsigned() && j.get<uint64_t>() <= 1'000'000;
                          }};
constexpr Kind kSeedKind{"a whole number, not negative",
                         [](const Json& j) { return j.is_number_unsigned(); }};
constexpr Kind kTextsKind{
    "a list of texts", [](const Json& j) {
        return j.is_array() && std::ranges::all_of(j, [](const Json& e) { return e.is_string(); });
    }};
constexpr Kind kStepsKind{"a list of steps", [](const Json& j) { return j.is_array(); }};

const std::vector<std::pair<std::string, Kind>> kKinds{
    {"do", kTextKind},     {"wait", kTextKind},    {"key", kTextKind},     {"drag", kPointsKind},
    {"click", kPointKind}, {"cursor", kPointKind}, {"wheel", kNumberKind}, {"drop", kTextKind},
    {"expect", kTextKind}, {"random", kCountKind}, {"repeat", kCountKind}};

// The members beside those; actions check their own.
const std::vector<std::pair<std::string, Kind>> kStepMembers{
    {"value", kNumberKind}, {"timeout", kNumberKind}, {"seconds", kNumberKind},
    {"text", kTextKind},    {"name", kTextKind},      {"times", kCountKind},
    {"frames", kCountKind}, {"button", kCountKind},   {"seed", kSeedKind},
    {"files", kTextsKind},  {"folder", kTextKind},    {"steps", kStepsKind}};

/// The member that says what a step is.
std::string kindOf(const Json& step, const std::string& place)
{
    if (!step.is_object() || step.empty())
        throw core::Error(place + ": expected a step: an object");
    std::vector<std::string> names;
    for (const auto& [kind, what] : kKinds) {
        if (step.contains(kind)) return kind;
        names.push_back(kind);
    }
    const std::string first = step.begin().key();
    throw core::Error(place + ": \"" + first + "\" is no step" + suggestion(first, names));
}

void checkStep(const Json& step, const std::string& kind, const std::string& place)
{
    const auto check = [&](const auto& table) {
        for (const auto& [name, what] : table)
            if (step.contains(name) && !what.holds(step[name]))
                throw core::Error(place + '/' + name + ": expected " + what.expected);
    };
    if (kind != "do") {
        check(kKinds);
        check(kStepMembers);
    } else if (!step["do"].is_string() || std::ranges::none_of(actions(), [&](const Action& a) {
                   return step["do"] == a.name;
               })) {
        throw core::Error(place + "/do: expected the name of an action");
    }
}

/// Checks all steps and puts them into their order, repetitions one after the other. `out` points
/// into `steps`.
void unroll(const Json& steps, const std::string& place, std::vector<const Json*>& out)
{
    constexpr size_t kMostSteps = 1'000'000;
    if (!steps.is_array()) throw core::Error(place + ": expected a list of steps");
    for (size_t i = 0; i < steps.size(); ++i) {
        const std::string here = place + '/' + std::to_string(i);
        const Json& step = steps[i];
        const std::string kind = kindOf(step, here);
        checkStep(step, kind, here);
        if (kind != "repeat") {
            out.push_back(&step);
            continue;
        }
        if (!step.contains("steps")) throw core::Error(here + "/steps: expected a list of steps");
        std::vector<const Json*> once;
        unroll(step["steps"], here + "/steps", once);
        const size_t times = step["repeat"].get<size_t>();
        if (times > 0 && once.size() > (kMostSteps - std::min(kMostSteps, out.size())) / times)
            throw core::Error(here + ": more than a million steps");
        if (once.empty()) continue;
        for (size_t n = 0; n < times; ++n) out.insert(out.end(), once.begin(), once.end());
    }
}

}  // namespace

ScriptSteps readScript(const fs::path& file)
{
    ScriptSteps script{std::make_unique<Json>(readJson(file)), {}};
    if (!script.document->is_object() || !script.document->contains("steps"))
        throw core::Error(file.string() + ": expected {\"steps\": [...]}");
    unroll((*script.document)["steps"], file.string() + ": /steps", script.order);
    return script;
}

}  // namespace app

// Runs the steps of a script, which stand in script_steps.h. A step that cannot be done, and a wait
// that runs out, fail the script, which goes on.
#include "app/view/script.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/view/random_walk.h"
#include "app/view/script_steps.h"
#include "app/view/window.h"
#include "core/base/check.h"

namespace app {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr double kDefaultTimeout = 60;

/// Median, 99th percentile and largest of a list of numbers.
Json distribution(std::vector<double> values)
{
    if (values.empty()) return {{"count", 0}};
    std::ranges::sort(values);
    const auto at = [&](double q) {
        return values[static_cast<size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
    };
    return {
        {"count", values.size()}, {"median", at(0.5)}, {"p99", at(0.99)}, {"max", values.back()}};
}

bool contains(const std::vector<Notice>& notices, const std::string& text)
{
    return std::ranges::any_of(
        notices, [&](const Notice& n) { return n.text.find(text) != std::string::npos; });
}

}  // namespace

struct Script::State {
    explicit State(ScriptSteps read) : script(std::move(read)), steps(script.order) {}

    ScriptSteps script;
    const std::vector<const Json*>& steps;
    size_t next = 0;
    double began = -1;  // of the present step, seconds; negative: it has not begun
    double firstStep = -1, now = 0;
    uint64_t stepFrames = 0;  // since it began
    std::vector<Json> log;
    std::vector<std::string> failures;
    std::vector<double> idle, busy, inputSeconds, inputFrames, stops;
    double lastStop = 0;
    struct Load {
        double started = 0;
        const Document* before = nullptr;  // on show then; another one has another address
    };
    std::optional<Load> load;
    std::vector<double> firstPictures;  // seconds from the end of a load
    std::optional<RandomWalk> walk;
    Json counters = Json::object();
    std::vector<std::string> errors;  // notices of that severity

    void fail(const std::string& text)
    {
        failures.push_back("step " + std::to_string(next) + " " + jsonText(*steps[next]) + ": " +
                           text);
        std::cerr << "script: " << failures.back() << '\n';
    }
    bool run(const Json& step, Session& session, AppRequests& app, Window& window);
    bool wait(const Json& step, const Session& session);
    bool waited(const Json& step, const Session& session) const;
    bool drag(const Json& step, Window& window);
    bool click(const Json& step, Window& window);
    bool key(const Json& step, Window& window);
    bool walkOn(const Json& step, Session& session, AppRequests& app);
    void expect(const Json& step, const Session& session);
    void observe(const Session& session);
};

Script::Script(const fs::path& file) : state_(std::make_shared<State>(readScript(file))) {}

bool Script::finished() const
{
    return state_->next >= state_->steps.size();
}

bool Script::failed() const
{
    return !state_->failures.empty();
}

bool Script::step(Session& session, AppRequests& app, Window& window, double seconds)
{
    State& s = *state_;
    s.now = seconds;
    if (s.firstStep < 0) {
        s.firstStep = seconds;
        s.load = State::Load{};  // the program's own first scene
    }
    s.observe(session);
    bool acted = false;
    while (!finished()) {
        const Json& step = *s.steps[s.next];
        if (s.began < 0) {
            s.began = seconds;
            s.stepFrames = 0;
        }
        bool done = true;
        try {
            done = s.run(step, session, app, window);
        } catch (const core::Error& error) {
            s.fail(error.what());
        }
        ++s.stepFrames;
        const bool waiting = step.contains("wait") && step["wait"] != "frames";
        if (!done) return acted || !waiting;
        acted = acted || !waiting;
        s.log.push_back(
            {{"step", step}, {"at", s.began - s.firstStep}, {"seconds", seconds - s.began}});
        s.began = -1;
        ++s.next;
        // Actions take effect in this frame; whatever looks at their effect comes in the next.
        if (step.contains("do") || step.contains("drop")) return true;
    }
    return acted;
}

/// True when the step is over.
bool Script::State::run(const Json& step, Session& session, AppRequests& app, Window& window)
{
    const glm::dvec2 size(window.framebufferSize());
    const auto pixels = [&](const Json& p) {
        return glm::dvec2(p[0].get<double>(), p[1].get<double>()) * size;
    };
    if (step.contains("do")) {
        Json arguments = step;
        arguments.erase("do");
        if (step["do"] == "load" || step["do"] == "replay") load = {now, session.document()};
        runAction(step["do"], session, app, arguments);
    } else if (step.contains("wait")) {
        return wait(step, session);
    } else if (step.contains("key")) {
        return key(step, window);
    } else if (step.contains("drag")) {
        return drag(step, window);
    } else if (step.contains("click")) {
        return click(step, window);
    } else if (step.contains("cursor")) {
        window.injectCursor(pixels(step["cursor"]));
    } else if (step.contains("wheel")) {
        window.injectWheel(step["wheel"].get<double>());
    } else if (step.contains("drop")) {
        load = {now, session.document()};
        window.injectDrop(step["drop"].get<std::string>());
    } else if (step.contains("random")) {
        return walkOn(step, session, app);
    } else {
        expect(step, session);
    }
    return true;
}

bool Script::State::waited(const Json& step, const Session& session) const
{
    const std::string what = step["wait"];
    const double value = step.value("value", 0.0);
    const std::shared_ptr<const Picture> picture = session.picture();
    const bool current = picture && picture->generation >= session.generation();
    if (what == "seconds") return now - began >= value;
    if (what == "frames") return static_cast<double>(stepFrames) > value;
    if (what == "loaded") return session.settled();
    if (what == "samples")
        return current && !picture->preview && static_cast<double>(picture->samples) >= value;
    if (what == "still") return current && !picture->preview;
    if (what == "finished") return current && picture->finished;
    if (what == "job") return !session.coreThread().active();
    if (what == "reference")
        return session.reference() && static_cast<double>(session.reference()->samples) >= value;
    if (what == "equal-time") return !session.equalTime().running();
    if (what == "comparison") return session.comparison() != nullptr;
    if (what == "flip") return session.flip() != nullptr;
    if (what == "notice") return contains(session.notices.list(), step.value("text", ""));
    throw core::Error("\"" + what + "\" is nothing to wait for");
}

bool Script::State::wait(const Json& step, const Session& session)
{
    if (waited(step, session)) return true;
    if (now - began < step.value("timeout", kDefaultTimeout)) return false;
    throw core::Error("waited in vain");
}

bool Script::State::key(const Json& step, Window& window)
{
    if (stepFrames == 0) window.injectKey(step["key"], true);
    if (stepFrames < 2 || now - began < step.value("seconds", 0.0)) return false;
    window.injectKey(step["key"], false);
    return true;
}

bool Script::State::drag(const Json& step, Window& window)
{
    const glm::dvec2 size(window.framebufferSize());
    const auto pixels = [&](const Json& p) {
        return glm::dvec2(p[0].get<double>(), p[1].get<double>()) * size;
    };
    const glm::dvec2 from = pixels(step["drag"][0]), to = pixels(step["drag"][1]);
    const auto frames = static_cast<uint64_t>(std::max(step.value("frames", 10), 1));
    const int button = step.value("button", 0);
    const double fraction =
        std::clamp((static_cast<double>(stepFrames) - 2) / static_cast<double>(frames), 0.0, 1.0);
    window.injectCursor(glm::mix(from, to, fraction));
    if (stepFrames == 1) window.injectButton(button, true);
    if (stepFrames < frames + 3) return false;
    window.injectButton(button, false);
    return true;
}

bool Script::State::click(const Json& step, Window& window)
{
    const glm::dvec2 size(window.framebufferSize());
    window.injectCursor(glm::dvec2(step["click"][0].get<double>(), step["click"][1].get<double>()) *
                        size);
    // A frame down, a frame up, so that each click is seen.
    const uint64_t times = static_cast<uint64_t>(std::max(step.value("times", 1), 1));
    if (stepFrames == 0) return false;
    const int button = step.value("button", 0);
    window.injectButton(button, stepFrames % 2 == 1);
    return stepFrames >= 2 * times;
}

bool Script::State::walkOn(const Json& step, Session& session, AppRequests& app)
{
    if (stepFrames == 0) {
        std::vector<fs::path> files;
        for (const Json& file : step.value("files", Json::array()))
            files.emplace_back(file.get<std::string>());
        if (files.empty()) throw core::Error("a random walk needs \"files\"");
        walk.emplace(step.value("seed", uint64_t(1)), std::move(files),
                     step.value("folder", std::string("/tmp")));
    }
    walk->step(session, app);
    return static_cast<double>(stepFrames) + 1 >= step["random"].get<double>();
}

void Script::State::expect(const Json& step, const Session& session)
{
    const std::string what = step["expect"];
    const std::shared_ptr<const Picture> picture = session.picture();
    const auto demand = [](bool holds, const std::string& found) {
        if (!holds) throw core::Error("found " + found);
    };
    if (what == "notice") {
        demand(contains(session.notices.list(), step.value("text", "")), "no such message");
    } else if (what == "document") {
        demand(session.document() != nullptr, "no scene");
        demand(session.document()->file.filename() == step.value("name", ""),
               session.document()->file.filename().string());
    } else if (what == "device") {
        demand(picture && picture->stats.device.find(step.value("name", "")) != std::string::npos,
               picture ? picture->stats.device : "no picture");
    } else if (what == "samples") {
        const double least = step.value("value", 1.0);
        demand(picture && static_cast<double>(picture->samples) >= least,
               picture ? std::to_string(picture->samples) : "none");
    } else if (what == "clean") {
        demand(picture && picture->counters.clean(), "samples that are not finite");
    } else if (what == "fresh") {
        demand(picture && picture->generation <= session.generation(), "a picture of the future");
    } else {
        throw core::Error("\"" + what + "\" cannot be expected");
    }
}

/// What the report tells beside the steps.
void Script::State::observe(const Session& session)
{
    const double stop = session.rendering().lastStopSeconds;
    if (stop > 0 && stop != lastStop) stops.push_back(stop);
    lastStop = stop;
    const std::shared_ptr<const Picture> picture = session.picture();
    if (load && session.settled() && session.document() == load->before)
        load.reset();  // it was no scene, or could not be loaded
    if (load && picture && session.settled() && picture->generation >= session.generation() &&
        session.generation() > 0) {
        firstPictures.push_back(now - load->started - session.document()->loadSeconds);
        load.reset();
    }
    if (picture) {
        const core::FilmCounters& c = picture->counters;
        counters = {{"nan", c.nan},
                    {"inf", c.inf},
                    {"negative", c.negative},
                    {"stack_overflow", c.stackOverflow}};
    }
    errors.clear();
    for (const Notice& notice : session.notices.list()) {
        if (notice.severity == Severity::error) errors.push_back(notice.text);
    }
}

void Script::frame(double frameSeconds, bool coreBusy)
{
    (coreBusy ? state_->busy : state_->idle).push_back(frameSeconds);
}

void Script::answered(double seconds, uint64_t frames)
{
    state_->inputSeconds.push_back(seconds);
    state_->inputFrames.push_back(static_cast<double>(frames));
}

Json Script::report() const
{
    const State& s = *state_;
    Json json{{"schema", 1},
              {"command", "view"},
              {"failures", s.failures},
              {"seconds", s.now - s.firstStep},
              {"frame_seconds",
               {{"core_idle", distribution(s.idle)}, {"core_busy", distribution(s.busy)}}},
              {"input_seconds", distribution(s.inputSeconds)},
              {"input_frames", distribution(s.inputFrames)},
              {"stop_seconds", distribution(s.stops)},
              {"first_picture_seconds", distribution(s.firstPictures)},
              {"counters", s.counters},
              {"errors", s.errors},
              {"steps", s.log}};
    return json;
}

}  // namespace app

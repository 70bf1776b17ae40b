// Scripts of the viewer as they are read: one clear line for what is wrong, repetitions without
// copies (B98).
#include "app/view/script.h"

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/base/output_file.h"
#include "tests/support/files/temporary_folder.h"

namespace {

std::string scriptProblem(const std::string& text)
{
    const tests::TemporaryFolder folder;
    core::writeFile(folder / "script.json", text);
    try {
        const app::Script script(folder / "script.json");
    } catch (const core::Error& error) {
        EXPECT_EQ(error.code(), core::ExitCode::badInput);
        return error.what();
    }
    return {};
}

TEST(Script, WrongTypesAreNamedWithTheirPlace)
{
    EXPECT_EQ(scriptProblem(R"({"steps": [{"wait": "samples", "value": 4}, {"key": "F1"}]})"), "");
    for (const auto& [step, place] : std::vector<std::pair<std::string, std::string>>{
             {R"({"wait": 7})", "/steps/0/wait: expected a text"},
             {R"({"wait": "samples", "value": "four"})", "/value: expected a number"},
             {R"({"wait": "samples", "timeout": []})", "/timeout: expected a number"},
             {R"({"key": "F1", "seconds": "long"})", "/seconds: expected a number"},
             {R"({"click": [0, "top"]})", "/click: expected [x, y]"},
             {R"({"click": [0, 0], "times": -1})", "/times: expected a whole number"},
             {R"({"click": [0, 0], "times": 1e300})", "/times: expected a whole number"},
             {R"({"drag": [[0, 0]]})", "/drag: expected [[x, y], [x, y]]"},
             {R"({"drag": [[0, 0], [1, 1]], "button": {}})", "/button: expected a whole number"},
             {R"({"random": 2.5})", "/random: expected a whole number"},
             {R"({"random": 2, "seed": -1})", "/seed: expected a whole number"},
             {R"({"random": 2, "files": [1]})", "/files: expected a list of texts"},
             {R"({"random": 2, "folder": 1})", "/folder: expected a text"},
             {R"({"expect": "notice", "text": 1})", "/text: expected a text"},
             {R"({"expect": "document", "name": null})", "/name: expected a text"},
             {R"({"do": 1})", "/do: expected the name of an action"},
             {R"({"do": "nothing like it"})", "/do: expected the name of an action"},
             {R"({"repeat": 2})", "/steps: expected a list of steps"},
             {R"({"repeat": 2, "steps": {}})", "/steps: expected a list of steps"},
             {R"({"repeat": "2", "steps": []})", "/repeat: expected a whole number"},
             {R"({"repeat": -1, "steps": []})", "/repeat: expected a whole number"},
             {R"({"wiat": "samples"})", "did you mean"},
             {R"([])", "expected a step"},
             {R"({})", "expected a step"}}) {
        const std::string problem = scriptProblem(R"({"steps": [)" + step + "]}");
        EXPECT_NE(problem.find(place), std::string::npos) << step << ": " << problem;
        EXPECT_EQ(problem.find('\n'), std::string::npos);
    }
}

TEST(Script, RepetitionsAreBounded)
{
    EXPECT_EQ(scriptProblem(R"({"steps": [{"repeat": 1000000, "steps": [{"key": "F1"}]}]})"), "");
    EXPECT_EQ(scriptProblem(R"({"steps": [{"repeat": 1000000, "steps": [
                   {"repeat": 1000000, "steps": [{"repeat": 1000000, "steps": []}]}]}]})"),
              "");
    EXPECT_NE(scriptProblem(R"({"steps": [{"repeat": 1000, "steps": [
                  {"repeat": 1001, "steps": [{"key": "F1"}]}]}]})")
                  .find("more than a million steps"),
              std::string::npos);
    const std::string longText(100000, 'x');
    EXPECT_EQ(
        scriptProblem(R"({"steps": [{"repeat": 1000000, "steps": [{"expect": "notice", "text": ")" +
                      longText + R"("}]}]})"),
        "");
}

}  // namespace

// `rekindle lab` as a person or a script meets it: what it refuses, what it writes, how it stops.
#include <csignal>
#include <fstream>
#include <set>
#include <string>

#include <unistd.h>

#include "app/lab/functions.h"
#include "app/lab/pairs.h"
#include "tests/support/process/program.h"

namespace {

using namespace tests;

const std::set<std::string> kFiles{
    "cells.csv",   "densities.csv", "flatland.csv",     "functions.csv", "index.html",
    "lab.json",    "lobes.csv",     "majorisation.csv", "methods.csv",   "picture.csv",
    "samples.csv", "stores.csv",    "sweeps.csv",       "traps.csv"};

std::set<std::string> inFolder(const std::string& folder)
{
    std::set<std::string> names;
    for (const std::string& name : kFiles) names.insert(folder + "/" + name);
    return names;
}

class LabCommand : public Cli {};

TEST_F(LabCommand, NonsenseIsRefused)
{
    expectRefused({"lab"}, 2, "-o DIR");
    expectRefused({"lab", "-o", "x", "--trials", "0"}, 2, "--trials");
    expectRefused({"lab", "-o", "x", "--trials", "2e3"}, 2, "--trials");
    expectRefused({"lab", "-o", "x", "--seed", "many"}, 2, "--seed");
    expectRefused({"lab", "-o", "x", "--trails", "500"}, 2, "did you mean --trials?");
    expectRefused({"lab", "-o", "x", "y"}, 2, "'y'");
    const Result help = run({"lab", "--help"});
    EXPECT_EQ(help.code, 0);
    EXPECT_TRUE(contains(help.out, "Example: rekindle lab -o "));
    EXPECT_TRUE(contains(help.out, "--quick"));
    EXPECT_TRUE(contains(run({"--help"}).out, "lab"));
}

TEST_F(LabCommand, FoldersThatCannotBeAreRefusedBeforeTheWork)
{
    // So many trials that the work would be noticed.
    const Strings lab{"lab", "--trials", "100000000", "-o"};
    writeFile("file", "mine");
    expectRefused(lab + Strings{"file"}, 3, "file: is a file");
    expectRefused(lab + Strings{"file/below/it"}, 3, "file is a file");
    expectRefused(lab + Strings{"/proc/nowhere/below"}, 3, "cannot be made");
    EXPECT_EQ(readAll(work("file")), "mine");
    if (getuid() != 0) {  // root may write everywhere
        fs::create_directory(work("closed"));
        fs::permissions(work("closed"), fs::perms::owner_read | fs::perms::owner_exec);
        expectRefused(lab + Strings{"closed"}, 3, "closed");
        expectRefused(lab + Strings{"closed/below"}, 3, "cannot be made");
        fs::permissions(work("closed"), fs::perms::owner_all);
    }
    // A name that is taken by a folder.
    fs::create_directories(work("taken/lab.json"));
    expectRefused(lab + Strings{"taken"}, 3, "lab.json: is a folder");
    // One folder for two measurements: the later page would replace the other.
    fs::create_directories(work("other"));
    writeFile("other/flythrough.json", "{}");
    expectRefused(lab + Strings{"other"}, 3, "other: holds flythrough.json");
    expectRefused({"bench", "guiding", kScene, "-o", "./other/"}, 3, "holds flythrough.json");
    expectRefused({"bench", "manylights", kScene, "-o", "other"}, 3, "holds flythrough.json");
    fs::rename(work("other/flythrough.json"), work("other/guiding.json"));
    expectRefused({"bench", "flythrough", kScene, "-o", "other"}, 3, "holds guiding.json");
}

/// Rows of a table without its head.
size_t rowsOf(const std::string& csv)
{
    return lineCount(csv) - 1;
}

TEST_F(LabCommand, WritesAPageAndItsNumbers)
{
    const Result result = run({"lab", "-o", "new/lab", "--quick", "--trials", "2000"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_EQ(files(), inFolder("new/lab"));
    ASSERT_EQ(lineCount(result.out), 1u);
    const Json line = Json::parse(result.out);
    EXPECT_EQ(line.at("page"), "new/lab/index.html");
    EXPECT_TRUE(contains(result.err, "new/lab/index.html"));

    const Json lab = Json::parse(readAll(work("new/lab/lab.json")));
    EXPECT_EQ(lab.at("schema"), 1);
    EXPECT_EQ(lab.at("command"), "lab");
    EXPECT_EQ(lab.at("trials"), 2000);
    EXPECT_EQ(lab.at("seed"), 1);
    EXPECT_EQ(lab.at("quick"), true);
    EXPECT_FALSE(lab.at("version").get<std::string>().empty());
    EXPECT_EQ(line.at("cells"), lab.at("cells").size());
    // Every function under every change of density by R-A, Discard and MIS; each with its numbers.
    std::set<std::string> seen;
    for (const Json& cell : lab.at("cells")) {
        const std::string method = cell.at("method");
        if (cell.at("beta") != "none" || cell.at("n") != cell.at("N")) continue;
        if (method == "ra" && cell.at("k") != 4) continue;
        if (method != "ra" && method != "discard" && method != "mis") continue;
        const bool added = seen.insert(cell.at("pair").get<std::string>() + '/' +
                                       cell.at("f").get<std::string>() + '/' + method)
                               .second;
        EXPECT_TRUE(added) << cell.dump();
        EXPECT_TRUE(cell.at("mean").is_number() && cell.at("n_var").is_number() &&
                    cell.at("n_var_se").is_number())
            << cell.dump();
        // R-A traces nothing where no candidate is wanted.
        const double rays = cell.at("rays");
        EXPECT_TRUE(method == "ra" ? rays > 4 && rays <= 8 : rays == 8) << cell.dump();
    }
    EXPECT_EQ(seen.size(), app::lab::kPairs * app::lab::kFunctions * 3);
    for (const char* list :
         {"sweep_c", "sweep_k", "majorisation", "lobes", "stores", "flatland", "traps"})
        EXPECT_FALSE(lab.at(list).empty()) << list;

    const std::string page = readAll(work("new/lab/index.html"));
    EXPECT_TRUE(contains(page, "A quick run"));
    EXPECT_TRUE(contains(page, "<b>" + std::to_string(lab.at("cells").size()) + "</b>"));
    // Of the costly augmentation one trial in 16 is made, and the page says so wherever it says how
    // many there are.
    std::set<uint64_t> trials;
    for (const Json& cell : lab.at("cells")) trials.insert(cell.at("trials").get<uint64_t>());
    EXPECT_EQ(trials, (std::set<uint64_t>{125, 2000}));
    for (const char* words : {"2000 trials per cell", "repeated 2000 times"})
        EXPECT_TRUE(contains(page, std::string(words) + " (125 where augmentation draws more than "
                                                        "7 new samples for each old one)"))
            << words;
    EXPECT_TRUE(contains(run({"lab", "--help"}).out, "one in 16 where"));
    EXPECT_TRUE(page.ends_with("</html>\n"));
    EXPECT_EQ(rowsOf(readAll(work("new/lab/cells.csv"))), lab.at("cells").size());
    EXPECT_EQ(rowsOf(readAll(work("new/lab/sweeps.csv"))),
              lab.at("sweep_c").size() + lab.at("sweep_k").size());
    EXPECT_EQ(rowsOf(readAll(work("new/lab/traps.csv"))), lab.at("traps").size());
}

TEST_F(LabCommand, SameSeedSameNumbers)
{
    fs::create_directory(work("a"));
    writeFile("a/notes.txt", "mine");
    writeFile("a/cells.csv", "of an older run");
    const auto lab = [this](const std::string& folder, const std::string& seed) {
        const Result result =
            run({"lab", "--quiet", "--trials", "200", "-o", folder, "--seed", seed});
        EXPECT_EQ(result.code, 0);
        EXPECT_EQ(result.err, "");
        return readAll(work(folder + "/cells.csv"));
    };
    const std::string first = lab("a", "3");
    EXPECT_EQ(readAll(work("a/notes.txt")), "mine");
    EXPECT_GT(rowsOf(first), 1000u);
    EXPECT_EQ(first, lab("b/", "3"));
    EXPECT_EQ(readAll(work("a/lobes.csv")), readAll(work("b/lobes.csv")));
    EXPECT_EQ(readAll(work("a/traps.csv")), readAll(work("b/traps.csv")));
    EXPECT_NE(first, lab("c", "4"));
}

TEST_F(LabCommand, CtrlCLeavesNothing)
{
    fs::create_directory(work("mine"));
    for (const std::string folder : {"new/lab", "mine"}) {
        const pid_t pid = start({"lab", "--trials", "100000000", "-o", folder});
        waitForError("table: ");  // from here on it would take hours
        kill(pid, SIGINT);
        const Result result = finish(pid, 10);
        EXPECT_EQ(result.code, 130) << result.err;
        EXPECT_TRUE(contains(result.err, "nothing was written"));
        EXPECT_EQ(result.out, "");
    }
    EXPECT_TRUE(files().empty());
    EXPECT_FALSE(fs::exists(work("new")));  // created and removed by the command
    EXPECT_TRUE(fs::exists(work("mine")));
}

}  // namespace

// rekindle: a path-tracing viewer for glTF scenes. Chooses the command, and is the only place where
// failures end.
#include <csignal>
#include <cstdio>
#include <iostream>
#include <new>

#include "app/args/args.h"
#include "app/base/crash_report.h"
#include "app/bench/flythrough/bench_flythrough.h"
#include "app/bench/guiding/bench_guiding.h"
#include "app/bench/light/bench_light.h"
#include "app/bench/many_lights/bench_many_lights.h"
#include "app/bench/throughput/bench_throughput.h"
#include "app/commands/compare.h"
#include "app/commands/devices_command.h"
#include "app/commands/info_command.h"
#include "app/commands/lab_command.h"
#include "app/commands/render_command.h"
#include "app/view/view_command.h"
#include "core/base/check.h"
#include "core/base/text.h"

namespace {

struct Run {
    int operator()(const app::RenderOptions& o) const { return app::renderCommand(o); }
    int operator()(const app::CompareOptions& o) const
    {
        return app::compareCommand(o.image, o.reference, std::cout);
    }
    int operator()(const app::InfoOptions& o) const { return app::infoCommand(o, std::cout); }
    int operator()(const app::DevicesOptions& o) const { return app::devicesCommand(o, std::cout); }
    int operator()(const app::ThroughputOptions& o) const
    {
        return app::benchThroughput(o, std::cout);
    }
    int operator()(const app::FlightBenchOptions& o) const
    {
        return app::benchFlythrough(o, std::cout);
    }
    int operator()(const app::ManyLightsBenchOptions& o) const
    {
        return app::benchManyLights(o, std::cout);
    }
    int operator()(const app::GuidingBenchOptions& o) const
    {
        return app::benchGuiding(o, std::cout);
    }
    int operator()(const app::LightBenchOptions& o) const { return app::benchLight(o, std::cout); }
    int operator()(const app::LabOptions& o) const { return app::labCommand(o, std::cout); }
    int operator()(const app::ViewOptions& o) const { return app::viewCommand(o); }
    int operator()(const app::Printed& o) const
    {
        std::cout << o.text;
        return 0;
    }
};

int fail(const char* message, core::ExitCode code)
{
    std::cout.flush();
    std::fprintf(stderr, "rekindle: error: %s\n", core::printableLines(message).c_str());
    return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv)
{
    // A limit on file sizes then is an error of the write, with a message.
    std::signal(SIGXFSZ, SIG_IGN);
    app::reportCrashes();
    try {
        const int code = std::visit(Run(), app::parseArguments(argc, argv));
        std::cout.flush();
        return std::cout ? code
                         : fail("standard output cannot be written", core::ExitCode::failure);
    } catch (const core::Error& error) {
        return fail(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return fail("out of memory — a smaller picture or scene needs less",
                    core::ExitCode::deviceLost);
    } catch (const std::exception& error) {
        return fail(error.what(), core::ExitCode::failure);
    }
}

// What a renderer has to keep to while it makes the regions of a sky (core::Renderer::prepare).
#pragma once

#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/check.h"
#include "core/methods/renderer.h"

namespace tests {

struct Report {
    std::string stage;
    double fraction = 0;
};

/// Calls prepare(); its report number `last` (from 1 on; 0: none) ends it, as a stop does.
inline std::vector<Report> prepareUntil(core::Renderer& renderer, const core::AnyParams& params,
                                        size_t last)
{
    std::vector<Report> reports;
    const auto report = [&](const char* stage, double fraction) {
        reports.push_back({stage, fraction});
        if (reports.size() == last) throw core::Error("stopped", core::ExitCode::interrupted);
    };
    if (last == 0) {
        renderer.prepare(params, report);
    } else {
        EXPECT_THROW(renderer.prepare(params, report), core::Error);
        EXPECT_EQ(reports.size(), last) << "nothing is told after a stop";
    }
    return reports;
}

/// Making regions of `world`, whose sky is seen through windows, tells how far it is, ends at any
/// report, leaves the picture of before as it is and is done once; the picture is the one that
/// comes without. Returns the names of the stages.
inline std::set<std::string> expectStoppable(core::Renderer& renderer,
                                             const std::shared_ptr<const core::World>& world,
                                             const core::AnyParams& params)
{
    const core::View view{world->cameras.at(0), {16, 16}, params};
    const auto picture = [&] {
        renderer.setView(view, core::Start::anew);
        renderer.advance({.samples = 2}, {});
        return renderer.read(core::Reading::mean).mean.pixels;
    };
    renderer.setWorld(world, {});
    const auto expected = picture();
    EXPECT_TRUE(prepareUntil(renderer, params, 0).empty()) << "setView() has made them";

    renderer.setWorld(world, {});
    const std::vector<Report> all = prepareUntil(renderer, params, 0);
    EXPECT_GT(all.size(), 8u);
    EXPECT_TRUE(prepareUntil(renderer, params, 0).empty()) << "once";
    EXPECT_EQ(picture(), expected);
    std::set<std::string> stages;
    for (size_t i = 0; i < all.size(); ++i) {
        stages.insert(all[i].stage);
        EXPECT_GE(all[i].fraction, 0);
        EXPECT_LE(all[i].fraction, 1);
        if (i > 0 && all[i].stage == all[i - 1].stage) {
            EXPECT_GE(all[i].fraction, all[i - 1].fraction);
        }
    }

    for (const size_t last : {size_t(1), all.size() / 2, all.size()}) {
        renderer.setWorld(world, {});
        prepareUntil(renderer, params, last);
        EXPECT_EQ(picture(), expected) << "after a stop at report " << last;
    }
    return stages;
}

}  // namespace tests

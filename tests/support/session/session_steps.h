// Steps of tests that drive a Session as a window would.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/session/actions.h"
#include "app/session/session.h"
#include "tests/support/files/source_folder.h"

namespace tests {

namespace fs = std::filesystem;
using app::Session;
using ActionJson = nlohmann::ordered_json;

inline constexpr glm::uvec2 kArea(48, 32);

inline app::SessionOptions options(const std::string& scene)
{
    app::SessionOptions o;
    if (!scene.empty()) o.scene.file = kAssets / scene;
    o.render.device = app::DeviceKind::cpu;
    o.quiet = true;
    return o;
}

/// Updates as a window would, until `done` or a minute has gone.
inline testing::AssertionResult until(Session& session, const std::function<bool()>& done)
{
    for (int i = 0; i < 6000; ++i) {
        session.update(0.01, kArea);
        if (done()) return testing::AssertionSuccess();
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return testing::AssertionFailure() << "a minute has gone";
}

inline bool settled(const Session& session)
{
    const auto picture = session.picture();
    return session.document() && !session.loading().active() && picture &&
           picture->generation >= session.generation() && !picture->preview &&
           picture->fullSize == kArea;
}

inline void act(Session& session, const std::string& name,
                const ActionJson& arguments = ActionJson::object())
{
    app::AppRequests requests;
    app::runAction(name, session, requests, arguments);
}

inline bool told(const Session& session, const std::string& text)
{
    for (const app::Notice& notice : session.notices.list())
        if (notice.text.find(text) != std::string::npos) return true;
    return false;
}

}  // namespace tests

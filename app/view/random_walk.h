// Random actions with random arguments, valid and invalid: a step of scripts, with which tests look
// for crashes and deadlocks in the real window.
#pragma once

#include <cstdint>
#include <filesystem>
#include <random>
#include <vector>

#include "app/session/actions.h"

namespace app {

class RandomWalk {
public:
    /// `files` are what it loads, good ones and broken ones; what it writes goes to `folder`.
    RandomWalk(uint64_t seed, std::vector<std::filesystem::path> files,
               std::filesystem::path folder);

    /// One action (never `quit`). Errors of arguments are part of the walk; any other exception is
    /// not.
    void step(Session& session, AppRequests& app);

    const std::string& last() const { return last_; }  // what the last step did

private:
    nlohmann::ordered_json arguments(const std::string& action);
    nlohmann::ordered_json parameter();
    nlohmann::ordered_json methodParameter();
    double real(double low, double high);
    size_t below(size_t count);

    std::mt19937_64 random_;
    std::vector<std::filesystem::path> files_;
    std::filesystem::path folder_;
    std::string last_;
};

}  // namespace app

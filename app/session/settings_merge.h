// Settings of two viewers in one file: what each has changed is kept.
#pragma once

#include <cstddef>

#include <nlohmann/json_fwd.hpp>

namespace app {

/// Scenes in the list of those that were open before.
inline constexpr size_t kMostRecent = 12;

/// `theirs` with what differs between `base` and `mine`, all three as settings.h keeps them: member
/// by member, presets by their names, recent files of both, mine first.
nlohmann::ordered_json mergedSettings(const nlohmann::ordered_json& base,
                                      const nlohmann::ordered_json& mine,
                                      const nlohmann::ordered_json& theirs);

}  // namespace app

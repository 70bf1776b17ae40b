// What of a scene's light the pictures of a method never show, however many samples they have.
#pragma once

#include <string>
#include <string_view>

namespace core {

struct World;

/// One sentence for users; empty where nothing is missing.
std::string missedLight(std::string_view method, const World& world);

}  // namespace core

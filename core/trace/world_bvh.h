// The hierarchy of a world: made once per pose and shared by all who trace it or pick in it.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "core/trace/bvh_cache.h"

namespace core {

/// The hierarchy of `world`. That of the topology's last pose is refitted where there is one: then
/// `still` is the same storage as there. The moving triangles' tree is built anew when motion has
/// made it loose, everything when motion has left the grid. `progress` hears the fraction done of a
/// whole build; what it throws ends the build and is passed on. Throws core::Error (interrupted)
/// when `stop` is requested. What would be built wholly is looked for in `cache` first, and kept
/// there (null: it is not).
std::shared_ptr<const Bvh> bvhOf(const World& world,
                                 const std::function<void(double)>& progress = {},
                                 std::stop_token stop = {}, BvhCache* cache = nullptr);

/// The same if it is there already, else null. Does not wait.
std::shared_ptr<const Bvh> bvhIfMade(const World& world);

}  // namespace core

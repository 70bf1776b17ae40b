// What has moved between two poses of a scene, for methods that keep something from one to the
// next.
#pragma once

#include <optional>
#include <vector>

#include "core/scene/world.h"
#include "shared/motion.h"

namespace core {

/// Whether other poses of a world's scene may differ from it.
bool mayMove(const World& world);

/// Uses of meshes that lie elsewhere or have another shape, and point and spot lights that have
/// moved: at most shared::kMostMovedPieces, of which neighbours are joined where there are more.
/// Boxes are in the world, with a margin for rounding. Nothing where the two have not the same
/// triangles and emitters, or where light from far away has moved, which changes everything.
std::optional<std::vector<shared::MovedPiece>> movedPieces(const World& before, const World& now);

}  // namespace core

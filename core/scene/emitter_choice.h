// How the emitters of a scene are chosen: all by their power, or those that have a place by the
// tree. The tree takes time at every connection, and its bounds say little where lamps are large or
// all around: whether it pays is found out once for each scene.
#pragma once

#include <memory>
#include <span>

namespace core {

struct World;
struct EmitterBounds;

/// Standard deviation of one connection without shadows, weighted against the directions of a
/// diffuse surface, when its emitter is chosen by power over that when it is chosen by the tree:
/// sums over places on surfaces of the scene that do not shine, half of them drawn by area and half
/// by triangles, for what is detailed is looked at. `bounds` of the emitters that
/// `world.emitterTree` has, the first ones of `world.emitters`. The same on every machine and for
/// any number of threads; takes some milliseconds. 1 where no place is lit, or where nothing strays
/// by more than a hundredth.
double treeGain(const World& world, std::span<const EmitterBounds> bounds);

/// From this gain on emitters are chosen by the tree. It makes paths on the CPU a fifth to two
/// thirds slower, and errors of pictures follow the gain (squared) at a distance: light comes by
/// detours, too. Measured gains: 1.0 modern-hall and white-room-dome, 0.64 sponza-dome, where
/// pictures lose by the tree; 1.8 sponza-lanterns, 2.3 sponza, 2.6 hall, where they win.
inline constexpr double kTreePays = 1.5;

/// The same world with every emitter chosen by its power alone, or with those that have a place
/// chosen by the tree, whether it pays or not; `world` itself where that is so already, or where
/// emitters are so few that there is no tree.
std::shared_ptr<const World> chosenByPower(const std::shared_ptr<const World>& world);
std::shared_ptr<const World> chosenByPlace(const std::shared_ptr<const World>& world);

}  // namespace core

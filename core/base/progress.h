// How long work tells how far it is.
#pragma once

#include <functional>

namespace core {

/// In place of the fraction done, where nobody can tell it.
inline constexpr double kUnknownShare = -1;

/// Called for stages that can last over half a second: a name and the fraction done in [0,1], or
/// kUnknownShare; from any thread, but never from two at a time. It may throw to end the work: the
/// exception goes on to the caller.
using Progress = std::function<void(const char* stage, double fraction)>;

}  // namespace core

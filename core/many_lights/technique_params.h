// The techniques of lighting a frame from many lights, by their names.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/params.h"

namespace core::many_lights {

enum class Technique : uint32_t {
    clusters,         // a cut through the light tree for each slice
    lightslice,       // clusters of the columns of a reduced matrix, refined for each slice
    rowColumn,        // the same clusters for the whole picture
    lightcuts,        // a cut through the light tree for each point
    illuminationCut,  // pairs of light clusters and groups of points
    matSep,           // a cut for each slice, visibility predicted, the matrix made of low rank
};

/// Whether a technique chooses columns for slices, whose visibility can be completed; the others
/// trace what they need themselves.
constexpr bool choosesColumns(Technique technique)
{
    return technique <= Technique::rowColumn;
}

}  // namespace core::many_lights

template <> struct core::EnumNames<core::many_lights::Technique> {
    static constexpr std::array<std::string_view, 6> names{
        "clusters", "lightslice", "row-column", "lightcuts", "illumination-cut", "matsep"};
};

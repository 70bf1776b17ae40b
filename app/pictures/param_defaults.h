// Visits the fields of a params struct together with their defaults.
#pragma once

#include <type_traits>
#include <vector>

#include "core/base/params.h"

namespace app {

/// Calls v(field, member, default of the member) for every field of `params` (which may be const).
template <class Params, class V> void visitWithDefaults(Params& params, V&& v)
{
    using Plain = std::remove_const_t<Params>;
    const Plain standard = core::defaultsOf(static_cast<const Plain&>(params));
    std::vector<const void*> members;
    Plain::visit(standard,
                 [&](const core::Field&, const auto& member) { members.push_back(&member); });
    size_t i = 0;
    Plain::visit(params, [&](const core::Field& field, auto& member) {
        using Member = std::remove_cvref_t<decltype(member)>;
        v(field, member, *static_cast<const Member*>(members[i++]));
    });
}

}  // namespace app

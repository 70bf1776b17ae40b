// One visitor draws any params struct: its fields' types and descriptions decide what each looks
// like.
#pragma once

#include <type_traits>

#include "app/pictures/param_defaults.h"
#include "app/view/ui/ui_fields.h"

namespace app {

/// A row for every field that `want(field)` says yes to, in the order of the list. True when
/// anything changed.
template <class Params, class Want>
bool editParams(Params& params, const FieldOptions& options, Want&& want)
{
    bool changed = false;
    visitWithDefaults(params, [&](const core::Field& field, auto& member, const auto& standard) {
        if (!want(field)) return;
        using Member = std::remove_cvref_t<decltype(member)>;
        if constexpr (std::is_enum_v<Member>) {
            auto value = static_cast<uint32_t>(member);
            if (!editChoice(field, value, static_cast<uint32_t>(standard),
                            core::enumNames<Member>(), options))
                return;
            member = static_cast<Member>(value);
            changed = true;
        } else {
            changed |= editField(field, member, standard, options);
        }
    });
    return changed;
}

template <class Params> bool editParams(Params& params, const FieldOptions& options = {})
{
    return editParams(params, options, [](const core::Field&) { return true; });
}

}  // namespace app

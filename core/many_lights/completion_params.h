// How the visibility of a slice is found: by tracing all of it, or some of it and guessing the
// rest.
#pragma once

#include <array>
#include <string_view>

#include "core/base/params.h"

namespace core::many_lights {

enum class CompletionMethod : uint8_t { full };

struct CompletionParams {
    CompletionMethod method = CompletionMethod::full;
    bool dontCare = true;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        v(Field{"completion", "how visibility is found: trace all of it (full)"}, p.method);
        v(Field{"dont-care", "trace no ray between surfaces that face away from each other"},
          p.dontCare);
    }
    friend bool operator==(const CompletionParams&, const CompletionParams&) = default;
};

}  // namespace core::many_lights

template <> struct core::EnumNames<core::many_lights::CompletionMethod> {
    static constexpr std::array<std::string_view, 1> names{"full"};
};

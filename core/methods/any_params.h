// The parameters of any one method: what the command line, the panel, presets, replay and stats
// handle without knowing which method it is.
#pragma once

#include <type_traits>
#include <utility>
#include <variant>

#include "core/base/check.h"
#include "core/methods/ao_params.h"
#include "core/methods/guided_params.h"
#include "core/methods/many_lights_params.h"
#include "core/methods/path_params.h"
#include "core/methods/reuse_params.h"

namespace core {

/// Every method's parameters, in the order of the table (method.h). A params struct names its
/// method (`kMethod`) and describes its members (core/base/params.h).
using MethodParams =
    std::variant<PathParams, AoParams, ReuseParams, ManyLightsParams, GuidedParams>;

template <class P, class Variant> inline constexpr bool kIsAlternative = false;
template <class P, class... Ps>
inline constexpr bool kIsAlternative<P, std::variant<Ps...>> = (std::is_same_v<P, Ps> || ...);

class AnyParams {
public:
    AnyParams() = default;  // the first method's defaults
    template <class P>
    requires kIsAlternative<P, MethodParams> AnyParams(P params)
        : value_(std::in_place_type<P>, std::move(params))
    {}

    std::string_view id() const
    {
        return std::visit([](const auto& p) { return std::decay_t<decltype(p)>::kMethod; }, value_);
    }

    /// The parameters as those of their method, which must be P's (CHECK).
    template <class P> const P& as() const
    {
        CHECK(std::holds_alternative<P>(value_));
        return *std::get_if<P>(&value_);
    }
    template <class P> P& as()
    {
        CHECK(std::holds_alternative<P>(value_));
        return *std::get_if<P>(&value_);
    }

    AnyParams defaults() const
    {
        return std::visit([](const auto& p) { return AnyParams(std::decay_t<decltype(p)>{}); },
                          value_);
    }

    /// As the method's own list.
    template <class Self, class V> static void visit(Self& self, V&& v)
    {
        std::visit([&v](auto& p) { std::remove_cvref_t<decltype(p)>::visit(p, v); }, self.value_);
    }
    friend bool operator==(const AnyParams&, const AnyParams&) = default;

private:
    MethodParams value_;
};

}  // namespace core

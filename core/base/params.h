// Parameters are described once: `visit(self, v)` of a params struct calls v(Field{...}, member)
// per field, and the command line, the panel, --help, JSON, the stats and the restart hash are
// visitors of that one list.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

namespace core {

/// Closed interval of sensible values; `logarithmic` tells a slider how to move.
struct Range {
    double low = 0;
    double high = 0;  // low == high: unbounded
    bool logarithmic = false;
};

/// Name as on the command line (kebab-case), one sentence of help, range. `biased`: any value but
/// the default biases the image; of an enumeration those in `harmless`, a bit each, do not either.
struct Field {
    const char* name;
    const char* help;
    Range range{};
    bool biased = false;
    uint32_t harmless = 0;
};

/// Enumerations specialise this with `static constexpr std::array<std::string_view, N> names`, in
/// order of value.
template <class E> struct EnumNames;

template <class E> constexpr std::span<const std::string_view> enumNames()
{
    return EnumNames<E>::names;
}

template <class E> constexpr std::string_view enumName(E value)
{
    return EnumNames<E>::names[static_cast<size_t>(value)];
}

/// The member of that name, or null when the list has none of that name and type. Renderers do not
/// share parameters; what the program itself has to know of any method it finds by name: "seed" and
/// "max-depth" (uint32_t) mean the same wherever they occur.
template <class T, class Params> auto* findParam(Params& params, std::string_view name)
{
    using Member = std::conditional_t<std::is_const_v<Params>, const T, T>;
    Member* found = nullptr;
    Params::visit(params, [&](const Field& field, auto& member) {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(member)>, T>)
            if (name == field.name) found = &member;
    });
    return found;
}

/// Whether `value` of a field keeps the image from converging to the right one; `standard` is its
/// default.
template <class T> bool biases(const Field& field, T value, T standard)
{
    if (!field.biased || value == standard) return false;
    if constexpr (std::is_enum_v<T>)
        return (field.harmless >> static_cast<uint32_t>(value) & 1u) == 0;
    return true;
}

/// What a params struct holds when nothing has been set: a fresh one, or what it says itself.
template <class Params> Params defaultsOf(const Params& params)
{
    if constexpr (requires { params.defaults(); })
        return params.defaults();
    else
        return Params{};
}

}  // namespace core

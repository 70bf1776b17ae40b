// Parameters are described once: `visit(self, v)` of a params struct calls v(Field{...}, member)
// per field, and the command line, the panel, --help, JSON, the stats and the restart hash are
// visitors of that one list.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace core {

/// Closed interval of sensible values; `logarithmic` tells a slider how to move.
struct Range {
    double low = 0;
    double high = 0;  // low == high: unbounded
    bool logarithmic = false;
};

/// Name as on the command line (kebab-case), one sentence of help, range. `biased`: using it biases
/// the image.
struct Field {
    const char* name;
    const char* help;
    Range range{};
    bool biased = false;
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

}  // namespace core

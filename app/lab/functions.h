// The integrands F1 to F8 of the one-dimensional laboratory, on [0, 1], with their integrals. All
// eight are evaluated together, so that one set of samples serves eight experiments.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace app::lab {

inline constexpr size_t kFunctions = 8;

/// One number per function; what the estimators of core/reuse carry as their value.
struct Values {
    std::array<double, kFunctions> at{};

    double operator[](size_t i) const { return at[i]; }
    double& operator[](size_t i) { return at[i]; }
    Values& operator+=(const Values& other)
    {
        for (size_t i = 0; i < kFunctions; ++i) at[i] += other.at[i];
        return *this;
    }
    friend Values operator*(Values a, double scale)
    {
        for (double& x : a.at) x *= scale;
        return a;
    }
    friend Values operator*(double scale, const Values& a) { return a * scale; }
};

struct TestFunction {
    const char* id;       // "F1"
    const char* name;     // "constant": at most nine letters, for the heads of columns
    const char* formula;  // as text
};

const std::array<TestFunction, kFunctions>& functions();

/// The function of that id; null when there is none.
const TestFunction* findFunction(std::string_view id);

/// The index of the function of that id. CHECKs that there is one.
size_t functionIndex(std::string_view id);

/// f_i(x) for all i; x in [0, 1].
Values evaluateFunctions(double x);

/// Integral of every function over [low, high], in closed form.
Values integrateFunctions(double low, double high);

}  // namespace app::lab

// The kinds of guides as parameters of tests.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

namespace tests {

inline std::string nameOfKind(const testing::TestParamInfo<uint32_t>& kind)
{
    return std::array{"", "histogram", "lobes", "tree"}[kind.param];
}

}  // namespace tests

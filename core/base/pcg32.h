// A small sequential random generator for Monte Carlo on the CPU: O'Neill, "PCG: A Family of Simple
// Fast Space-Efficient Statistically Good Algorithms for Random Number Generation", 2014
// (PCG-XSH-RR). Pictures use the counter-based sampler of shared/sampler.h instead.
#pragma once

#include <bit>
#include <cstdint>

namespace core {

class Pcg32 {
public:
    /// Generators with different `stream` are independent of each other, whatever the seeds.
    explicit Pcg32(uint64_t seed, uint64_t stream = 0) : increment_((stream << 1) | 1)
    {
        bits();
        state_ += seed;
        bits();
    }

    uint32_t bits()
    {
        const uint64_t old = state_;
        state_ = old * 6364136223846793005u + increment_;
        const auto mixed = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
        return std::rotr(mixed, static_cast<int>(old >> 59));
    }

    /// Uniform in [0, 1), a multiple of 2^-32.
    double operator()() { return bits() * 0x1p-32; }

private:
    uint64_t state_ = 0, increment_;
};

}  // namespace core

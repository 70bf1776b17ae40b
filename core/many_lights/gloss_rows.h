// The rows of a slice whose surfaces are glossy (gloss.h), as arrays, and what light brings them.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/many_lights/gloss.h"
#include "core/many_lights/receivers.h"
#include "core/many_lights/row_triple.h"
#include "core/many_lights/virtual_light.h"

namespace core::many_lights {

class GlossRows {
public:
    static constexpr uint32_t kMost = 64;  // rows that get light at a time

    void clear();

    /// Rows come in their order.
    void push(uint32_t row, const glm::mat3& frame, const Gloss& gloss);

    bool empty() const { return rows_.empty(); }
    size_t size() const { return rows_.size(); }

    /// Adds light to those of `rows` that are glossy: the surface's response times `leaving` times
    /// `weights`, which have a place for every row of the slice as has `wi`, unit directions to
    /// where the light comes from.
    void add(IndexRange rows, const RowTriple& wi, const RowTriple& leaving,
             std::span<const float> weights);

    /// Forgets what has been added to some rows.
    void forget(IndexRange rows);

    /// What has been added to a row; 0 where it is none of these.
    glm::vec3 sum(uint32_t row) const;

private:
    static constexpr uint32_t kLanes = 16;
    using Lanes = std::array<float, kLanes>;

    /// What is read together lies together: all numbers have known places behind one.
    struct alignas(64) Packet {
        std::array<Lanes, 9> frame{};              // tangent, bitangent, normal
        std::array<Lanes, kGlossNumbers> gloss{};  // in the order of Gloss
        std::array<Lanes, 3> sum{};

        void add(const std::array<const float*, 7>& light);
    };

    static void addProducts(float* __restrict sum, const float* a, const float* b, const float* c);
    IndexRange within(IndexRange rows) const;

    std::vector<uint32_t> rows_;    // increasing
    std::vector<uint32_t> before_;  // how many stand before each row, up to the last of them
    std::vector<Packet> packets_;
};

/// LightSurface::scattered of a glossy surface (isGloss) towards each of the rows in -wi, times
/// `scale`; 0 where its geometric normal does not face the row. For GlossRows::kMost rows at most.
void scatterTowards(const LightSurface& surface, const glm::vec3& scale, IndexRange rows,
                    const RowTriple& wi, RowTriple& leaving);

/// The same of a Lambertian one, for any number of rows.
void scatterDiffuse(const LightSurface& surface, const glm::vec3& scale, IndexRange rows,
                    const RowTriple& wi, RowTriple& leaving);

}  // namespace core::many_lights

// See gloss_rows.h. The loops are written so that compilers make vectors of them: no branches, no
// calls that are not inlined, and the promise that what is written lies nowhere else.
#include "core/many_lights/gloss_rows.h"

#include <algorithm>
#include <bit>

#include "core/base/check.h"

namespace core::many_lights {

void GlossRows::clear()
{
    rows_.clear();
    before_.clear();
    for (std::vector<float>& v : frame_) v.clear();
    for (std::vector<float>& v : gloss_) v.clear();
    for (std::vector<float>& v : sum_) v.clear();
}

void GlossRows::push(uint32_t row, const glm::mat3& frame, const Gloss& gloss)
{
    before_.resize(row + 1, static_cast<uint32_t>(rows_.size()));
    rows_.push_back(row);
    for (size_t i = 0; i < frame_.size(); ++i)
        frame_[i].push_back(frame[static_cast<int>(i / 3)][static_cast<int>(i % 3)]);
    const auto numbers = std::bit_cast<std::array<float, kGlossNumbers>>(gloss);
    for (size_t i = 0; i < kGlossNumbers; ++i) gloss_[i].push_back(numbers[i]);
    for (std::vector<float>& v : sum_) v.push_back(0);
}

IndexRange GlossRows::within(IndexRange rows) const
{
    const auto at = [this](uint32_t row) {
        return row < before_.size() ? before_[row] : static_cast<uint32_t>(rows_.size());
    };
    return {at(rows.begin), at(rows.end)};
}

void GlossRows::add(IndexRange rows, const RowTriple& wi, const RowTriple& leaving,
                    std::span<const float> weights)
{
    CHECK(rows.size() <= kMost);
    const IndexRange own = within(rows);
    const uint32_t first = own.begin, count = own.size();
    // On the stack, where nothing else can point to.
    std::array<float, kMost> x, y, z;
    std::array<std::array<float, kMost>, 3> light, f;
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t row = rows_[first + k];
        x[k] = wi[0][row];
        y[k] = wi[1][row];
        z[k] = wi[2][row];
        const float w = weights[row];
        for (size_t c = 0; c < 3; ++c) light[c][k] = leaving[c][row] * w;
    }
    std::array<const float*, 9> m;
    for (size_t i = 0; i < m.size(); ++i) m[i] = frame_[i].data() + first;
    std::array<const float*, kGlossNumbers> g;
    for (size_t i = 0; i < kGlossNumbers; ++i) g[i] = gloss_[i].data() + first;
    for (uint32_t k = 0; k < count; ++k) {
        const Gloss gloss{g[0][k],  g[1][k],  g[2][k],  g[3][k],  g[4][k],  g[5][k],
                          g[6][k],  g[7][k],  g[8][k],  g[9][k],  g[10][k], g[11][k],
                          g[12][k], g[13][k], g[14][k], g[15][k], g[16][k], g[17][k],
                          g[18][k], g[19][k], g[20][k], g[21][k]};
        evalGloss(gloss, x[k] * m[0][k] + y[k] * m[1][k] + z[k] * m[2][k],
                  x[k] * m[3][k] + y[k] * m[4][k] + z[k] * m[5][k],
                  x[k] * m[6][k] + y[k] * m[7][k] + z[k] * m[8][k], f[0][k], f[1][k], f[2][k]);
    }
    for (size_t c = 0; c < 3; ++c) {
        float* __restrict sum = sum_[c].data() + first;
        for (uint32_t k = 0; k < count; ++k) sum[k] += f[c][k] * light[c][k];
    }
}

void GlossRows::forget(IndexRange rows)
{
    const IndexRange own = within(rows);
    for (std::vector<float>& v : sum_) std::fill(v.begin() + own.begin, v.begin() + own.end, 0.0f);
}

glm::vec3 GlossRows::sum(uint32_t row) const
{
    const uint32_t k = within({row, row}).begin;
    if (k == rows_.size() || rows_[k] != row) return glm::vec3(0);
    return {sum_[0][k], sum_[1][k], sum_[2][k]};
}

namespace {

/// Of the cosine that the light's intensity holds, what there is for who sees the normal unbent.
float shareOfHeld(const glm::vec3& incident)
{
    return std::max(incident.z, 0.0f) / shared::heldCosine(incident);
}

/// What goes to rows that lie behind the horizon of the surface's shading normal and are faced by
/// its geometric one.
void scatterBetween(const LightSurface& surface, const glm::vec3& scale, IndexRange rows,
                    const RowTriple& wi, RowTriple& leaving)
{
    for (uint32_t i = rows.begin; i < rows.end; ++i) {
        const glm::vec3 out(-wi[0][i], -wi[1][i], -wi[2][i]);
        if (!(glm::dot(out, surface.normal) > 0) || glm::dot(out, surface.frame[2]) > 0) continue;
        const glm::vec3 sent = scale * surface.scattered(out);
        for (int c = 0; c < 3; ++c) leaving[static_cast<size_t>(c)][i] = sent[c];
    }
}

}  // namespace

void scatterDiffuse(const LightSurface& surface, const glm::vec3& scale, IndexRange rows,
                    const RowTriple& wi, RowTriple& leaving)
{
    const glm::vec3 n = surface.frame[2], normal = surface.normal;
    const glm::vec3 sent =
        scale * surface.bsdf.diffuse * (shared::kInvPi * shareOfHeld(surface.incident));
    int between = 0;
    for (uint32_t i = rows.begin; i < rows.end; ++i) {
        const float x = -wi[0][i], y = -wi[1][i], z = -wi[2][i];
        const int facing = int(x * normal.x + y * normal.y + z * normal.z > 0);
        const int above = int(x * n.x + y * n.y + z * n.z > 0);
        const auto shines = static_cast<float>(facing & above);
        for (size_t c = 0; c < 3; ++c) leaving[c][i] = sent[static_cast<int>(c)] * shines;
        between |= facing & (1 - above);
    }
    if (between != 0) scatterBetween(surface, scale, rows, wi, leaving);
}

void scatterTowards(const LightSurface& surface, const glm::vec3& scale, IndexRange rows,
                    const RowTriple& wi, RowTriple& leaving)
{
    CHECK(rows.size() <= GlossRows::kMost);
    const Gloss g = glossOf(surface.bsdf, surface.lobes, surface.incident);
    const glm::vec3 t = surface.frame[0], b = surface.frame[1], n = surface.frame[2],
                    normal = surface.normal;
    const uint32_t count = rows.size();
    const float* x = wi[0].data() + rows.begin;
    const float* y = wi[1].data() + rows.begin;
    const float* z = wi[2].data() + rows.begin;
    std::array<std::array<float, GlossRows::kMost>, 3> f;
    std::array<float, GlossRows::kMost> faces;
    int between = 0;  // faces a row that lies behind the horizon of the shading normal
    for (uint32_t k = 0; k < count; ++k) {
        const float up = -(x[k] * n.x + y[k] * n.y + z[k] * n.z);
        evalGloss(g, -(x[k] * t.x + y[k] * t.y + z[k] * t.z),
                  -(x[k] * b.x + y[k] * b.y + z[k] * b.z), up, f[0][k], f[1][k], f[2][k]);
        const int facing = int(x[k] * normal.x + y[k] * normal.y + z[k] * normal.z < 0);
        faces[k] = static_cast<float>(facing);
        between |= facing & int(up <= 0);
    }
    for (size_t c = 0; c < 3; ++c) {
        const float s = scale[static_cast<int>(c)] * shareOfHeld(surface.incident);
        float* __restrict out = leaving[c].data() + rows.begin;
        for (uint32_t k = 0; k < count; ++k) out[k] = f[c][k] * s * faces[k];
    }
    if (between != 0) scatterBetween(surface, scale, rows, wi, leaving);
}

}  // namespace core::many_lights

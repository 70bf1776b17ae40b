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
    packets_.clear();
}

void GlossRows::push(uint32_t row, const glm::mat3& frame, const Gloss& gloss)
{
    before_.resize(row + 1, static_cast<uint32_t>(rows_.size()));
    const size_t lane = rows_.size() % kLanes;
    if (lane == 0) packets_.push_back({});
    rows_.push_back(row);
    Packet& packet = packets_.back();
    for (size_t i = 0; i < packet.frame.size(); ++i)
        packet.frame[i][lane] = frame[static_cast<int>(i / 3)][static_cast<int>(i % 3)];
    const auto numbers = std::bit_cast<std::array<float, kGlossNumbers>>(gloss);
    for (size_t i = 0; i < kGlossNumbers; ++i) packet.gloss[i][lane] = numbers[i];
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
    const IndexRange own = within(rows);
    const std::array<const float*, 7> from{wi[0].data(),      wi[1].data(),      wi[2].data(),
                                           leaving[0].data(), leaving[1].data(), leaving[2].data(),
                                           weights.data()};
    std::array<Lanes, 7> some;  // of lanes that are not those of rows side by side
    std::array<const float*, 7> light;
    for (uint32_t first = own.begin - own.begin % kLanes; first < own.end; first += kLanes) {
        const uint32_t begin = std::max(first, own.begin), end = std::min(first + kLanes, own.end);
        const uint32_t row = rows_[begin];
        const bool sideBySide =
            end - begin == kLanes && rows_[end - 1] - row == kLanes - 1;  // as most are
        for (size_t i = 0; i < from.size(); ++i) {
            light[i] = from[i] + row;
            if (sideBySide) continue;
            some[i].fill(0);
            for (uint32_t k = begin; k < end; ++k) some[i][k - first] = from[i][rows_[k]];
            light[i] = some[i].data();
        }
        packets_[first / kLanes].add(light);
    }
}

/// A loop of its own: a promise made within another loop is not kept.
void GlossRows::addProducts(float* __restrict sum, const float* a, const float* b, const float* c)
{
    for (uint32_t k = 0; k < kLanes; ++k) sum[k] += a[k] * (b[k] * c[k]);
}

/// Directions, what comes along them, and weights, kLanes of each.
void GlossRows::Packet::add(const std::array<const float*, 7>& light)
{
    const float *x = light[0], *y = light[1], *z = light[2], *w = light[6];
    std::array<Lanes, 3> f;  // on the stack, where nothing else can point to
    const auto& m = frame;
    const auto& g = gloss;
    for (uint32_t k = 0; k < kLanes; ++k) {
        const Gloss surface{g[0][k],  g[1][k],  g[2][k],  g[3][k],  g[4][k],  g[5][k],
                            g[6][k],  g[7][k],  g[8][k],  g[9][k],  g[10][k], g[11][k],
                            g[12][k], g[13][k], g[14][k], g[15][k], g[16][k], g[17][k],
                            g[18][k], g[19][k], g[20][k], g[21][k]};
        evalGloss(surface, x[k] * m[0][k] + y[k] * m[1][k] + z[k] * m[2][k],
                  x[k] * m[3][k] + y[k] * m[4][k] + z[k] * m[5][k],
                  x[k] * m[6][k] + y[k] * m[7][k] + z[k] * m[8][k], f[0][k], f[1][k], f[2][k]);
    }
    for (size_t c = 0; c < 3; ++c) addProducts(sum[c].data(), f[c].data(), light[3 + c], w);
}

void GlossRows::forget(IndexRange rows)
{
    const IndexRange own = within(rows);
    for (uint32_t k = own.begin; k < own.end; ++k)
        for (Lanes& sum : packets_[k / kLanes].sum) sum[k % kLanes] = 0;
}

glm::vec3 GlossRows::sum(uint32_t row) const
{
    const uint32_t k = within({row, row}).begin;
    if (k == rows_.size() || rows_[k] != row) return glm::vec3(0);
    const auto& sum = packets_[k / kLanes].sum;
    return {sum[0][k % kLanes], sum[1][k % kLanes], sum[2][k % kLanes]};
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

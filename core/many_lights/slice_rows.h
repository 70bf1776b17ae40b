// The receivers of one slice as rows of arrays, and what lights contribute to them.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/many_lights/gloss_rows.h"
#include "core/many_lights/light_cut.h"
#include "core/many_lights/receivers.h"
#include "core/many_lights/row_bounds.h"
#include "shared/scene.h"

namespace core::many_lights {

/// What decides how lights contribute, the same for all slices.
struct GatherSettings {
    uint32_t maxDepth = 8;
    float clampDistance = 0;  // lights on surfaces do not count as nearer than this
};

/// A light and by how much it counts: what a column of a slice is.
struct Column {
    const VirtualLight* light = nullptr;
    float scale = 1;
    uint32_t seed = 0;  // of the alpha of what its rays meet
    float radius = 0;   // of its extent
};

/// Asks for a column's light before it is read: the lights of a slice lie anywhere in memory, and
/// waiting for one took up to a third of the time (beside other work) that weighing its rows takes.
inline void fetchLight(const Column& column)
{
    __builtin_prefetch(column.light);
    __builtin_prefetch(&column.light->bothSides);
}

/// The same of what the light's detail says. The light itself has been fetched.
inline void fetchDetail(const Column& column, const LightSet& lights)
{
    const VirtualLight& light = *column.light;
    if (light.detail == shared::kNone || light.kind != LightKind::surface) return;
    constexpr size_t kLine = 64;
    const char* surface = reinterpret_cast<const char*>(&lights.surfaces[light.detail]);
    for (size_t at = 0; at < sizeof(LightSurface); at += kLine) __builtin_prefetch(surface + at);
}

/// Light number `index` of a frame.
inline Column columnOf(const VirtualLight& light, float scale, uint32_t index, uint32_t frame)
{
    return {&light, scale, shared::hashUint(index ^ shared::hashUint(frame))};
}

/// Memory is kept from slice to slice.
class SliceRows {
public:
    /// Looks up positions, frames and materials of the receivers that `chosen` lists.
    void reset(const shared::SceneView& scene, std::span<const Receiver> receivers,
               std::span<const uint32_t> chosen);

    uint32_t count() const { return count_; }

    /// Where the rows are, on average.
    glm::vec3 middle() const { return mean_ / static_cast<float>(std::max(count_, 1u)); }

    /// The mean receiver, for the cut, with the spread of places and normals around it: those that
    /// a row has as a rule, not the largest, so that one row does not decide for all.
    CutQuery query(const GatherSettings& settings) const;

    /// One receiver, for a cut of its own.
    CutQuery queryAt(uint32_t row, const GatherSettings& settings) const;

    /// The unit normal of queryAt; zero where light may come from anywhere.
    glm::vec3 shadingNormal(uint32_t row) const
    {
        if (transmits_[row] != 0) return glm::vec3(0);
        return {normal_[0][row], normal_[1][row], normal_[2][row]};
    }
    bool isLambert(uint32_t row) const;

    /// The largest value of a row's BSDF, of any colour, for light from a node: exact for Lambert's
    /// surfaces. Of others an estimate: the larger of what it is in the middle of the node and
    /// nearest to the mirror image of the viewer.
    float largestResponse(uint32_t row, const LightNode& node, LightKind kind) const;

    /// Per row the cosines and distances of a contribution, visibility left out; 0 where none is
    /// possible. What a Lambertian light and a Lambertian surface exchange is this times intensity
    /// times albedo / pi. Of lights with extent an estimate, for their order.
    void weigh(const Column& column, const GatherSettings& settings, std::span<float> weights) const
    {
        weigh(column, settings, {0, count_}, weights);
    }
    /// The same for some rows alone; `weights` has a place for every row.
    void weigh(const Column& column, const GatherSettings& settings, IndexRange rows,
               std::span<float> weights) const;

    /// Bits of the rows to which light may come from a column if nothing is in between: those that
    /// weigh() gives more than 0, unless that is too little for a float. `scratch` has a place for
    /// every row.
    void findReached(const Column& column, const GatherSettings& settings, std::span<float> scratch,
                     std::span<uint64_t> reached);

    /// Adds a column's light to the rows whose weight is not 0.
    void add(const Column& column, const LightSet& lights, std::span<const float> weights)
    {
        add(column, lights, {0, count_}, weights);
    }
    void add(const Column& column, const LightSet& lights, IndexRange rows,
             std::span<const float> weights);

    /// Forgets what has been added to some rows.
    void clear(IndexRange rows);

    /// Luminance that the column would add to all rows if nothing were in between and they were of
    /// one albedo.
    static float brightness(const Column& column, std::span<const float> weights);

    /// Radiance of a row towards where it is seen from, of the columns added so far.
    glm::vec3 radiance(uint32_t row) const
    {
        const auto of = [row](const RowTriple& t) {
            return glm::vec3(t[0][row], t[1][row], t[2][row]);
        };
        return of(albedo_) * of(irradiance_) + of(sum_) + gloss_.sum(row);
    }

    // What shadow rays begin at. Rows through which light passes have two origins: that of row i
    // for light from behind stands at count() + i.
    std::span<const float> originX() const { return origin_[0]; }
    std::span<const float> originY() const { return origin_[1]; }
    std::span<const float> originZ() const { return origin_[2]; }
    bool anyTransmits() const { return anyTransmits_; }
    /// Whether light from `towards` (not unit) arrives at the back of the row.
    bool fromBehind(uint32_t row, const glm::vec3& towards) const
    {
        return transmits_[row] != 0 &&
               towards.x * side_[0][row] + towards.y * side_[1][row] + towards.z * side_[2][row] <
                   0;
    }
    std::span<const uint32_t> seeds() const { return seeds_; }

private:
    /// A row whose surface is not Lambert's.
    struct Surface {
        uint32_t row;
        glm::mat3 frame;
        glm::vec3 wo;
        shared::Bsdf bsdf;
        shared::LobeChoice lobes;
        bool isGloss;  // its light is summed with that of all such rows
    };

    bool isSimple(const Column& column, const GatherSettings& settings) const;
    void setRow(uint32_t row, const shared::SceneView& scene, const Receiver& receiver);
    void addLambert(const Column& column, IndexRange rows, std::span<const float> weights);
    void addBlock(const Column& column, const LightSet& lights, IndexRange rows,
                  std::span<const float> weights);
    void findLight(const Column& column, const LightSet& lights, IndexRange rows,
                   std::span<const float> weights);
    void findDirections(const VirtualLight& light, IndexRange rows);
    void setMedia(uint32_t row, const shared::SceneView& scene, uint32_t front, uint32_t behind);
    void dimLight(IndexRange rows, std::span<const float> weights);

    uint32_t count_ = 0;
    RowTriple position_, normal_, side_;  // side: the geometric normal towards the viewer
    RowTriple albedo_;                    // over pi, of Lambertian rows; 0 of others
    RowTriple irradiance_;                // that has been added, of all rows
    RowTriple sum_;                       // of surfaces neither Lambert's nor in gloss_
    RowTriple origin_;
    // Of the column that is being added, where it needs them: unit directions to the light, and
    // what it sends along them.
    RowTriple wi_, leaving_;
    RowTriple absorption_;      // on the side of row i that is seen and, at count() + i, behind it
    std::vector<float> scale_;  // one over the distances
    GlossRows gloss_;
    RowBounds bounds_;
    std::vector<int> events_, transmits_;  // the latter 0 or 1
    std::vector<uint32_t> seeds_;
    std::vector<Surface> surfaces_;
    size_t otherSurfaces_ = 0;  // those of them that are not in gloss_
    glm::vec3 mean_{0}, meanNormal_{0};
    // What no row has, no column asks for.
    bool anyTransmits_ = false, anySideDiffers_ = false;  // the latter: shading normals
    bool anyAbsorbs_ = false;                             // a medium at a row
    int mostEvents_ = 0;
};

/// Direction to the light from a row (not unit) and, for lights at a place, distance squared.
inline glm::vec3 towards(const VirtualLight& light, const glm::vec3& from)
{
    return light.kind == LightKind::directional ? -light.normal : light.position - from;
}

}  // namespace core::many_lights

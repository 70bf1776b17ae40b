// Guided paths in the loop of all path tracers. What happens at the vertices that follow the guide
// or leave records is compiled apart (guided_vertex_body.h): with both in one source file compilers
// inline less of what happens at the others. Included once by each guided_*.cpp, after
// REKINDLE_FEATURES is defined.
#include <algorithm>

#include "core/base/per_thread.h"
#include "core/methods/guided_kernel.h"
#include "core/methods/path_kernel_body.h"

namespace core {

namespace {

/// Records of the paths of one wave, while they are made.
struct WaveRecords {
    std::array<shared::GuidedState, kWave> states;
    std::array<uint8_t, kWave> isRecorded, count;
    std::array<std::array<shared::GuideRecord, shared::kGuideVertices>, kWave> records;
    std::array<uint32_t, kWave> made;  // the paths that have a new record at this depth
    size_t pathCount, madeCount;
};

/// Index of a pixel in its tile of 8x8 along the Morton curve, as the device counts lanes.
uint32_t laneOf(glm::uvec2 pixel)
{
    const uint32_t x = pixel.x & 7u, y = pixel.y & 7u;
    return shared::guideCell({x, y});
}

template <GuidedShade shadeVertex> class GuidedVertices {
public:
    static constexpr bool kAllPlain = false;

    GuidedVertices(const GuidedJob& job, WaveRecords& wave, guiding::PathRecords& out)
        : job_(job), wave_(wave), out_(out)
    {}

    void begin(glm::uvec2 pixel, uint32_t sample, size_t i)
    {
        wave_.states[i] = shared::beginGuided(
            job_.image.empty()
                ? 0.0f
                : job_.image[size_t(pixel.y) * job_.path.settings.imageWidth + pixel.x]);
        wave_.isRecorded[i] =
            shared::isRecorded(laneOf(pixel), sample, shared::recordStride(job_.path.settings));
        wave_.count[i] = 0;
        wave_.pathCount = i + 1;
        wave_.madeCount = 0;
    }

    /// The same to the bit for less, where nobody asks what the guide says.
    bool isPlain(size_t i) const
    {
        return wave_.isRecorded[i] == 0 && !shared::followsGuide(job_.path.settings, false);
    }

    bool shade(const shared::VertexNumbers& numbers, const shared::Hit& hit, size_t i,
               shared::PathState& path, shared::ShadowRay& shadow, glm::vec3& L)
    {
        // The place of the record that would be made; of the last one where none is wanted.
        const size_t slot = std::min<size_t>(wave_.count[i], shared::kGuideVertices - 1);
        const bool isRecorded = wave_.isRecorded[i] != 0;
        const bool follows = shared::followsGuide(job_.path.settings, isRecorded);
        uint32_t recorded = isRecorded && wave_.count[i] < shared::kGuideVertices;
        const bool goes = shadeVertex(job_, {follows, numbers, hit, path, wave_.states[i], shadow,
                                             wave_.records[i][slot], recorded, L});
        if (recorded != 0) {
            ++wave_.count[i];
            wave_.made[wave_.madeCount++] = static_cast<uint32_t>(i);
        }
        return goes;
    }

    void connected(std::span<const glm::vec3> radiance)
    {
        for (size_t k = 0; k < wave_.madeCount; ++k) {
            const uint32_t i = wave_.made[k];
            wave_.records[i][wave_.count[i] - 1u].after = shared::luminance(radiance[i]);
        }
        wave_.madeCount = 0;
    }

    void end(std::span<const glm::vec3> radiance)
    {
        for (size_t i = 0; i < wave_.pathCount; ++i) {
            if (wave_.count[i] == 0) continue;
            out_.ends.push_back(
                {wave_.count[i], shared::luminance(radiance[i]), wave_.states[i].image});
            const auto first = wave_.records[i].begin();
            out_.records.insert(out_.records.end(), first, first + wave_.count[i]);
        }
    }

private:
    const GuidedJob& job_;
    WaveRecords& wave_;
    guiding::PathRecords& out_;
};

template <GuidedShade shadeVertex>
TileTally renderGuidedTile(const GuidedJob& job, const Tile& tile, Film& film,
                           guiding::PathRecords& records)
{
    return renderTile(job.path, tile, film,
                      GuidedVertices<shadeVertex>(job, perThread<WaveRecords>(), records));
}

}  // namespace

}  // namespace core

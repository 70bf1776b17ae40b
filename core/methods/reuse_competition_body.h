// How a pixel of sample reuse cuts its store down, by threshold resampling (shared/reuse.h), and
// what that takes away. Included once by each variant.
#include <array>
#include <span>

#include "shared/reuse_new.h"

namespace core {

namespace {

/// Samples that compete for the places of a store.
template <class Record> struct Competition {
    std::array<Record, shared::kReuseMostScores> records;
    std::array<float, shared::kReuseMostScores> weights;     // v
    std::array<glm::vec3, shared::kReuseMostScores> brings;  // u F
    uint32_t count = 0;

    void add(const Record& record, float v, glm::vec3 itBrings)
    {
        records[count] = record;
        weights[count] = v;
        brings[count++] = itBrings;
    }

    /// Keeps `out.size()` of them by threshold resampling; `weight` is the member that is paid,
    /// `mean` what all together have brought. Returns what they brought less what the kept ones
    /// bring.
    glm::vec3 keep(std::span<Record> out, float Record::*weight,
                   const shared::ReuseSettings& settings, glm::vec3 mean, float xi) const
    {
        std::array<float, shared::kReuseMostScores> scores;
        glm::vec3 remainder(0);
        for (uint32_t i = 0; i < count; ++i) {
            scores[i] =
                shared::reuseScore(settings, weights[i], shared::luminance(brings[i]), mean);
            remainder += brings[i];
        }
        const auto most = static_cast<uint32_t>(out.size());
        const float kappa = shared::reuseThreshold(scores.data(), count, most);
        float sum = 0;
        uint32_t kept = 0;
        for (uint32_t i = 0; i < count && kept < most; ++i) {
            if (!shared::usableDensity(scores[i])) continue;
            if (kappa > 0 && !shared::reuseKeep(sum, scores[i], kappa, xi)) continue;
            const float scale = kappa > 0 ? shared::reuseKeepScale(scores[i], kappa) : 1.0f;
            out[kept] = records[i];
            out[kept++].*weight *= scale;
            remainder -= scale * brings[i];
        }
        for (; kept < most; ++kept) out[kept].*weight = 0;
        return remainder;
    }
};

}  // namespace

}  // namespace core

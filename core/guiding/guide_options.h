// How a guide learns: switches between what proved best here and what the papers have.
#pragma once

#include <cstdint>
#include <limits>

#include <glm/glm.hpp>

#include "shared/guide_tables.h"

namespace core::guiding {

/// What has leaves of its own: `normals`: six trees by the normal, cut at the mean of their
/// records; `plain`: one tree, cut in the middle along each axis in turn (T. Mueller, M. Gross, J.
/// Novak, "Practical Path Guiding for Efficient Light-Transport Simulation", 2017).
enum class GuideSpace : uint32_t { normals, plain };

/// The density that directions are to have: f |cos| L, L (2017), or the root of the second moment
/// of estimates of the first (A. Rath et al., "Variance-Aware Path Guiding", 2020), which lobes do
/// not have: they take the product.
enum class GuideTarget : uint32_t { product, radiance, secondMoment };

/// What directions are learnt from beside the records since the last time: all sums so far, nothing
/// (2017), or the records of the iteration before (record_store.h), directions being drawn from the
/// new density or from what the old records lack (residual; of trees alone, others balance).
enum class GuideMemory : uint32_t { keep, reset, balance, residual };

/// Whether a record teaches its own leaf, or is moved at random by up to half of its leaf's size in
/// space, and of its quarter's among the directions of a tree (T. Mueller, "Path Guiding in
/// Production", 2019: the stochastic and the box filter).
enum class GuideFilter : uint32_t { nearest, spread };

/// How the share of the BSDF is found where it is not fixed: the one of six with the least second
/// moment, or by stochastic descent (learnt_share.h).
enum class ShareBy : uint32_t { argmin, adam };

/// The least share of the BSDF that a kind of guide may be left with: lobes know less of what they
/// have not seen.
constexpr float leastShareOf(uint32_t kind)
{
    return kind == shared::kGuideLobes ? 0.25f : 0.12f;
}

/// A cube around a scene: where the first leaf is.
struct GuideBox {
    glm::vec3 low{0};
    float side = 1;
};

struct GuideOptions {
    /// shared::kGuideHistogram, kGuideLobes or kGuideTree.
    uint32_t kind = shared::kGuideHistogram;
    /// A leaf is cut when it has had more than this many times sqrt(2 samples per pixel) records:
    /// in all with GuideMemory::keep, else in the iteration that ends. 0: whenever it has any.
    float recordsPerLeaf = 500;
    /// The second moment without the guide over that with it, above which a leaf is guided.
    float gate = 1.1f;
    /// The least share of the BSDF that a leaf may choose (ShareBy::argmin).
    float leastShare = leastShareOf(shared::kGuideHistogram);
    /// Share of the BSDF in every leaf that has learnt something; 0: chosen for each. What is fixed
    /// or learnt is a thousandth at least.
    float fixedShare = 0;
    ShareBy shareBy = ShareBy::argmin;
    GuideSpace space = GuideSpace::normals;
    GuideTarget target = GuideTarget::product;
    GuideMemory memory = GuideMemory::keep;
    GuideFilter filter = GuideFilter::nearest;
    /// Cuts between a root and a leaf, at most.
    uint32_t depth = std::numeric_limits<uint32_t>::max();
    /// Needed by plain space and by the filter.
    GuideBox box{};
};

}  // namespace core::guiding

// Records of an iteration that teach the next guide, too: both sets together as samples of one
// density, by the balance heuristic over the mixtures that they were drawn from. S. Wang,
// "Efficient Sample Usage in Photo-Realistic Rendering" (2022), chapter 9, reuses training samples
// with Reweighting-Augmentation, whose weights at its best scale are these where the densities are
// those of the guides alone. What differs: the mixtures with the BSDF, so that both sets may have
// been drawn from anything.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/guiding/lesson.h"

namespace core::guiding {

class RecordStore {
public:
    /// In what follows these are the old ones.
    void keep(std::vector<Lesson> lessons) { lessons_ = std::move(lessons); }

    /// Leaves those on one side of a plane.
    void clip(float plane, uint32_t axis, bool above);

    /// The old lessons. Each `otherPdf` is to be set to the density of the new mixture before they
    /// are added.
    std::span<Lesson> lessons() { return lessons_; }

    /// What `added`, whose `otherPdf` is the density of the old mixture, and the old ones teach
    /// together: every value times its own density becomes value over that of the union, in units
    /// of one lesson. Order is old, added.
    std::vector<Lesson> together(std::span<const Lesson> added) const;

private:
    std::vector<Lesson> lessons_;
};

}  // namespace core::guiding

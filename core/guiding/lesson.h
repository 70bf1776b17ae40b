// What a guide learns from one vertex of a path.
#pragma once

#include <glm/glm.hpp>

#include "core/guiding/guide.h"

namespace core::guiding {

/// A record as leaves take it.
struct Lesson {
    glm::vec3 position{0};
    float value = 0;  // f |cos| L over `pdf`, a scalar: 0 for paths that brought nothing
    float reflected = 0;
    float arriving = 0;          // L over `pdf`
    glm::vec3 direction{0};      // unit, world
    float pdf = 0, bsdfPdf = 0;  // of the mixture (0: no direction to learn) and the BSDF
    float guidePdf = 0;          // of the tables that chose the direction
    float sharp = 0;             // share of sharp lobes
    float otherPdf = 0;          // of the mixture of another iteration's guide
    uint32_t tree = 0, leaf = 0;
};

/// The density of the mixture that another guide would have drawn the lesson's direction from, in
/// one of its leaves.
float mixturePdf(const Lesson& lesson, const GuideTables& tables, uint32_t leaf);

/// What a record of a path teaches; `final` is all that the path brought home, `tables` are those
/// that it was sampled with.
Lesson lessonOf(const shared::GuideRecord& record, float final, const GuideTables& tables);

}  // namespace core::guiding

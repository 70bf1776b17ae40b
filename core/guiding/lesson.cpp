#include "core/guiding/lesson.h"

namespace core::guiding {

static float finiteOrZero(float x)
{
    return x > 0 && x < 1e30f ? x : 0;
}

Lesson lessonOf(const shared::GuideRecord& record, float final, const GuideTables& tables)
{
    const shared::GuideView guide = tables.view();
    Lesson lesson;
    lesson.position = record.position;
    lesson.tree = shared::treeOfPlace(record.place);
    lesson.leaf = shared::findGuideLeaf(guide, record.position, lesson.tree);
    lesson.sharp = shared::sharpOfPlace(record.place);
    if (record.beta > 0) {
        lesson.value = finiteOrZero((final - record.after) / record.beta);
        lesson.reflected = finiteOrZero((final - record.before) / record.beta);
    }
    if (!(record.pdf > 0)) return lesson;
    if (record.scattered > 0)
        lesson.arriving = finiteOrZero((final - record.after) / (record.scattered * record.pdf));
    lesson.pdf = record.pdf;
    lesson.bsdfPdf = record.bsdfPdf;
    const glm::vec3 wi = shared::unpackOct(record.direction);
    lesson.direction = wi;
    lesson.guidePdf =
        shared::pdfGuide(guide, shared::GuideLeaf{0, tables.leaves[lesson.leaf].x, 1, 0}, wi);
    return lesson;
}

float mixturePdf(const Lesson& lesson, const GuideTables& tables, uint32_t leaf)
{
    const glm::uvec4 word = tables.leaves[leaf];
    const float guide = (1 - shared::uintAsFloat(word.y)) * (1 - lesson.sharp);
    if (!(guide > 0)) return lesson.bsdfPdf;
    return (1 - guide) * lesson.bsdfPdf +
           guide * shared::pdfGuide(tables.view(), shared::GuideLeaf{0, word.x, 1, 0},
                                    lesson.direction);
}

}  // namespace core::guiding

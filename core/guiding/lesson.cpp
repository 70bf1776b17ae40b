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
    lesson.leaf = shared::findGuideLeaf(guide, record.position, record.place & 7u);
    lesson.sharp = float(record.place >> 3u) / 255.0f;
    if (record.beta > 0) {
        lesson.value = finiteOrZero((final - record.after) / record.beta);
        lesson.reflected = finiteOrZero((final - record.before) / record.beta);
    }
    if (!(record.pdf > 0)) return lesson;
    lesson.pdf = record.pdf;
    lesson.bsdfPdf = record.bsdfPdf;
    const glm::vec3 wi = shared::unpackOct(record.direction);
    lesson.direction = wi;
    lesson.guidePdf =
        shared::pdfGuide(guide, shared::GuideLeaf{0, tables.leaves[lesson.leaf].x, 1, 0}, wi);
    return lesson;
}

}  // namespace core::guiding

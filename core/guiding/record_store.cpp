#include "core/guiding/record_store.h"

#include <algorithm>

namespace core::guiding {

void RecordStore::clip(float plane, uint32_t axis, bool above)
{
    std::erase_if(lessons_, [&](const Lesson& lesson) {
        return (lesson.position[int(axis)] < plane) == above;
    });
}

std::vector<Lesson> RecordStore::together(std::span<const Lesson> added) const
{
    std::vector<Lesson> all;
    all.reserve(lessons_.size() + added.size());
    const auto nOld = float(lessons_.size()), nNew = float(added.size());
    const auto add = [&](const Lesson& lesson, float own, float others) {
        Lesson next = lesson;
        const float pdf = own * lesson.pdf + others * lesson.otherPdf;
        const float scale = pdf > 0 ? lesson.pdf / pdf * (own + others) : 0;
        next.value *= scale;
        all.push_back(next);
    };
    for (const Lesson& lesson : lessons_) add(lesson, nOld, nNew);
    for (const Lesson& lesson : added) add(lesson, nNew, nOld);
    return all;
}

}  // namespace core::guiding

#include "core/guiding/guide_leaf.h"

#include <cmath>

namespace core::guiding {

namespace {

/// A leaf whose guide has been tested by fewer records is not guided.
constexpr double kLeastTested = 64;

}  // namespace

LearningLeaf::LearningLeaf(uint32_t kind)
{
    if (kind == shared::kGuideLobes) directions.emplace<DirectionLobes>();
}

void LearningLeaf::halve()
{
    visits *= 0.5;
    reflected *= 0.5;
    for (double& m : moments) m *= 0.5;
    tested *= 0.5;
    std::visit([](auto& d) { d.halve(); }, directions);
}

void LearningLeaf::learn(std::span<const Lesson> lessons, double decay, const GuideOptions& options)
{
    for (double& m : moments) m *= decay;
    tested *= decay;
    const bool hasGuide = knowsLight();
    for (const Lesson& lesson : lessons) {
        visits += 1;
        reflected += double(lesson.reflected);
        if (hasGuide) test(lesson);
    }
    if (auto* lobes = std::get_if<DirectionLobes>(&directions)) lobes->fade(std::sqrt(decay));
    std::visit([lessons](auto& d) { d.learn(lessons); }, directions);
    choose(options);
}

void LearningLeaf::test(const Lesson& lesson)
{
    tested += 1;
    if (!(lesson.pdf > 0 && lesson.value > 0)) return;
    const double bsdf = double(lesson.bsdfPdf), smooth = 1.0 - double(lesson.sharp);
    const double squares = double(lesson.value) * double(lesson.value) * double(lesson.pdf);
    for (size_t k = 0; k < kGuideShares.size(); ++k) {
        const double guide = (1.0 - kGuideShares[k]) * smooth;
        const double pdf = (1.0 - guide) * bsdf + guide * double(lesson.guidePdf);
        if (pdf > 0) moments[k] += squares / pdf;
    }
}

/// The share with the least second moment, if that is enough of a gain.
void LearningLeaf::choose(const GuideOptions& options)
{
    share = 1;
    if (!knowsLight()) return;
    if (options.fixedShare > 0) {
        share = options.fixedShare;
        return;
    }
    if (tested < kLeastTested) return;
    size_t best = 0;
    for (size_t k = 1; k < kGuideShares.size(); ++k) {
        // Shares are given with two digits; a limit of .12 allows .12
        if (kGuideShares[k] > double(options.leastShare) - 1e-3 && moments[k] < moments[best])
            best = k;
    }
    if (moments[0] > double(options.gate) * moments[best]) share = float(kGuideShares[best]);
}

void LearningLeaf::writeWords(std::span<glm::vec4> words) const
{
    std::visit([words](const auto& d) { d.write(words); }, directions);
}

bool LearningLeaf::knowsLight() const
{
    return std::visit([](const auto& d) { return d.knowsLight(); }, directions);
}

}  // namespace core::guiding

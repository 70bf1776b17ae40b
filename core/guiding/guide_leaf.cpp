#include "core/guiding/guide_leaf.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace core::guiding {

namespace {

/// A leaf whose guide has been tested by fewer records is not guided.
constexpr double kLeastTested = 64;

/// A smaller part of the new density is not worth drawing from alone.
constexpr double kLeastResidual = 1e-3;

/// Lessons with the values that directions are to learn.
std::vector<Lesson> aimedAt(GuideTarget target, std::span<const Lesson> given)
{
    std::vector<Lesson> lessons(given.begin(), given.end());
    if (target == GuideTarget::product) return lessons;
    for (Lesson& lesson : lessons) {
        // A lesson's square over its density is that of its value times the density.
        const float square = lesson.value * (lesson.value * lesson.pdf);
        lesson.value = target == GuideTarget::radiance
                           ? lesson.arriving
                           : std::min(square, std::numeric_limits<float>::max());
    }
    return lessons;
}

}  // namespace

LearningLeaf::LearningLeaf(uint32_t kind)
{
    if (kind == shared::kGuideLobes) directions.emplace<DirectionLobes>();
    if (kind == shared::kGuideTree) directions.emplace<DirectionTree>();
}

void LearningLeaf::halve()
{
    visits *= 0.5;
    reflected *= 0.5;
    for (double& m : moments) m *= 0.5;
    tested *= 0.5;
    std::visit([](auto& d) { d.halve(); }, directions);
}

LearningLeaf LearningLeaf::child(float plane, uint32_t axis, bool above) const
{
    LearningLeaf child = *this;
    child.cell = cell.part(plane, axis, above);
    child.store.clip(plane, axis, above);
    return child;
}

void LearningLeaf::learn(std::span<const Lesson> lessons, double decay, const GuideOptions& options)
{
    for (double& m : moments) m *= decay;
    tested *= decay;
    const bool hasGuide = knowsLight();
    for (const Lesson& lesson : lessons) {
        visits += 1;
        reflected += double(lesson.reflected);
        if (hasGuide) test(lesson, options);
    }
    if (auto* lobes = std::get_if<DirectionLobes>(&directions)) lobes->fade(std::sqrt(decay));
    if (options.memory == GuideMemory::keep && options.target == GuideTarget::product)
        addToDirections(lessons, options);
    else
        teach(lessons, options);
    choose(options);
}

/// What directions learn in other ways than from values as they are, in addition to all before.
void LearningLeaf::teach(std::span<const Lesson> lessons, const GuideOptions& options)
{
    const bool reuses =
        options.memory == GuideMemory::balance || options.memory == GuideMemory::residual;
    const bool isLobes = std::holds_alternative<DirectionLobes>(directions);
    const bool noMoments = isLobes && options.target == GuideTarget::secondMoment;
    std::vector<Lesson> taught =
        aimedAt(noMoments ? GuideTarget::product : options.target, lessons);
    if (reuses) {
        std::vector<Lesson> all = store.together(taught);
        store.keep(std::move(taught));
        taught = std::move(all);
    }
    if (options.memory != GuideMemory::keep) {
        if (auto* tree = std::get_if<DirectionTree>(&directions))
            tree->forget();
        else if (isLobes)
            directions.emplace<DirectionLobes>();
        else
            directions.emplace<DirectionGrid>();
    }
    addToDirections(taught, options);
}

void LearningLeaf::addToDirections(std::span<const Lesson> lessons, const GuideOptions& options)
{
    if (auto* tree = std::get_if<DirectionTree>(&directions)) tree->learn(lessons, options);
    if (auto* lobes = std::get_if<DirectionLobes>(&directions)) lobes->learn(lessons);
    if (auto* grid = std::get_if<DirectionGrid>(&directions)) grid->learn(lessons);
}

void LearningLeaf::test(const Lesson& lesson, const GuideOptions& options)
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
    if (options.shareBy == ShareBy::adam)
        learntShare.learn(double(lesson.value) * double(lesson.pdf), bsdf, double(lesson.guidePdf),
                          double(lesson.pdf));
}

/// What divides by the rest of a share must not be told that there is none.
constexpr float kLeastShare = 1e-3f;

/// The share with the least second moment, if that is enough of a gain.
void LearningLeaf::choose(const GuideOptions& options)
{
    share = 1;
    if (!knowsLight()) return;
    if (options.fixedShare > 0) {
        share = std::max(options.fixedShare, kLeastShare);
        return;
    }
    if (options.shareBy == ShareBy::adam) {
        share = std::max(float(learntShare.share()), kLeastShare);
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

void LearningLeaf::aim(const GuideOptions& options, double had, double come)
{
    auto* tree = std::get_if<DirectionTree>(&directions);
    if (tree == nullptr) return;
    const Quadtree wanted = tree->density();
    const bool asks = options.memory == GuideMemory::residual && had > 0 && come > 0;
    if (asks && tree->aimed().total() > 0 && wanted.total() > 0) {
        const double c = bestC(tree->aimed(), wanted, had, come);
        Residual lacking = residual(tree->aimed(), wanted, c);
        if (lacking.mass > kLeastResidual) return tree->aim(std::move(lacking.tree));
    }
    tree->aim(wanted);
}

uint32_t LearningLeaf::write(GuideTables& tables, const GuideOptions& options) const
{
    if (const auto* tree = std::get_if<DirectionTree>(&directions)) {
        const auto first = static_cast<uint32_t>(tables.nodes.size());
        tree->write(tables.nodes);
        return first;
    }
    const auto first = static_cast<uint32_t>(tables.directions.size());
    tables.directions.resize(first + shared::guideWords(tables.kind));
    const std::span<glm::vec4> words = std::span(tables.directions).subspan(first);
    if (const auto* lobes = std::get_if<DirectionLobes>(&directions)) lobes->write(words);
    if (const auto* grid = std::get_if<DirectionGrid>(&directions))
        grid->write(words, options.target == GuideTarget::secondMoment);
    return first;
}

bool LearningLeaf::knowsLight() const
{
    return std::visit([](const auto& d) { return d.knowsLight(); }, directions);
}

}  // namespace core::guiding

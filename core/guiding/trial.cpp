// A walk along each recorded path, for both ways to sample at once.
#include "core/guiding/trial.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"

namespace core::guiding {

namespace {

constexpr int kBoundRounds = 4;

/// One way to sample that walks along a path which another one has sampled.
struct Walk {
    double ratio = 1;   // density of the path so far as it was sampled, over that of this way
    double albedo = 1;  // product over vertices, divided by survival
    double squares = 0, brought = 0;
    double arrivals = 0, connections = 0, choices = 0;

    /// A contribution, and the ratio where it was made.
    void bring(double c, double w)
    {
        squares += c * (c * w + 2 * brought);
        brought += c * w;
    }
};

/// What one path tells: second moments, and costs in the walks.
struct Outcome {
    double radiance = 0, image = 0;  // of the path, and what its pixel is thought to have
    double weight = 0;               // of its squares
    Walk plain, guided;
};

/// Ratio of densities where the direction was drawn at a vertex, for the mixture of the leaf.
double pdfByGuide(const Lesson& lesson, double share)
{
    const double guide = (1 - share) * (1 - double(lesson.sharp));
    return (1 - guide) * double(lesson.bsdfPdf) + guide * double(lesson.guidePdf);
}

double byAlbedo(const TrialRules& rules, const Walk& walk, size_t depth)
{
    return depth < rules.rouletteDepth ? 1 : std::min(std::sqrt(walk.albedo), 1.0);
}

/// The vertex that a path arrives at. Without the guide roulette comes before emission, with it
/// after: `survival` of the sampling and of each way apply where theirs do.
void arrive(const TrialRules& rules, const shared::GuideRecord& record,
            const shared::GuideLeaf& leaf, float image, size_t depth, double emitted, Outcome& path)
{
    const double survival = double(shared::survivalOfPlace(record.place));
    const double albedo = double(shared::albedoOfPlace(record.place));
    Walk& p = path.plain;
    const double plain = rules.rests ? survival : byAlbedo(rules, p, depth);
    const double came = p.ratio * (rules.rests ? survival : 1) / plain;
    p.bring(emitted, came);
    p.arrivals += 1 / came;
    p.ratio *= survival / plain;
    p.connections += 1 / p.ratio;
    p.albedo *= albedo / plain;

    Walk& g = path.guided;
    const double before = g.ratio * (rules.rests ? survival : 1);
    g.bring(emitted, before);
    g.arrivals += 1 / before;
    const double beta = double(record.beta) * g.ratio * survival;
    const double guided = depth < rules.rouletteDepth
                              ? 1
                              : double(shared::guidedSurvival(rules.rouletteKind, float(g.albedo),
                                                              float(beta) * leaf.reflected, image));
    g.ratio *= survival / guided;
    g.connections += 1 / g.ratio;
    if (leaf.share < 1) g.choices += 1 / g.ratio;
    g.albedo *= albedo / guided;
}

/// The direction in which it goes on, and what the connection brought.
void go(const Lesson& lesson, const shared::GuideRecord& record, const shared::GuideLeaf& leaf,
        Outcome& path)
{
    const double connected = double(record.after) - double(record.before);
    path.plain.bring(connected, path.plain.ratio);
    path.guided.bring(connected, path.guided.ratio);
    if (!(lesson.pdf > 0)) return;  // delta lobes keep their probability
    path.plain.ratio *= double(lesson.pdf) / std::max(double(lesson.bsdfPdf), 1e-30);
    const double guided = pdfByGuide(lesson, double(leaf.share));
    path.guided.ratio *= double(lesson.pdf) / std::max(guided, 1e-30);
}

shared::GuideLeaf leafOf(const Lesson& lesson, const GuideTables& tables)
{
    const glm::uvec4 word = tables.leaves[lesson.leaf];
    return {lesson.leaf, word.x, shared::uintAsFloat(word.y), shared::uintAsFloat(word.z)};
}

Outcome outcomeOf(std::span<const shared::GuideRecord> records, std::span<const Lesson> lessons,
                  const shared::GuidePathEnd& end, const GuideTables& tables,
                  const TrialRules& rules)
{
    Outcome path;
    double had = 0;
    for (size_t k = 0; k < records.size(); ++k) {
        const shared::GuideLeaf leaf = leafOf(lessons[k], tables);
        arrive(rules, records[k], leaf, end.image, k, double(records[k].before) - had, path);
        go(lessons[k], records[k], leaf, path);
        had = double(records[k].after);
    }
    // The ray that left the last vertex, which met an emitter, nothing, or the end of the path.
    // With what probability it left is not recorded: as its albedo says.
    const double rest = double(end.final) - had;
    const double survival = byAlbedo(rules, path.plain, records.size());
    const double plain = path.plain.ratio / (rules.rests ? 1 : survival);
    const double guided = path.guided.ratio * (rules.rests ? survival : 1);
    path.plain.bring(rest, plain);
    path.guided.bring(rest, guided);
    if (!records.empty() && records.back().direction != 0) {
        path.plain.arrivals += 1 / plain;
        path.guided.arrivals += 1 / guided;
    }
    path.radiance = double(end.final);
    path.image = double(end.image);
    return path;
}

bool isFinite(const Outcome& path)
{
    const auto finite = [](const Walk& w) {
        return std::isfinite(w.squares) && std::isfinite(w.arrivals) &&
               std::isfinite(w.connections) && std::isfinite(w.choices);
    };
    return finite(path.plain) && finite(path.guided) && std::isfinite(path.radiance);
}

/// Squares are relative to those of the pixels and the floor. Where nothing is known of a pixel it
/// is as bright as all of them.
void weigh(std::span<Outcome> paths, double floor)
{
    double radiance = 0, image = 0;
    for (const Outcome& p : paths) radiance += p.radiance;
    for (Outcome& p : paths) {
        if (!(p.image > 0)) p.image = radiance / double(paths.size());
        image += p.image;
    }
    if (!(image > 0)) return;
    for (Outcome& p : paths) p.weight = 1 / (p.image * p.image + floor);
}

/// The factor of each path's squares that keeps a few paths from deciding alone: relative squares
/// are cut at their mean times the root of their number.
double boundOf(std::span<const Outcome> paths)
{
    double most = std::numeric_limits<double>::max();
    for (int round = 0; round < kBoundRounds; ++round) {
        double sum = 0;
        for (const Outcome& p : paths)
            sum += std::min(p.weight * std::max(p.plain.squares, p.guided.squares), most);
        most = std::min(most, sum / std::sqrt(double(paths.size())));
    }
    return most;
}

}  // namespace

PathCosts PathCosts::among(size_t triangles) const
{
    // Measured in eight scenes: a ray with its shading takes two to six times as long in rooms of
    // up to a million triangles as in boxes of some 40, and the guide hardly longer.
    const double levels = std::log2(double(triangles) + 1);
    const double factor = 1 / (1 + 0.12 * std::max(levels - 5, 0.0));
    return {connection, look * factor, choice * factor};
}

/// Those of all paths that count, with the weights of their squares.
static std::vector<Outcome> outcomesOf(std::span<const PathRecords> parts,
                                       std::span<const Lesson> lessons, const GuideTables& tables,
                                       const TrialRules& rules)
{
    std::vector<size_t> firstLesson(parts.size() + 1), firstPath(parts.size() + 1);
    for (size_t i = 0; i < parts.size(); ++i) {
        firstLesson[i + 1] = firstLesson[i] + parts[i].records.size();
        firstPath[i + 1] = firstPath[i] + parts[i].ends.size();
    }
    CHECK(firstLesson.back() == lessons.size());
    std::vector<Outcome> paths(firstPath.back());
    parallelFor(parts.size(), 8, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            size_t r = 0;
            for (size_t k = 0; k < parts[i].ends.size(); ++k) {
                const shared::GuidePathEnd& last = parts[i].ends[k];
                const std::span records(parts[i].records.data() + r, last.count);
                const std::span own = lessons.subspan(firstLesson[i] + r, last.count);
                r += last.count;
                paths[firstPath[i] + k] = outcomeOf(records, own, last, tables, rules);
            }
        }
    });
    std::erase_if(paths, [](const Outcome& p) { return !isFinite(p); });
    weigh(paths, rules.errorFloor);
    return paths;
}

void Trial::add(std::span<const PathRecords> parts, std::span<const Lesson> lessons,
                const GuideTables& tables, const TrialRules& rules, double decay)
{
    const std::vector<Outcome> paths = outcomesOf(parts, lessons, tables, rules);
    if (paths.empty() || !(paths.front().weight > 0)) return;
    const double most = boundOf(paths);
    paths_ *= decay;
    for (WayFigures* sums : {&plain_, &guided_}) {
        sums->variance *= decay;
        sums->arrivals *= decay;
        sums->connections *= decay;
        sums->choices *= decay;
    }
    for (const Outcome& p : paths) {
        const double largest = p.weight * std::max(p.plain.squares, p.guided.squares);
        const double factor = p.weight * (largest > most ? most / largest : 1);
        const auto take = [&](const Walk& walk, WayFigures& sums) {
            sums.variance += factor * (walk.squares - p.radiance * p.image);
            sums.arrivals += walk.arrivals;
            sums.connections += walk.connections;
            sums.choices += walk.choices;
        };
        take(p.plain, plain_);
        take(p.guided, guided_);
    }
    paths_ += double(paths.size());
}

WayFigures Trial::means(const WayFigures& sums) const
{
    if (!(paths_ > 0)) return {};
    return {sums.variance / paths_, sums.arrivals / paths_, sums.connections / paths_,
            sums.choices / paths_};
}

double Trial::gain(const PathCosts& costs) const
{
    const double plain = plain_.variance * plain_.cost({costs.connection, 0, 0});
    const double guided = guided_.variance * guided_.cost(costs);
    return plain > 0 && guided > 0 ? plain / guided : 1;
}

}  // namespace core::guiding

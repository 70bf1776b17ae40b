// See guiding_claims.h.
#include "app/bench/guiding/guiding_claims.h"

#include <algorithm>
#include <cmath>

#include "app/report/text.h"

namespace app::guiding {

namespace {

using report::shortNumber;

constexpr double kMatters = 0.05;  // smaller gains are within what few seeds tell

/// Rows of one claim by the names of their variants.
class Rows {
public:
    Rows(const Results& results, const SceneResult& scene, const Claim& claim)
        : results_(results), scene_(scene), claim_(claim)
    {}

    bool has(std::initializer_list<const char*> names) const
    {
        return std::ranges::all_of(names,
                                   [this](const char* name) { return find(name) != nullptr; });
    }
    const Row* find(std::string_view name) const
    {
        const auto found = std::ranges::find(claim_.rows, name, &Row::variant);
        return found == claim_.rows.end() ? nullptr : *found;
    }
    double error(const char* name) const { return find(name)->relMse.value; }
    double gain(const Row& row) const
    {
        const Row* plain = plainOf(scene_, row);
        return efficiency(deviceNamed(results_, row.device), *plain, row).value;
    }
    double gain(const char* name) const { return gain(*find(name)); }
    double variance(const Row& row) const
    {
        return varianceRatio(*plainOf(scene_, row), row).value;
    }

private:
    const Results& results_;
    const SceneResult& scene_;
    const Claim& claim_;
};

std::string changeInPercent(double ratio)
{
    const double change = 100 * (ratio - 1);
    return std::string(change < 0 ? "" : "+") + report::fixedNumber(change, 0) + " %";
}

std::string onPapers(const Rows& rows, const Claim& claim)
{
    std::string text;
    for (const Row* row : claim.rows) {
        if (!row->variant.starts_with("ppg")) continue;
        text += (text.empty() ? "" : ", ") + row->variant + " " + shortNumber(rows.gain(*row)) +
                " (variance " + shortNumber(rows.variance(*row)) + " times lower)";
    }
    return text.empty() ? text : "Efficiency over path tracing without a guide: " + text + ".";
}

/// Old records are worth their price where less error than with any memory without them outweighs
/// their time.
std::string onTraining(const Rows& rows)
{
    if (!rows.has({"memory-reset", "memory-keep", "memory-balance", "memory-residual"})) return {};
    const double without = std::max(rows.gain("memory-reset"), rows.gain("memory-keep"));
    const double with = std::max(rows.gain("memory-balance"), rows.gain("memory-residual"));
    const double ratio = with / without;
    std::string text = "Reuse of training records changes the variance by " +
                       changeInPercent(rows.error("memory-balance") / rows.error("memory-reset")) +
                       " (balance heuristic) and " +
                       changeInPercent(rows.error("memory-residual") / rows.error("memory-reset")) +
                       " (residual) against learning anew, while keeping sums changes it by " +
                       changeInPercent(rows.error("memory-keep") / rows.error("memory-reset")) +
                       "; the better of the two has " + shortNumber(ratio) +
                       " times the efficiency of the better without. ";
    text += ratio > 1 + kMatters   ? "It pays."
            : ratio < 1 - kMatters ? "It does not pay."
                                   : "It makes no difference.";
    return text;
}

/// By what a row's variant weighs its iterations.
core::Combine combineOf(const Row& row)
{
    return paramsOf(variantNamed(row.variant), {}, 1, row.spp).as<core::GuidedParams>().combine;
}

std::string onCombinations(const Rows& rows, const Claim& claim)
{
    if (!rows.has({"combine-samples", "combine-last"}) || claim.rows.size() < 3) return {};
    const Row* best =
        *std::ranges::min_element(claim.rows, {}, [](const Row* row) { return row->relMse.value; });
    std::string text = "The least variance: " + best->variant + " (" +
                       variantNamed(best->variant).help + "), " +
                       changeInPercent(best->relMse.value / rows.error("combine-samples")) +
                       " against weights by samples and " +
                       changeInPercent(best->relMse.value / rows.error("combine-last")) +
                       " against the last iteration alone.";
    const Row *ess = nullptr, *variance = nullptr;
    for (const Row* row : claim.rows) {
        const core::Combine by = combineOf(*row);
        const bool isEss = by == core::Combine::ess;
        const bool isVariance =
            by == core::Combine::inverseVariance || by == core::Combine::meanInverseVariance;
        for (auto [is, of] : {std::pair{isEss, &ess}, {isVariance, &variance}})
            if (is && (*of == nullptr || row->relMse.value < (*of)->relMse.value)) *of = row;
    }
    if (ess != nullptr && variance != nullptr)
        text += " The best of ESS (" + ess->variant + ") has " +
                changeInPercent(ess->relMse.value / variance->relMse.value) +
                " variance against the best of inverse variance (" + variance->variant + ").";
    return text;
}

/// At how many of the depths old records help, and which depth is best.
std::string onDepths(const Rows& rows, const Claim& claim)
{
    size_t depths = 0, helps = 0;
    const Row* best = nullptr;
    for (const Row* row : claim.rows) {
        if (row->variant.ends_with("-balance")) continue;
        if (best == nullptr || row->relMse.value < best->relMse.value) best = row;
        const Row* reuse = rows.find(row->variant + "-balance");
        if (reuse == nullptr) continue;
        ++depths;
        helps += rows.gain(*reuse) > (1 + kMatters) * rows.gain(*row) ? 1u : 0u;
    }
    if (best == nullptr || depths == 0) return {};
    return "Of trees of fixed depth " + best->variant +
           " has the least variance. Old records pay at " + std::to_string(helps) + " of " +
           std::to_string(depths) + " depths.";
}

std::string sentenceOf(const Rows& rows, const Claim& claim)
{
    switch (claim.family) {
    case Family::papers:
        return onPapers(rows, claim);
    case Family::training:
        return onTraining(rows);
    case Family::combinations:
        return onCombinations(rows, claim);
    case Family::depths:
        return onDepths(rows, claim);
    case Family::switches:
        break;
    }
    return {};
}

}  // namespace

std::vector<Claim> claimsOf(const Results& results, const SceneResult& scene)
{
    std::vector<Claim> claims;
    for (const Family family : kFamilies) {
        if (family == Family::switches) continue;
        for (const BenchDevice& device : results.devices)
            for (const uint32_t spp : results.sweep) {
                Claim claim{family, device.name, spp, {}, {}};
                for (const Row& row : scene.rows)
                    if (row.device == device.name && row.spp == spp &&
                        variantNamed(row.variant).family == family)
                        claim.rows.push_back(&row);
                if (claim.rows.empty()) continue;
                claim.sentence = sentenceOf(Rows(results, scene, claim), claim);
                claims.push_back(std::move(claim));
            }
    }
    return claims;
}

}  // namespace app::guiding

// M23. The help of each parameter of completion names the ways that it counts for: another value
// changes what these find or trace, and nothing of the others.
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/completion/bits.h"
#include "tests/support/methods/completion_runs.h"

namespace core::many_lights {
namespace {

/// Some columns are brighter than others, and not all rows matter, but any may be asked for.
class UnevenOracle final : public VisibilityOracle {
public:
    UnevenOracle(const tests::BitMatrix& truth, const tests::BitMatrix& matters)
        : asked(truth.rows(), truth.columns()), truth_(truth), matters_(matters)
    {}
    void trace(std::span<const TraceRequest> requests) override
    {
        for (const TraceRequest& request : requests)
            for (size_t w = 0; w < truth_.wordsPerColumn(); ++w) {
                request.visible[w] |= truth_.column(request.column)[w] & request.rows[w];
                asked.column(request.column)[w] |= request.rows[w];
            }
    }
    const uint64_t* matters(uint32_t column) const override
    {
        return matters_.column(column).data();
    }
    std::optional<float> brightness(uint32_t column) const override
    {
        return column % 5 == 0 ? 3.0f : 0.5f;
    }

    tests::BitMatrix asked;

private:
    const tests::BitMatrix &truth_, &matters_;
};

constexpr uint32_t kSide = 20, kSceneColumns = 60;

struct Scene {
    tests::BitMatrix truth, matters;
};

/// Where there is something to learn, to repair and to give up.
const std::vector<Scene>& scenes()
{
    static const std::vector<Scene> all = [] {
        Pcg32 random(7);
        const uint32_t rows = kSide * kSide;
        std::vector<Scene> made;
        for (tests::BitMatrix truth :
             {tests::spheresMatrix(kSide, kSceneColumns, 6, 0.12, 0.5, random),
              tests::edgesMatrix(rows, kSceneColumns, random),
              tests::dictionaryMatrix(rows, kSceneColumns, 6, random),
              tests::foliageMatrix(rows, kSceneColumns, 10, random)})
            made.push_back({std::move(truth), tests::facingMask(rows, kSceneColumns, 0.8, random)});
        return made;
    }();
    return all;
}

/// What there is of a completed slice to tell apart.
struct Found {
    std::vector<uint64_t> bits;
    std::vector<float> coefficients;
    std::vector<float> residual;
    std::vector<uint64_t> asked;
    friend bool operator==(const Found&, const Found&) = default;
};

std::vector<Found> foundBy(const CompletionParams& params)
{
    std::vector<Found> all;
    for (const Scene& scene : scenes()) {
        if (params.method == CompletionMethod::svt && !all.empty()) break;  // which takes long
        UnevenOracle oracle(scene.truth, scene.matters);
        CompletedSlice slice;
        complete(oracle, scene.truth.rows(), std::vector<ColumnRange>{{0, kSceneColumns}}, params,
                 1, slice);
        const auto words = [](const tests::BitMatrix& m) {
            return std::vector<uint64_t>(m.words().begin(), m.words().end());
        };
        Found found{words(slice.visible), slice.coefficients, {}, words(oracle.asked)};
        for (const ResidualEntry& r : slice.residual) found.residual.push_back(r.weight);
        all.push_back(std::move(found));
    }
    return all;
}

/// The methods that a help names before its first colon, or all that sample, but for those that it
/// says it is not of.
std::set<CompletionMethod> methodsOf(const Field& field)
{
    const std::string help = field.help;
    const std::string before = help.substr(0, help.find(':'));
    std::set<CompletionMethod> named, all;
    for (const CompletionMethod method : {CompletionMethod::matching, CompletionMethod::gaussJordan,
                                          CompletionMethod::amc, CompletionMethod::svt}) {
        const std::string name(enumName(method));
        if (help.find("Not of " + name) == std::string::npos) all.insert(method);
        if (before != help && before.find(name) != std::string::npos) named.insert(method);
    }
    if (std::string_view(field.name) == "dont-care") all.insert(CompletionMethod::full);
    return named.empty() ? all : named;
}

/// Another value, one that can make a difference in slices of 400 rows.
template <class T> T otherValue(const Field& field, T value)
{
    const std::string_view name = field.name;
    if constexpr (std::is_same_v<T, bool>) return !value;
    if constexpr (std::is_enum_v<T>) return static_cast<T>(0);  // neither's default
    if constexpr (std::is_same_v<T, float>) {
        if (name == "row-cap") return 0.03f;
        if (name == "bail-out") return 0.1f;
        return 0.3f;
    }
    if constexpr (std::is_same_v<T, uint32_t>) {
        if (name == "small-slice") return 10000;
        return name == "row-minimum" ? 60 : 3;
    }
}

/// With another value of the parameter of that name.
CompletionParams withOther(CompletionParams params, const Field& changed)
{
    CompletionParams::visit(params, [&](const Field& field, auto& member) {
        if (std::string_view(field.name) == changed.name) member = otherValue(field, member);
    });
    return params;
}

TEST(CompletionParams, CountForTheMethodsThatTheirHelpNames)
{
    std::vector<Field> fields;
    CompletionParams any;
    CompletionParams::visit(any, [&](const Field& field, auto&) {
        if (std::string_view(field.name) != "completion") fields.push_back(field);
    });
    EXPECT_EQ(fields.size(), 22u);
    for (const CompletionMethod method :
         {CompletionMethod::full, CompletionMethod::matching, CompletionMethod::gaussJordan,
          CompletionMethod::amc, CompletionMethod::svt}) {
        CompletionParams params;
        params.method = method;
        params.rowMinimum = 6;
        params.rowRate = 0.06f;
        params.svtIterations = 4;
        const std::vector<Found> found = foundBy(params);
        for (const Field& field : fields) {
            const bool unguarded = std::string_view(field.name) == "replacement";
            params.guard = !unguarded;
            const CompletionParams other = withOther(params, field);
            EXPECT_NE(params, other) << field.name;
            EXPECT_EQ((unguarded ? foundBy(params) : found) != foundBy(other),
                      methodsOf(field).contains(method))
                << field.name << ", " << enumName(method);
        }
    }
}

}  // namespace
}  // namespace core::many_lights

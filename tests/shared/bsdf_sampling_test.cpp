// T3 and T5: directions drawn by sampleBsdf against pdfBsdf, by chi-square. Microfacet lobes are
// binned by half vector in slopes of the interface divided by alpha (q = s^2 / (1 + s^2) and
// azimuth), where lobes of every width look alike; the density is carried there by textbook
// Jacobians in double. Mixtures with a diffuse part are binned by direction. What ends below the
// surface has a cell of its own: the probability that the density lacks.
#include "tests/support/methods/bsdf_cases.h"

#include <functional>
#include <gtest/gtest.h>
#include <vector>

namespace tests {
namespace {

constexpr int kTestRows = 16;
constexpr int kTestColumns = 32;
constexpr double kDegrees[] = {0, 45, 75, 85, 89.5};

using SquareDensity = std::function<double(double, double)>;  // over the unit square

/// Gauss-Legendre with three points a side.
double gauss(const SquareDensity& f, double x, double y, double w, double h)
{
    static constexpr double kNode[] = {0.11270166537925831, 0.5, 0.88729833462074169};
    static constexpr double kWeight[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            sum += kWeight[i] * kWeight[j] * f(x + w * kNode[i], y + h * kNode[j]);
    }
    return sum * w * h;
}

/// Integral over a cell, halving it both ways until halves agree with the whole, `first` times at
/// least.
double integrate(const SquareDensity& f, double x, double y, double w, double h, double tolerance,
                 int first = 1, int depth = 0)
{
    double whole = gauss(f, x, y, w, h);
    double quarters[4];
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        quarters[k] = gauss(f, x + (k % 2) * w / 2, y + (k / 2) * h / 2, w / 2, h / 2);
        sum += quarters[k];
    }
    if (depth >= 7 || (depth >= first && std::abs(sum - whole) <= tolerance)) return sum;
    sum = 0;
    for (int k = 0; k < 4; ++k) {
        sum += integrate(f, x + (k % 2) * w / 2, y + (k / 2) * h / 2, w / 2, h / 2, tolerance / 2,
                         first, depth + 1);
    }
    return sum;
}

/// Probability of cell c of the unit square. Where samples fell and no node saw the support, it
/// looks closer.
double cellProbability(const SquareDensity& f, std::size_t c, double observed, uint count)
{
    double x = static_cast<double>(c / kTestColumns) / kTestRows;
    double y = static_cast<double>(c % kTestColumns) / kTestColumns;
    double p = integrate(f, x, y, 1.0 / kTestRows, 1.0 / kTestColumns, 0.2 / count);
    return p > 0 || observed == 0
               ? p
               : integrate(f, x, y, 1.0 / kTestRows, 1.0 / kTestColumns, 0.2 / count, 5);
}

struct Slope {
    double v;     // 1 - (1 + s^2)^(-1/4), s = tan(angle of h) / alpha
    double turn;  // azimuth of h in [0,1)
};

Slope slopeOf(dvec3 h, double alpha)
{
    double s2 = (h.x * h.x + h.y * h.y) / (alpha * alpha * h.z * h.z);
    double t = std::atan2(h.y, h.x) / (2 * kPi);
    return {1 - std::pow(1 + s2, -0.25), t < 0 ? t + 1 : t};
}

dvec3 normalOf(double v, double turn, double alpha)
{
    double s = alpha * std::sqrt(std::pow(1 - v, -4) - 1);
    return normalize(dvec3(s * std::cos(2 * kPi * turn), s * std::sin(2 * kPi * turn), 1));
}

/// d(solid angle of h) / d(v, turn): cos^3 for the plane of slopes, 4 pi / (1-v)^5 for its polar
/// coordinates.
double normalJacobian(double v, dvec3 h, double alpha)
{
    return alpha * alpha * h.z * h.z * h.z * 4 * kPi * std::pow(1 - v, -5);
}

/// How directions of one side of a material come from half vectors.
struct Side {
    bool refracts;
    bool below;
    double eta;

    dvec3 halfOf(dvec3 wo, dvec3 wi) const
    {
        if (!refracts) return normalize(wo + dvec3(wi.x, wi.y, std::abs(wi.z)));
        dvec3 h = normalize(wo + eta * wi);
        return h.z < 0 ? -h : h;
    }

    /// wi for h and d(wi)/d(h); false where there is none on this side.
    bool directionOf(dvec3 wo, dvec3 h, dvec3& wi, double& jacobian) const
    {
        double c = dot(wo, h);
        if (!(c > 0)) return false;
        if (!refracts) {
            wi = 2 * c * h - wo;
            jacobian = 4 * c;
            if (!(wi.z > 0)) return false;
            if (below) wi.z = -wi.z;
            return true;
        }
        double cosine2 = 1 - (1 - c * c) / (eta * eta);
        if (!(cosine2 > 0)) return false;
        double t = std::sqrt(cosine2);
        wi = (c / eta - t) * h - wo / eta;
        jacobian = (c - eta * t) * (c - eta * t) / (eta * eta * t);
        return wi.z < 0;
    }
};

using Draw = std::function<bool(const Bsdf&, vec3, uint, BsdfSample&)>;
using Pdf = std::function<float(const Bsdf&, vec3, vec3)>;

bool drawReal(const Bsdf& b, vec3 wo, uint i, BsdfSample& s)
{
    return drawBsdf(b, wo, i, s);
}

/// Chi-square of `count` draws over the half vectors of one or two sides, and over the lost ones.
ChiSquare halfVectorTest(const Bsdf& b, vec3 wo, const std::vector<Side>& sides, uint count,
                         const Draw& draw = drawReal, const Pdf& pdf = shared::pdfBsdf)
{
    std::size_t cells = kTestRows * kTestColumns;
    std::vector<double> observed(cells * sides.size() + 1);
    std::vector<double> expected(observed.size());
    double alpha = static_cast<double>(b.alpha);
    for (uint i = 0; i < count; ++i) {
        BsdfSample s;
        std::size_t where = observed.size() - 1;
        if (draw(b, wo, i, s)) {
            std::size_t side = s.wi.z < 0 && sides.size() > 1 ? 1 : 0;
            Slope slope = slopeOf(sides[side].halfOf(dvec3(wo), dvec3(s.wi)), alpha);
            auto row =
                std::min<std::size_t>(kTestRows - 1, static_cast<std::size_t>(slope.v * kTestRows));
            auto column = std::min<std::size_t>(
                kTestColumns - 1, static_cast<std::size_t>(slope.turn * kTestColumns));
            where = side * cells + row * kTestColumns + column;
        }
        observed[where] += 1;
    }
    double total = 0;
    for (std::size_t side = 0; side < sides.size(); ++side) {
        SquareDensity density = [&](double v, double turn) {
            dvec3 h = normalOf(v, turn, alpha);
            dvec3 wi;
            double jacobian;
            if (!sides[side].directionOf(dvec3(wo), h, wi, jacobian)) return 0.0;
            return static_cast<double>(pdf(b, wo, vec3(wi))) * jacobian *
                   normalJacobian(v, h, alpha);
        };
        for (std::size_t c = 0; c < cells; ++c) {
            double p = cellProbability(density, c, observed[side * cells + c], count);
            expected[side * cells + c] = p * count;
            total += p;
        }
    }
    EXPECT_LE(total, 1 + 2e-3);  // T5
    expected.back() = std::max(0.0, 1 - total) * count;
    // A loss of less than the quadrature's error is none.
    if (expected.back() < 5e-4 * count && observed.back() <= 1e-3 * count)
        expected.back() = observed.back();
    return chiSquareTest(observed, expected);
}

void expectGood(const ChiSquare& r, uint count, const std::string& what)
{
    EXPECT_GT(r.p, kLevel) << what << ": " << r.statistic << " for " << r.degreesOfFreedom;
    EXPECT_LE(r.outside, 1e-5 * count) << what << ": samples where the density is zero";
}

std::vector<Side> sidesOf(Wall wall)
{
    double eta = wall == Wall::inside ? 1 / 1.5 : 1.5;
    return {{false, false, eta}, {wall != Wall::thin, true, eta}};
}

void testLobes(uint most, const std::vector<float>& alphas)
{
    for (float alpha : alphas) {
        for (double angle : kDegrees) {
            vec3 wo = directionAt(angle);
            // A direction in fp32 resolves half vectors to 0.4 % of the narrowest lobe at the most
            // grazing angle; more samples would see that grid.
            uint count = alpha < 2e-3f && angle > 89 ? std::min(most, 200'000u) : most;
            std::string at = " alpha " + std::to_string(alpha) + " at " + std::to_string(angle);
            expectGood(
                halfVectorTest(shared::makeBsdf(metal(alpha)), wo, {{false, false, 1}}, count),
                count, "metal" + at);
            for (Wall wall : {Wall::thin, Wall::outside, Wall::inside}) {
                const char* name = wall == Wall::thin      ? "thin"
                                   : wall == Wall::outside ? "outside"
                                                           : "inside";
                expectGood(
                    halfVectorTest(shared::makeBsdf(glass(alpha, wall)), wo, sidesOf(wall), count),
                    count, name + at);
            }
        }
    }
}

TEST(BsdfSampling, lobesFollowTheirDensity)
{
    testLobes(100'000, {1.001e-3f, 0.01f, 0.05f, 0.2f, 0.5f, 1.0f});
}

TEST(BsdfSampling, SlowLobesFollowTheirDensity)
{
    testLobes(2'000'000, {1.001e-3f, 0.01f, 0.05f, 0.2f, 0.5f, 1.0f});
}

// --- mixtures

/// Chi-square over directions: equal cells of the whole sphere's cosine (upper half, and lower if
/// it transmits).
ChiSquare directionTest(const Bsdf& b, vec3 wo, uint count)
{
    std::size_t cells = kTestRows * kTestColumns;
    bool sphere = (b.parts & shared::kBsdfTransmission) != 0;
    double low = sphere ? -1 : 0;
    std::vector<double> observed(cells + 1);
    std::vector<double> expected(cells + 1);
    for (uint i = 0; i < count; ++i) {
        BsdfSample s;
        std::size_t where = cells;
        if (drawBsdf(b, wo, i, s) && s.pdf > 0) {
            double height = (static_cast<double>(s.wi.z) - low) / (1 - low);
            double turn =
                std::atan2(static_cast<double>(s.wi.y), static_cast<double>(s.wi.x)) / (2 * kPi);
            if (turn < 0) turn += 1;
            where =
                std::min<std::size_t>(kTestRows - 1, static_cast<std::size_t>(height * kTestRows)) *
                    kTestColumns +
                std::min<std::size_t>(kTestColumns - 1,
                                      static_cast<std::size_t>(turn * kTestColumns));
        }
        observed[where] += 1;
    }
    SquareDensity density = [&](double height, double turn) {
        double z = low + height * (1 - low);
        double r = std::sqrt(1 - z * z);
        vec3 wi(dvec3(r * std::cos(2 * kPi * turn), r * std::sin(2 * kPi * turn), z));
        return static_cast<double>(shared::pdfBsdf(b, wo, wi)) * 2 * kPi * (1 - low);
    };
    double total = 0;
    for (std::size_t c = 0; c < cells; ++c) {
        double p = cellProbability(density, c, observed[c], count);
        expected[c] = p * count;
        total += p;
    }
    EXPECT_LE(total, 1 + 2e-3);
    expected[cells] = std::max(0.0, 1 - total) * count;
    if (expected[cells] < 5e-4 * count && observed[cells] <= 1e-3 * count)
        expected[cells] = observed[cells];
    return chiSquareTest(observed, expected);
}

void testMixtures(uint count)
{
    for (float roughness : {0.45f, 0.7f, 1.0f}) {
        std::vector<BsdfInputs> mixtures = {matte(vec3(0.3f)), plastic(roughness)};
        mixtures.back().baseColor = vec3(0.05f, 0.3f, 0.2f);
        mixtures.push_back(mixtures.back());
        mixtures.back().clearcoat = 0.7f;
        mixtures.back().clearcoatRoughness = 0.5f;
        mixtures.push_back(mixtures.back());
        mixtures.back().metallic = 0.4f;
        mixtures.back().transmission = 0.6f;
        mixtures.push_back(mixtures.back());
        mixtures.back().flags = shared::kMaterialVolume;
        mixtures.push_back(mixtures.back());
        mixtures.back().backFace = 1;
        for (std::size_t i = 0; i < mixtures.size(); ++i) {
            for (double angle : {0.0, 45.0, 75.0, 85.0}) {
                Bsdf b = shared::makeBsdf(mixtures[i]);
                expectGood(directionTest(b, directionAt(angle), count), count,
                           "mixture " + std::to_string(i) + " roughness " +
                               std::to_string(roughness) + " at " + std::to_string(angle));
            }
        }
    }
}

TEST(BsdfSampling, mixturesFollowTheirDensity)
{
    testMixtures(100'000);
}

TEST(BsdfSampling, SlowMixturesFollowTheirDensity)
{
    testMixtures(2'000'000);
}

TEST(BsdfSampling, deltaPartsAreDrawnWithTheProbabilityTheDensityLacks)
{
    BsdfInputs varnished = plastic(0);
    varnished.baseColor = vec3(0.4f);
    BsdfInputs coated = plastic(0.6f);
    coated.clearcoat = 1;
    for (const BsdfInputs& m : {varnished, coated}) {
        Bsdf b = shared::makeBsdf(m);
        for (double angle : {10.0, 60.0, 80.0}) {
            vec3 wo = directionAt(angle);
            constexpr uint kCount = 200'000;
            double delta = 0;
            double lost = 0;
            for (uint i = 0; i < kCount; ++i) {
                BsdfSample s;
                if (!drawBsdf(b, wo, i, s)) {
                    lost += 1;
                } else if ((s.flags & shared::kLobeDelta) != 0) {
                    delta += 1;
                    EXPECT_EQ(s.pdf, 0.0f);
                }
            }
            SquareDensity density = [&](double z, double turn) {
                double r = std::sqrt(1 - z * z);
                vec3 wi(dvec3(r * std::cos(2 * kPi * turn), r * std::sin(2 * kPi * turn), z));
                return static_cast<double>(shared::pdfBsdf(b, wo, wi)) * 2 * kPi;
            };
            double p = 0;
            for (int i = 0; i < 64; ++i) p += integrate(density, i / 64.0, 0, 1.0 / 64, 1, 1e-7);
            EXPECT_GT(delta, 0);
            double sigma = std::sqrt(p * (1 - p) / kCount);
            EXPECT_NEAR(1 - (delta + lost) / kCount, p, kScore * sigma + 1e-4) << angle;
        }
    }
}

// --- the test of the tests

/// Draws like sampleBsdf of a metal, with a normal that `normal` makes.
Draw metalWith(const std::function<vec3(vec3, float, vec2)>& normal)
{
    return [normal](const Bsdf& b, vec3 wo, uint i, BsdfSample& s) {
        auto stream = shared::makeStream(shared::kSamplerIndependent, 1, uvec2(3, 4), i,
                                         shared::kPurposePath);
        s.flags = shared::kLobeSpecular;
        s.wi = shared::mirrorAbout(wo, normal(wo, b.alpha, shared::streamVec2(stream, 0)));
        return s.wi.z > 0;
    };
}

float depthOf(vec3 wo, float alpha)
{
    return shared::capDepth(wo.z, alpha * alpha, false);
}

TEST(BsdfSampling, plantedFaultsAreSeen)
{
    constexpr uint kCount = 100'000;
    for (float alpha : {0.01f, 0.2f, 0.5f}) {
        Bsdf b = shared::makeBsdf(metal(alpha));
        vec3 wo = directionAt(60);
        std::vector<Side> mirror = {{false, false, 1}};
        // The frame itself is good.
        auto right = metalWith([](vec3 w, float a, vec2 u) {
            return shared::visibleNormal(w, a, depthOf(w, a), shared::sampleDisk(u));
        });
        EXPECT_GT(halfVectorTest(b, wo, mirror, kCount, right).p, kLevel);
        // A missing square root: the disk's radius taken as uniform.
        auto noRoot = metalWith([](vec3 w, float a, vec2 u) {
            vec2 p = shared::sampleDisk(u);
            return shared::visibleNormal(w, a, depthOf(w, a), p * shared::length(p));
        });
        EXPECT_LT(halfVectorTest(b, wo, mirror, kCount, noRoot).p, 1e-20);
        // All normals instead of the visible ones.
        auto allNormals = metalWith([](vec3, float a, vec2 u) {
            return shared::visibleNormal(vec3(0, 0, 1), a, 1, shared::sampleDisk(u));
        });
        if (alpha > 0.1f) {
            EXPECT_LT(halfVectorTest(b, wo, mirror, kCount, allNormals).p, 1e-20);
        }
        // Alpha wrong by 5 %.
        auto wider = metalWith([](vec3 w, float a, vec2 u) {
            return shared::visibleNormal(w, a * 1.05f, depthOf(w, a), shared::sampleDisk(u));
        });
        EXPECT_LT(halfVectorTest(b, wo, mirror, kCount, wider).p, kLevel);
        // A half-vector density without its Jacobian.
        auto noJacobian = [](const Bsdf& m, vec3 o, vec3 i) {
            return shared::pdfBsdf(m, o, i) * 4 * shared::dot(o, shared::normalize(o + i)) / 3;
        };
        EXPECT_LT(halfVectorTest(b, wo, mirror, kCount, right, noJacobian).p, 1e-20);
    }
    // Refraction with eta^2 forgotten in the density.
    Bsdf b = shared::makeBsdf(glass(0.2f, Wall::inside));
    auto noEta = [](const Bsdf& m, vec3 o, vec3 i) {
        float p = shared::pdfBsdf(m, o, i);
        return i.z < 0 ? p * (m.eta * m.eta) : p;
    };
    EXPECT_LT(halfVectorTest(b, directionAt(20), sidesOf(Wall::inside), kCount, drawReal, noEta).p,
              1e-20);
}

}  // namespace
}  // namespace tests

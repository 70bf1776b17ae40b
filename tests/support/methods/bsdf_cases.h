// Materials and helpers that the tests of bsdf.h share, and textbook formulas in double to compare
// with.
#pragma once

#include "shared/bsdf.h"
#include "shared/sampler.h"
#include "tests/support/statistics/stats.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace tests {

using shared::Bsdf;
using shared::BsdfInputs;
using shared::BsdfSample;
using shared::uint;
using shared::uvec2;
using shared::vec2;
using shared::vec3;
using dvec3 = glm::dvec3;

inline constexpr double kPi = std::numbers::pi;

/// White, rough, opaque, index 1.5: the defaults of glTF.
inline BsdfInputs plastic(float roughness = 1)
{
    return BsdfInputs{vec3(1), 0, roughness, 1.5f, 0, vec3(1), 1, 0, 0, 0, 0};
}

inline BsdfInputs matte(vec3 color = vec3(1))
{
    BsdfInputs m = plastic();
    m.baseColor = color;
    m.specular = 0;
    return m;
}

inline BsdfInputs metal(float alpha)
{
    BsdfInputs m = plastic(std::sqrt(alpha));
    m.metallic = 1;
    return m;
}

enum class Wall { thin, outside, inside };

inline BsdfInputs glass(float alpha, Wall wall, float ior = 1.5f)
{
    BsdfInputs m = plastic(std::sqrt(alpha));
    m.transmission = 1;
    m.ior = ior;
    m.flags = wall == Wall::thin ? 0 : shared::kMaterialVolume;
    m.backFace = wall == Wall::inside ? 1 : 0;
    return m;
}

/// A direction at `degrees` from the normal, turned off the axes of the frame.
inline vec3 directionAt(double degrees, double turn = 0.7)
{
    double theta = degrees * kPi / 180;
    return vec3(
        dvec3(std::sin(theta) * std::cos(turn), std::sin(theta) * std::sin(turn), std::cos(theta)));
}

/// One call of sampleBsdf with numbers of stream `index`.
inline bool drawBsdf(const Bsdf& b, vec3 wo, uint index, BsdfSample& s,
                     uint kind = shared::kSamplerIndependent, uint seed = 1)
{
    auto stream = shared::makeStream(kind, seed, uvec2(3, 4), index, shared::kPurposePath);
    return shared::sampleBsdf(b, wo, shared::streamFloat(stream, 1), shared::streamVec2(stream, 0),
                              s);
}

/// Albedo towards wo as the mean weight of samples: Sobol points, one moment per scramble. Radiance
/// that enters or leaves a solid is counted as flux (times eta^2).
inline Moments sampledAlbedo(const Bsdf& b, vec3 wo, uint count, uint scrambles = 8)
{
    Moments result;
    for (uint r = 0; r < scrambles; ++r) {
        double sum = 0;
        for (uint i = 0; i < count; ++i) {
            BsdfSample s;
            if (!drawBsdf(b, wo, i, s, shared::kSamplerSobol, r)) continue;
            bool refracted =
                (s.flags & shared::kLobeTransmission) != 0 && (b.parts & shared::kBsdfSolid) != 0;
            double flux = refracted ? static_cast<double>(b.eta * b.eta) : 1.0;
            sum += flux * static_cast<double>(shared::maxComponent(s.weight));
        }
        result.add(sum / count);
    }
    return result;
}

// --- textbook formulas

inline double lambda(double cosine, double alpha)
{
    double tangent2 = (1 - cosine * cosine) / (cosine * cosine);
    return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}

inline double ggx(dvec3 h, double alpha)
{
    double d = h.z * h.z * (alpha * alpha - 1) + 1;
    return alpha * alpha / (kPi * d * d);
}

inline double fresnel(double cosine, double eta)
{
    double sine2 = (1 - cosine * cosine) / (eta * eta);
    if (sine2 >= 1) return 1;
    double t = std::sqrt(1 - sine2);
    double parallel = (eta * cosine - t) / (eta * cosine + t);
    double perpendicular = (cosine - eta * t) / (cosine + eta * t);
    return (parallel * parallel + perpendicular * perpendicular) / 2;
}

/// Density of visible normals (Heitz 2018, eq. 3).
inline double visible(dvec3 wo, dvec3 h, double alpha)
{
    return ggx(h, alpha) * std::max(0.0, dot(wo, h)) / ((1 + lambda(wo.z, alpha)) * wo.z);
}

/// Albedo of single-scattering GGX with reflectance one, by quadrature over visible normals:
/// Heitz's first sampling (2018), which shares nothing with the one in bsdf.h.
inline double albedoTable(double cosine, double alpha, int n = 400)
{
    dvec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
    dvec3 v = normalize(dvec3(alpha * wo.x, 0, wo.z));
    dvec3 t1 = v.z < 0.9999 ? normalize(cross(dvec3(0, 0, 1), v)) : dvec3(1, 0, 0);
    dvec3 t2 = cross(v, t1);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            double r = std::sqrt((i + 0.5) / n);
            double phi = 2 * kPi * (j + 0.5) / n;
            double a = r * std::cos(phi);
            double s = 0.5 * (1 + v.z);
            double b = (1 - s) * std::sqrt(1 - a * a) + s * r * std::sin(phi);
            dvec3 h = a * t1 + b * t2 + std::sqrt(std::max(0.0, 1 - a * a - b * b)) * v;
            h = normalize(dvec3(alpha * h.x, alpha * h.y, std::max(1e-12, h.z)));
            double iz = 2 * dot(wo, h) * h.z - wo.z;
            if (iz > 0)
                sum += (1 + lambda(wo.z, alpha)) / (1 + lambda(wo.z, alpha) + lambda(iz, alpha));
        }
    }
    return sum / n / n;
}

/// Of directions to the normal, in degrees.
inline constexpr double kAngles[] = {0, 30, 60, 75, 85, 89.5};

/// Materials that cover all of the model, white where colour is possible.
inline std::vector<BsdfInputs> everyMaterial()
{
    std::vector<BsdfInputs> all = {matte()};
    for (float roughness : {0.0f, 0.1f, 0.25f, 0.5f, 0.75f, 1.0f}) {
        all.push_back(plastic(roughness));
        all.push_back(metal(roughness * roughness));
        for (Wall wall : {Wall::thin, Wall::outside, Wall::inside}) {
            all.push_back(glass(roughness * roughness, wall));
            all.push_back(all.back());
            all.back().transmission = 0.5f;
            all.back().metallic = 0.3f;
        }
    }
    std::size_t plain = all.size();
    for (std::size_t i = 0; i < plain; ++i) {
        for (float roughness : {0.0f, 0.4f, 1.0f}) {
            all.push_back(all[i]);
            all.back().clearcoat = 1;
            all.back().clearcoatRoughness = roughness;
        }
        all.push_back(all[i]);
        all.back().specularColor = vec3(0);
        all.push_back(all[i]);
        all.back().specular = 0.5f;
        all.back().specularColor = vec3(25, 2, 0.3f);
        all.back().ior = 2.4f;
    }
    return all;
}

inline std::string describe(const BsdfInputs& m)
{
    return "metallic " + std::to_string(m.metallic) + " roughness " + std::to_string(m.roughness) +
           " ior " + std::to_string(m.ior) + " transmission " + std::to_string(m.transmission) +
           " specular " + std::to_string(m.specular) + " of " + std::to_string(m.specularColor.x) +
           " coat " + std::to_string(m.clearcoat) + "/" + std::to_string(m.clearcoatRoughness) +
           " flags " + std::to_string(m.flags) + " back " + std::to_string(m.backFace);
}

}  // namespace tests

// Reads two files, measures, prints. core/image/metrics.h and core/image/flip.h define the numbers.
#include "app/commands/compare.h"

#include <charconv>
#include <cmath>

#include <nlohmann/json.hpp>

#include "app/base/json_file.h"
#include "app/commands/stored_picture.h"
#include "app/files/picture_layers.h"
#include "core/base/check.h"
#include "core/image/flip.h"
#include "core/image/image.h"
#include "core/image/metrics.h"

namespace app {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t kTileSide = 8;

Json rgbJson(glm::dvec3 v)
{
    return Json::array({v.x, v.y, v.z});
}

/// Samples per pixel that the metadata name; 0 when they do not.
uint64_t samplesOf(const core::ImageFile& content)
{
    const auto found = content.metadata.find("spp");
    uint64_t samples = 0;
    if (found != content.metadata.end()) {
        const std::string& text = found->second;
        std::from_chars(text.data(), text.data() + text.size(), samples);
    }
    return samples;
}

/// Reasons why Welch's test understates differences here, as sentences.
Json reservations(const core::ImageFile& a, const core::ImageFile& b)
{
    const auto equal = [&](const char* key) {
        return a.metadata.count(key) && b.metadata.count(key) &&
               a.metadata.at(key) == b.metadata.at(key);
    };
    Json notes = Json::array();
    if (equal("scene_hash") && equal("seed"))
        notes.push_back("same scene and seed: the noise of both images is shared, z understates");
    if (usesSobol(a) || usesSobol(b))
        notes.push_back(
            "sampler sobol: the stored variances are upper bounds, z understates and p is "
            "not uniform");
    for (const core::ImageFile* file : {&a, &b})
        if (sharesLight(*file)) {
            notes.push_back("method " + file->metadata.at("method") +
                            ": the pixels share their light and err together, z exaggerates and "
                            "no p can be told");
            break;
        }
    return notes;
}

/// `independent`: pixels err each for itself, which every p takes for granted.
Json welchJson(const core::WelchResult& welch, bool independent, Json notes)
{
    Json json;
    Json& z = json["z"] = Json::array();
    for (const core::WelchScore& score : welch.image) z.push_back(score.z);
    json["detectable_bias"] = welch.detectableBias;
    json["tile_side"] = kTileSide;
    json["tiles"] = welch.tiles.size();
    json["largest_tile_z"] = welch.largestTileZ;
    if (independent) {
        json["smallest_p"] = welch.smallestP;
        json["uniform_p"] = welch.uniformP;
        json["p_histogram"] = welch.histogram;
    }
    if (!notes.empty()) json["notes"] = std::move(notes);
    return json;
}

/// Where both files have variances.
void addWelch(Json& json, const core::Image& image, const core::Image& reference,
              const core::ImageFile& imageFile, const core::ImageFile& referenceFile)
{
    const auto ofImage = rgbVarianceOf(imageFile), ofReference = rgbVarianceOf(referenceFile);
    if (!ofImage || !ofReference) return;
    const core::MeanAndVariance a{image, *ofImage, samplesOf(imageFile)};
    const core::MeanAndVariance b{reference, *ofReference, samplesOf(referenceFile)};
    const core::WelchResult welch = core::welchTest(a, b, kTileSide);
    double largest = 0;
    for (const core::WelchScore& score : welch.image)
        if (std::abs(score.z) > std::abs(largest)) largest = score.z;
    json["welch_z"] = largest;
    json["welch"] = welchJson(welch, !sharesLight(imageFile) && !sharesLight(referenceFile),
                              reservations(imageFile, referenceFile));
}

std::string sizeText(const core::Image& image)
{
    return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

int compareCommand(const std::filesystem::path& image, const std::filesystem::path& reference,
                   std::ostream& out)
{
    const core::ImageFile imageFile = core::readExr(image);
    const core::ImageFile referenceFile = core::readExr(reference);
    const core::Image a = rgbOf(imageFile, image), b = rgbOf(referenceFile, reference);
    if (a.width != b.width || a.height != b.height)
        throw core::Error(image.string() + " has " + sizeText(a) + " pixels, " +
                          reference.string() + " has " + sizeText(b) +
                          " — compare images of equal size");
    const core::ImageErrors errors = core::imageErrors(a, b);
    const core::FlipResult flip = core::flipHdr(a, b);
    Json json = {
        {"schema", 1},
        {"command", "compare"},
        {"image", image.string()},
        {"reference", reference.string()},
        {"size", {a.width, a.height}},
        {"rmse", errors.rmse},
        {"relmse", errors.relMse},
        {"mean_signed_error", errors.meanSignedError},
        {"flip", flip.mean},
        {"mean_image", rgbJson(errors.meanImage)},
        {"mean_reference", rgbJson(errors.meanReference)},
        {"non_finite_pixels", errors.nonFinitePixels},
        {"flip_exposures", {flip.exposures.start, flip.exposures.stop, flip.exposures.count}},
        {"formulas",
         {{"d", "image - reference"},
          {"r", "reference"},
          {"rmse", core::kRmseFormula},
          {"relmse", core::kRelMseFormula},
          {"mean_signed_error", core::kMeanSignedErrorFormula},
          {"flip", "mean of HDR-FLIP (Andersson et al. 2021), 67.02 pixels per degree, ACES"},
          {"reference_noise", "sqrt(mean(variance of the reference's mean))"},
          {"welch_z",
           "difference of the image means over its standard deviation, largest channel"}}}};
    if (const auto noise = storedNoise(referenceFile)) json["reference_noise"] = noise->rmse;
    addWelch(json, a, b, imageFile, referenceFile);
    // File names may hold any bytes; JSON is UTF-8.
    out << jsonText(json, 1) << '\n';
    return int(core::ExitCode::done);
}

}  // namespace app

// Choice of images and scales for the display kernel. See picture_view.h.
#include "app/view/picture_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace app {

namespace {

using ImagePointer = std::shared_ptr<const core::Image>;

/// A member of what `owner` points to, kept alive with it.
template <class Owner>
ImagePointer part(const std::shared_ptr<const Owner>& owner, const core::Image& image)
{
    return ImagePointer(owner, &image);
}

glm::vec4 corners(const Area& place)
{
    return {place.corner, place.size};
}

uint32_t mapOf(ColourMap map)
{
    switch (map) {
    case ColourMap::magma:
        return shared::kMapMagma;
    case ColourMap::grey:
        return shared::kMapGrey;
    default:
        return shared::kMapViridis;
    }
}

uint32_t errorOf(ErrorKind kind)
{
    switch (kind) {
    case ErrorKind::absolute:
        return shared::kErrorAbsolute;
    case ErrorKind::squared:
        return shared::kErrorSquared;
    default:
        return shared::kErrorRelative;
    }
}

const char* errorLabel(ErrorKind kind)
{
    switch (kind) {
    case ErrorKind::absolute:
        return "absolute error of luminance";
    case ErrorKind::squared:
        return "squared relative error of luminance";
    default:
        return "relative error of luminance";
    }
}

/// Smallest and largest positive value: the scale of depths and deviations.
std::pair<float, float> positiveRange(const core::Image& image)
{
    float low = 1e30f, high = 0;
    for (size_t i = 0; i < image.pixels.size(); i += image.channels) {
        const float value = image.pixels[i];
        if (!(value > 0) || !std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    return high > 0 ? std::pair(low, high) : std::pair(0.0f, 1.0f);
}

core::Image deviation(const core::Image& variance)
{
    core::Image result(variance.width, variance.height, 1);
    for (size_t i = 0; i < result.pixels.size(); ++i) {
        const float* v = &variance.pixels[i * variance.channels];
        // Channels of a sample rise and fall together: their deviations add up rather than their
        // variances.
        result.pixels[i] = 0.2126f * std::sqrt(std::max(v[0], 0.0f)) +
                           0.7152f * std::sqrt(std::max(v[1], 0.0f)) +
                           0.0722f * std::sqrt(std::max(v[2], 0.0f));
    }
    return result;
}

}  // namespace

DisplayInputs PictureView::inputs(const Session& session)
{
    DisplayInputs inputs{};  // also the settings, which have no values of their own
    scale_ = {};
    problem_.clear();
    const ViewParams& view = session.settings.view;
    shared::DisplaySettings& s = inputs.settings;
    s.show = shared::kShowRadiance;
    s.exposure = view.exposure;
    s.tone = static_cast<uint32_t>(view.tone);
    s.map = mapOf(view.map);
    s.errorKind = errorOf(view.errorKind);
    s.high = 1;
    s.slider = view.compareAt;

    const std::shared_ptr<const Picture> picture = session.picture();
    if (session.holdReference && session.reference()) {
        const core::Image& mean = session.reference()->mean;
        inputs.a = part(session.reference(), mean);
        inputs.places.a = corners(session.placeOf({mean.width, mean.height}));
        return inputs;
    }
    if (!picture) return inputs;
    inputs.a = part(picture, picture->mean);
    inputs.places.a = inputs.places.b = corners(session.placeOf(*picture));
    if (picture->shaded && !session.comparing) s.exposure = 0;
    if (picture->preview && picture->guide && !session.comparing && view.show == Show::color) {
        inputs.b = picture->guide;
        s.show = shared::kShowPreview;
    }
    if (session.comparing)
        showCompare(inputs, session, picture);
    else if (view.show >= Show::depth && view.show <= Show::emitter)
        showAov(inputs, view.show, *picture);
    else if (view.show == Show::samples || view.show == Show::deviation)
        showMap(inputs, session, *picture);
    else if (view.show == Show::methodMap)
        showMethodMap(inputs, session, *picture);
    else if (view.show != Show::color)
        showAgainst(inputs, session, *picture);
    return inputs;
}

void PictureView::showAov(DisplayInputs& inputs, Show show, const Picture& picture)
{
    if (!picture.aovs) {
        problem_ = "first hits are on their way";
        return;
    }
    const core::Aovs& aovs = *picture.aovs;
    shared::DisplaySettings& s = inputs.settings;
    switch (show) {
    case Show::depth: {
        inputs.a = part(picture.aovs, aovs.depth);
        s.show = shared::kShowDepth;
        const auto [low, high] = rangeOf(inputs.a);
        scale_ = {true, low, high, false, false, "distance (m); dark grey: nothing hit"};
        if (const auto world = picture.world.lock())
            scale_.unit = static_cast<float>(1 / world->placement.scale);
        break;
    }
    case Show::normal:
        inputs.a = part(picture.aovs, aovs.normal);
        s.show = shared::kShowDirection;
        break;
    case Show::albedo:
        inputs.a = part(picture.aovs, aovs.albedo);
        s.show = shared::kShowColour;
        break;
    default:
        inputs.a = part(picture.aovs, aovs.ids);
        s.show = shared::kShowId;
        s.channel = static_cast<uint32_t>(show) - static_cast<uint32_t>(Show::triangle);
    }
    s.low = scale_.low;
    s.high = scale_.high;
}

/// positiveRange(), of every image once.
std::pair<float, float> PictureView::rangeOf(const ImagePointer& image)
{
    if (image != ranged_) range_ = positiveRange(*image);
    ranged_ = image;
    return range_;
}

/// The image of a view that is computed here.
PictureView::ImagePointer PictureView::derived(Show show, const Picture& picture)
{
    if (of_.get() == &picture && derivedShow_ == show && derived_) return derived_;
    if (show == Show::samples) {
        // Every pixel has as many: one says it.
        auto image = std::make_shared<core::Image>(1, 1, 1);
        image->pixels[0] = static_cast<float>(picture.samples);
        return image;
    }
    return std::make_shared<const core::Image>(deviation(*picture.variance));
}

void PictureView::showMap(DisplayInputs& inputs, const Session& session, const Picture& picture)
{
    const Show show = session.settings.view.show;
    if (show == Show::deviation && (!picture.variance || picture.samples < 2)) {
        problem_ = picture.samples < 2 ? "one sample says nothing about its spread"
                                       : "the variance is on its way";
        return;
    }
    derived_ = derived(show, picture);
    derivedShow_ = show;
    of_ = session.picture();
    inputs.a = derived_;
    shared::DisplaySettings& s = inputs.settings;
    s.show = shared::kShowScalar;
    if (show == Show::samples) {
        scale_ = {true,  0,     std::max(static_cast<float>(picture.samples), 1.0f),
                  false, false, "samples per pixel",
                  true};
    } else {
        // Four decades below the largest are enough: deeper ones are pixels without light.
        const float high = rangeOf(derived_).second;
        scale_ = {true, high * 1e-4f, high, true, false, "standard deviation of each pixel"};
    }
    s.low = scale_.low;
    s.high = scale_.high;
    s.logarithmic = scale_.logarithmic ? 1 : 0;
}

void PictureView::showMethodMap(DisplayInputs& inputs, const Session& session,
                                const Picture& picture)
{
    const core::MethodInfo& method = core::methodNamed(picture.params.method.id());
    if (method.maps.empty()) {
        problem_ = "the method '" + std::string(method.id()) + "' has no maps of its own";
        return;
    }
    const size_t index = std::min(size_t(session.settings.view.methodMap), method.maps.size() - 1);
    if (!picture.maps || picture.maps->size() <= index) {
        problem_ = "the map is on its way";
        return;
    }
    const core::Image& map = (*picture.maps)[index];
    inputs.a = part(picture.maps, map);
    shared::DisplaySettings& s = inputs.settings;
    s.show = shared::kShowScalar;
    const core::MapInfo& info = method.maps[index];
    const float high = info.high > 0 ? info.high : std::max(rangeOf(inputs.a).second, 1e-6f);
    scale_ = {true, 0, high, false, false, std::string(info.name) + ": " + info.help};
    s.low = scale_.low;
    s.high = scale_.high;
}

void PictureView::showAgainst(DisplayInputs& inputs, const Session& session, const Picture& picture)
{
    const std::shared_ptr<const Reference> reference = session.reference();
    if (!reference) {
        problem_ = "there is no reference: B renders one in the background";
        return;
    }
    if (!session.referenceFits()) {
        problem_ = "the reference shows another view: B renders a new one";
        return;
    }
    if (picture.preview) return;
    const ViewParams& view = session.settings.view;
    if (view.show == Show::flip) return showFlip(inputs, session);
    inputs.b = part(reference, reference->mean);
    const bool difference = view.show == Show::difference;
    inputs.settings.show = difference ? shared::kShowDifference : shared::kShowError;
    inputs.settings.high = view.errorRange;
    scale_ = {true,
              difference ? -view.errorRange : 0,
              view.errorRange,
              false,
              difference,
              difference ? "picture - reference (radiance)" : errorLabel(view.errorKind)};
}

void PictureView::showFlip(DisplayInputs& inputs, const Session& session)
{
    const std::shared_ptr<const FlipMap> flip = session.flip();
    if (!flip) {
        problem_ = "FLIP is on its way";
        return;
    }
    inputs.a = part(flip, flip->map);
    inputs.settings.show = shared::kShowScalar;
    inputs.settings.low = 0;
    inputs.settings.high = 1;
    inputs.settings.logarithmic = 0;
    char label[96];
    std::snprintf(label, sizeof label, "FLIP against the reference at %llu spp: mean %.3g",
                  static_cast<unsigned long long>(flip->picture->samples), flip->mean);
    scale_ = {true, 0, 1, false, false, label};
}

void PictureView::showCompare(DisplayInputs& inputs, const Session& session,
                              const std::shared_ptr<const Picture>& live)
{
    const auto side = [&](size_t i, ImagePointer& image, glm::vec4& place) {
        const std::shared_ptr<const Picture>& stored = session.slots[i].picture;
        const std::shared_ptr<const Picture>& picture = stored ? stored : live;
        image = part(picture, picture->mean);
        place = corners(session.placeOf(*picture));
    };
    side(0, inputs.a, inputs.places.a);
    side(1, inputs.b, inputs.places.b);
    inputs.settings.show = shared::kShowCompare;
    if (!session.slots[0].picture && !session.slots[1].picture)
        problem_ = "both sides are the live picture: [ keeps it as A, ] as B";
}

}  // namespace app

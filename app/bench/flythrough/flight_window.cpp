// See flight_window.h.
#include "app/bench/flythrough/flight_window.h"

#include "core/base/check.h"
#include "core/base/time.h"
#include "core/image/display.h"

namespace app::flight {

WindowPilot::WindowPilot(const SceneOptions& scene, const Target& target, glm::uvec2 size,
                         std::stop_token stop)
    : size_(size), loop_(scene, target, core::ReuseParams{}, size, std::move(stop))
{}

/// The camera stands where the flight ends; what is on its way still shows the views before. It
/// counts as moving until the picture is there, however long a machine under load takes. The
/// picture is taken before it gets a second sample, which would lie anywhere in its pixel.
bool WindowPilot::land(WindowLanding& landing)
{
    Session& session = loop_.session();
    const core::Camera end = session.navigation.camera();
    const auto there = [&] {
        session.moved();
        return session.picture()->camera == end;
    };
    if (!loop_.wait(there, true)) return false;
    const Picture& picture = *session.picture();
    CHECK(picture.preview);
    landing.picture = core::stretched(picture.mean, size_);
    landing.size = sampledSize(picture);
    landing.fineSize = {picture.mean.width, picture.mean.height};
    landing.guide = picture.guide;
    landing.colours = displayColours(picture.mean, picture.guide.get(), size_);
    return true;
}

std::optional<WindowLanding> WindowPilot::fly(const CameraTrack& track,
                                              const core::ReuseParams& params, double frameSeconds)
{
    CHECK(track.keys().size() >= 2);
    loop_.wantPictures(frameSeconds);
    if (!loop_.begin(track, params, [](const Picture&) { return true; })) return {};
    WindowLanding landing;
    Session& session = loop_.session();
    std::shared_ptr<const Picture> shown = session.picture();
    double scales = 0, fineScales = 0;
    const core::Clock::time_point start = core::Clock::now();
    const double begun = loop_.now();
    session.track.play();
    const bool flown = loop_.wait([&] {
        if (session.picture() != shown) {
            shown = session.picture();
            scales += double(sampledSize(*shown).x) / size_.x;
            fineScales += double(shown->mean.width) / size_.x;
            ++landing.pictures;
        }
        return !session.track.playing();
    });
    // Pictures that are waited for from now on are not counted.
    landing.seconds = loop_.now() - begun;
    landing.share = landing.seconds / core::secondsSince(start);
    landing.scale = scales / std::max(landing.pictures, 1u);
    landing.fineScale = fineScales / std::max(landing.pictures, 1u);
    if (!flown) return {};
    landing.underWay = displayColours(shown->mean, shown->guide.get(), size_);
    if (!land(landing)) return {};
    return landing;
}

core::Image displayColours(const core::Image& picture, const core::Image* guide, glm::uvec2 size)
{
    shared::DisplaySettings s{};
    s.width = size.x;
    s.height = size.y;
    s.show = guide ? shared::kShowPreview : shared::kShowRadiance;
    s.exposure = ViewParams{}.exposure;
    s.tone = static_cast<uint32_t>(ViewParams{}.tone);
    const std::vector<uint8_t> bytes = core::displayImage(&picture, guide, s);
    core::Image colours(size.x, size.y, 3);
    for (size_t i = 0; i < size_t(size.x) * size.y; ++i)
        for (size_t c = 0; c < 3; ++c)
            colours.pixels[3 * i + c] = static_cast<float>(bytes[4 * i + c]) / 255;
    return colours;
}

}  // namespace app::flight

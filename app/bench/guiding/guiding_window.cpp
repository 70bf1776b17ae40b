// See guiding_window.h.
#include "app/bench/guiding/guiding_window.h"

#include <utility>

#include "app/session/session.h"

namespace app::guiding {

namespace {

constexpr double kPictureSeconds = 1.0 / 30;  // wanted while the camera moves

}  // namespace

WindowArrivals::WindowArrivals(const SceneOptions& scene, const Target& target,
                               const core::AnyParams& params, glm::uvec2 size, CameraTrack track,
                               std::stop_token stop)
    : loop_(scene, target, params, size, std::move(stop)), track_(std::move(track))
{
    loop_.wantPictures(kPictureSeconds);
}

std::optional<core::Image> WindowArrivals::arrive(const core::AnyParams& params, uint32_t before)
{
    Session& session = loop_.session();
    session.render.sppLimit = 0;
    const auto learnt = [&](const Picture& picture) {
        return !picture.preview && picture.samples >= before;
    };
    if (!loop_.begin(track_, params, learnt)) return {};
    // Of a camera that moves every picture is shown all the same.
    session.render.sppLimit = 1;
    session.track.play();
    if (!loop_.wait([&] { return !session.track.playing(); })) return {};
    const core::Camera end = session.navigation.camera();
    const auto rests = [&] {
        const Picture& picture = *session.picture();
        return picture.camera == end && !picture.preview && picture.samples > 0;
    };
    if (!loop_.wait(rests)) return {};
    return session.picture()->mean;
}

}  // namespace app::guiding

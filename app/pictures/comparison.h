// Two pictures side by side: stored or live, and stored after equal times of rendering.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/pictures/picture.h"

namespace app {

/// One side of the slider. Without a picture it is live: whatever is being rendered.
struct Slot {
    std::shared_ptr<const Picture> picture;
    std::string label;
    double time = 0;  // of the scene's animation, that it shows
};

/// Renders A's parameters for `seconds`, stores, then B's, stores. Driven by whoever renders: ask
/// `wanted()` what to render now, show it every new picture, and start the picture anew after
/// start() and after every slot that offer() returns (A and B may be equal, or equal to what is on
/// show: a picture that went on would have had more time).
class EqualTime {
public:
    /// `newest`: the generation of the newest order until now; pictures up to it are none of ours.
    void start(const RenderParams& a, const RenderParams& b, double seconds, uint64_t newest = 0);
    void cancel();
    bool running() const { return stage_ == Stage::first || stage_ == Stage::second; }
    double seconds() const { return seconds_; }
    int side() const { return stage_ == Stage::second ? 1 : 0; }
    double fraction() const { return fraction_; }  // of the side that runs

    /// The parameters to render now (limits set to the time), while running.
    const RenderParams& wanted() const;

    /// A picture for wanted(); the side's slot when its time is up. Pictures of other parameters
    /// and previews are ignored; a side ends with the first picture of at least its time.
    std::optional<Slot> offer(const std::shared_ptr<const Picture>& picture);

private:
    enum class Stage { none, first, second } stage_ = Stage::none;
    std::array<RenderParams, 2> params_;
    double seconds_ = 0, fraction_ = 0;
    // Pictures of this generation and older were ordered before the side began
    uint64_t before_ = 0;
};

/// A parameter that two sides do not have in common, as text; "-" where a method has none of that
/// name.
struct ParamDifference {
    std::string name, a, b;
};
/// Device, method and its parameters; not the limits, which equal time replaces. In the order of
/// the lists.
std::vector<ParamDifference> differences(const RenderParams& a, const RenderParams& b);

/// "path, vulkan, depth 8", and every other parameter that is not at its default.
std::string paramsLabel(const RenderParams& params);

/// "path, vulkan, depth 8, 64 spp, 2.0 s": what distinguishes a picture from another.
std::string pictureLabel(const Picture& picture);

}  // namespace app

// What of the session's pictures is on display: which images, read how. Values of maps and their
// scales are computed once per picture.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "app/session/session.h"
#include "app/view/gui.h"
#include "app/view/ui/scale.h"

namespace app {

class PictureView {
public:
    /// The inputs of the display kernel for what the session shows now; images that did not change
    /// keep their pointers. Without a picture `a` is empty. Where the area lies in the window is
    /// left to the caller.
    DisplayInputs inputs(const Session& session);

    /// Of the last inputs().
    const Scale& scale() const { return scale_; }

    /// Why the view that was asked for is not what is shown ("no reference yet: B starts one");
    /// empty when it is.
    const std::string& problem() const { return problem_; }

private:
    using ImagePointer = std::shared_ptr<const core::Image>;

    void showMap(DisplayInputs& inputs, const Session& session, const Picture& picture);
    void showMethodMap(DisplayInputs& inputs, const Session& session, const Picture& picture);
    void showAov(DisplayInputs& inputs, Show show, const Picture& picture);
    void showAgainst(DisplayInputs& inputs, const Session& session, const Picture& picture);
    void showFlip(DisplayInputs& inputs, const Session& session);
    void showCompare(DisplayInputs& inputs, const Session& session,
                     const std::shared_ptr<const Picture>& live);
    ImagePointer derived(Show show, const Picture& picture);
    std::pair<float, float> rangeOf(const ImagePointer& image);

    Scale scale_;
    std::string problem_;
    std::shared_ptr<const Picture> of_;  // of the derived image
    Show derivedShow_ = Show::color;
    ImagePointer derived_;
    ImagePointer ranged_;  // the image whose range is known
    std::pair<float, float> range_{0, 1};
};

}  // namespace app

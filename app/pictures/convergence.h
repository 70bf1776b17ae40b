// Curves of error over time: those of pictures past are kept beside that of the present one; slope
// and time to a wanted error come from the curve itself.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/pictures/picture.h"

namespace app {

/// What a curve is of: curves of other scenes or cameras cannot be compared with it.
struct CurveView {
    std::string scene;  // tells scenes and their instants apart
    core::Camera camera;
    glm::uvec2 size{0};

    friend bool operator==(const CurveView&, const CurveView&) = default;
};

struct Curve {
    CurveView view;
    std::string label;
    std::vector<ErrorPoint> points;
    bool against = false;  // whether the last point has an RMSE against a reference
};

/// A fit log e = a + slope * log t over the last points (those of the last factor of 16 in time,
/// where there are three), by generalised least squares: see convergence.cpp for what it takes the
/// noise of a curve to be.
struct Fit {
    double slope = -0.5, slopeSe = 0;
    double at1 = 0;  // the error at one second
    int points = 0;  // Student's degrees of freedom of the slope are two fewer
};
/// At least three points over a factor of 1.5 in time, else none. `against`: fits rmse, else
/// `estimated`.
std::optional<Fit> fitCurve(const std::vector<ErrorPoint>& points, bool against);

/// Seconds of rendering still needed, and the interval in which they are with about 68 %
/// probability: from the slope's own standard error. `high` may be infinite.
struct Eta {
    double seconds = 0, low = 0, high = 0;
};
/// Until the error is `target`: from the last point along the fitted slope (held within [-1,
/// -0.25]). None when unknown, 0 when reached. With a noisy reference the error levels off at
/// `referenceNoise`: targets below it are never reached, which is none, too.
std::optional<Eta> etaToError(const std::vector<ErrorPoint>& points, bool against, double target,
                              double referenceNoise);

/// Root of the mean variance of the reference's mean; 0 when unknown. It reads every pixel: whoever
/// makes a reference keeps it there.
double referenceNoise(const Reference& reference);

class Convergence {
public:
    /// Every new picture; previews are ignored. A picture that starts anew moves the present curve
    /// to the past ones, if it has at least four points. `scene` tells scenes and their instants
    /// apart.
    void take(const Picture& picture, const std::string& scene);
    const Curve& present() const { return present_; }
    /// Those of the present one's view, newest last, at most eight. Who comes back to a view finds
    /// its curves again; eight views' worth are kept.
    const std::vector<Curve>& past() const { return past_; }
    void clearPast();  // of the present view

private:
    bool continues(const Picture& picture, const CurveView& view) const;
    void keepPresent();
    void recall();

    Curve present_;
    std::vector<Curve> past_;   // of the present view
    std::vector<Curve> other_;  // of other views, newest last
    RenderParams params_;       // of the present curve
    uint64_t samples_ = 0;
    double seconds_ = 0;
};

}  // namespace app

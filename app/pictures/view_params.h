// Settings of the window, described once: the panel, the settings file and scripts are visitors of
// these lists.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "app/args/args.h"
#include "core/base/params.h"

namespace app {

/// What the picture area shows. The order is that of the keys 1 to 9, 0 and on.
enum class Show : uint32_t {
    color,
    depth,
    normal,
    albedo,
    triangle,
    material,
    emitter,
    samples,
    deviation,
    difference,
    error,
    flip,
    methodMap
};

enum class ColourMap : uint32_t { viridis, magma, grey };

/// How an error becomes a number: |d|, |d| / (r + 0.01), d^2 / (r^2 + 0.01) with luminances d =
/// image - reference, r.
enum class ErrorKind : uint32_t { absolute, relative, squared };

/// What a moving camera shows: paths as they come, paths with what first hits tell where no light
/// has come, or first hits alone, lit from the camera.
enum class Moving : uint32_t { path, filled, shaded };

/// What the wheel goes towards.
enum class Wheel : uint32_t { cursor, pivot };

/// What the camera does at surfaces when it is dragged or the wheel leads it away.
enum class Walls : uint32_t { stop, pass };

/// The edge of the window that the panel stands at.
enum class PanelSide : uint32_t { left, right };

/// Whether the panel gives its place to the picture. `automatic`: in narrow windows.
enum class PanelFold : uint32_t { automatic, open, folded };

}  // namespace app

namespace core {
template <> struct EnumNames<app::Moving> {
    static constexpr std::array<std::string_view, 3> names{"path", "filled", "shaded"};
};
template <> struct EnumNames<app::Wheel> {
    static constexpr std::array<std::string_view, 2> names{"cursor", "pivot"};
};
template <> struct EnumNames<app::Walls> {
    static constexpr std::array<std::string_view, 2> names{"stop", "pass"};
};
template <> struct EnumNames<app::PanelSide> {
    static constexpr std::array<std::string_view, 2> names{"left", "right"};
};
template <> struct EnumNames<app::PanelFold> {
    static constexpr std::array<std::string_view, 3> names{"automatic", "open", "folded"};
};
template <> struct EnumNames<app::Show> {
    static constexpr std::array<std::string_view, 13> names{
        "color",   "depth",     "normal",     "albedo", "triangle", "material",  "emitter",
        "samples", "deviation", "difference", "error",  "flip",     "method-map"};
};
template <> struct EnumNames<app::ColourMap> {
    static constexpr std::array<std::string_view, 3> names{"viridis", "magma", "grey"};
};
template <> struct EnumNames<app::ErrorKind> {
    static constexpr std::array<std::string_view, 3> names{"absolute", "relative", "squared"};
};
}  // namespace core

namespace app {

/// How the picture is looked at: none of these restarts it, but for `pictureScale`.
struct ViewParams {
    Show show = Show::color;
    uint32_t methodMap = 0;
    float exposure = 0;
    Tone tone = Tone::agx;
    ColourMap map = ColourMap::viridis;
    ErrorKind errorKind = ErrorKind::relative;
    float errorRange = 0.5f;
    float compareAt = 0.5f;
    float pictureScale = 1;
    float frameLimit = 60;
    float movingRate = 30;
    uint32_t movingDepth = 3;
    Moving moving = Moving::filled;
    bool movingDetail = true;
    Wheel wheel = Wheel::cursor;
    Walls walls = Walls::stop;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        using core::Field;
        v(Field{"show", "the picture, first hits, sample counts, standard deviation, or error "
                        "against the reference, as it is or as FLIP says that it is seen, or a "
                        "map of the method's own"},
          p.show);
        v(Field{"method-map", "which of the method's maps, from 0", {0, 63}}, p.methodMap);
        v(Field{"exposure", "brightness of the display in stops", {-20, 20}}, p.exposure);
        v(Field{"tone", "curve from radiance to the display; linear clips"}, p.tone);
        v(Field{"map", "colours of maps; all but grey rise evenly in lightness and suit "
                       "colour-blind eyes"},
          p.map);
        v(Field{"error-kind",
                "absolute, relative to the reference, or squared relative (as relMSE)"},
          p.errorKind);
        v(Field{"error-range", "error at the upper end of the colours", {1e-4, 100, true}},
          p.errorRange);
        v(Field{"compare-at", "place of the compare slider, from left to right", {0, 1}},
          p.compareAt);
        v(Field{"picture-scale", "pixels rendered per pixel of the window, along a side", {0.1, 2}},
          p.pictureScale);
        v(Field{"frame-limit", "frames of the window per second, at most", {5, 240}}, p.frameLimit);
        v(Field{"moving-rate",
                "pictures per second wanted while the camera moves; fewer pixels are the price",
                {1, 120}},
          p.movingRate);
        v(Field{"moving-depth",
                "scattering events per path while the camera moves, at most",
                {0, 64}},
          p.movingDepth);
        v(Field{"moving", "while the camera moves: path shows the light that has come, filled also "
                          "surfaces that have none yet, shaded first hits alone, lit from the "
                          "camera: finer, without noise, without light. The method reuse keeps its "
                          "samples meanwhile"},
          p.moving);
        v(Field{"moving-detail",
                "what is seen directly in pictures of a moving camera (edges, textures, lamps) has "
                "more pixels than light; not where moving shows paths or first hits alone"},
          p.movingDetail);
        v(Field{"wheel", "the wheel goes towards what is under the cursor, or towards the point "
                         "that the view turns about"},
          p.wheel);
        v(Field{"walls", "what is dragged, or led back by the wheel, stops before a wall and turns "
                         "on the spot, or passes through it. Flying (G) always passes"},
          p.walls);
    }
    friend bool operator==(const ViewParams&, const ViewParams&) = default;
};

/// What a view shows, in words; for a method's own map its name is better.
constexpr std::string_view captionOf(Show show)
{
    constexpr std::array<std::string_view, 13> captions{"the picture",
                                                        "distances of first hits",
                                                        "shading normals of first hits",
                                                        "reflectances of first hits",
                                                        "triangles",
                                                        "materials",
                                                        "emitters",
                                                        "samples per pixel",
                                                        "standard deviation of each pixel",
                                                        "difference from the reference",
                                                        "error against the reference",
                                                        "what a viewer sees of the error: FLIP",
                                                        "a map of the method"};
    static_assert(captions.size() == core::EnumNames<Show>::names.size());
    return captions[static_cast<size_t>(show)];
}

/// What is open in the window, and where the panel stands.
struct PanelParams {
    bool panel = true, help = false, log = false, plot = true, profiler = false;
    PanelSide side = PanelSide::left;
    PanelFold fold = PanelFold::automatic;
    float width = 0;
    float uiScale = 0;
    float opacity = 0.96f;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        using core::Field;
        v(Field{"panel", "the panel and everything that belongs to it"}, p.panel);
        v(Field{"help", "the list of keys"}, p.help);
        v(Field{"log", "messages, newest last"}, p.log);
        v(Field{"plot", "error over time"}, p.plot);
        v(Field{"profiler", "times, rays and memory"}, p.profiler);
        v(Field{"panel-side", "edge of the window that the panel stands at"}, p.side);
        v(Field{"panel-fold",
                "open beside the picture, or folded away; automatic folds it in narrow windows"},
          p.fold);
        v(Field{"panel-width", "of the panel, in heights of a letter; 0 is the usual", {0, 400}},
          p.width);
        v(Field{"ui-scale", "size of the letters; 0 follows the display", {0, 4}}, p.uiScale);
        v(Field{"opacity", "of windows that lie over the picture", {0.3, 1}}, p.opacity);
    }
    friend bool operator==(const PanelParams&, const PanelParams&) = default;
};

/// Which sections of the panel are unfolded.
struct SectionParams {
    bool scene = true, method = true, view = true, camera = false, animation = true, path = false;
    bool compare = false, reference = false, limits = false, save = false;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        using core::Field;
        v(Field{"section-scene", "what is loaded"}, p.scene);
        v(Field{"section-method", "how light is found"}, p.method);
        v(Field{"section-view", "how the picture is looked at"}, p.view);
        v(Field{"section-camera", "cameras and the lens"}, p.camera);
        v(Field{"section-animation", "time of the scene's animation"}, p.animation);
        v(Field{"section-path", "the camera path"}, p.path);
        v(Field{"section-compare", "two pictures side by side"}, p.compare);
        v(Field{"section-reference", "what errors are measured against"}, p.reference);
        v(Field{"section-limits", "when the picture is finished"}, p.limits);
        v(Field{"section-save", "pictures as files"}, p.save);
    }
    friend bool operator==(const SectionParams&, const SectionParams&) = default;
};

}  // namespace app

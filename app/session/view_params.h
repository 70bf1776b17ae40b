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
    methodMap
};

enum class ColourMap : uint32_t { viridis, magma, grey };

/// How an error becomes a number: |d|, |d| / (r + 0.01), d^2 / (r^2 + 0.01) with luminances d =
/// image - reference, r.
enum class ErrorKind : uint32_t { absolute, relative, squared };

}  // namespace app

namespace core {
template <> struct EnumNames<app::Show> {
    static constexpr std::array<std::string_view, 12> names{
        "color",   "depth",   "normal",    "albedo",     "triangle", "material",
        "emitter", "samples", "deviation", "difference", "error",    "method-map"};
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

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        using core::Field;
        v(Field{"show", "the picture, first hits, sample counts, standard deviation, or error "
                        "against the reference, or a map of the method's own"},
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
    }
    friend bool operator==(const ViewParams&, const ViewParams&) = default;
};

/// What is open in the window.
struct PanelParams {
    bool panel = true, help = false, log = false, plot = true, profiler = false;
    float uiScale = 0;
    float opacity = 0.92f;

    template <class Self, class V> static void visit(Self& p, V&& v)
    {
        using core::Field;
        v(Field{"panel", "the panel and everything that belongs to it"}, p.panel);
        v(Field{"help", "the list of keys"}, p.help);
        v(Field{"log", "messages, newest last"}, p.log);
        v(Field{"plot", "error over time"}, p.plot);
        v(Field{"profiler", "times, rays and memory"}, p.profiler);
        v(Field{"ui-scale", "size of the letters; 0 follows the display", {0, 4}}, p.uiScale);
        v(Field{"opacity", "of the panel", {0.3, 1}}, p.opacity);
    }
    friend bool operator==(const PanelParams&, const PanelParams&) = default;
};

}  // namespace app

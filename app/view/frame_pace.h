// Which frames of the window are worth drawing while the camera moves.
#pragma once

namespace app {

/// What a frame has to show, beside the camera's motion, which only a new picture shows.
struct FrameNews {
    bool picture = false;  // another one than the last frame's
    bool panel = false;    // something in it is held, or the frame is asked for
    bool layout = false;   // the window or its parts have other sizes
};

/// Whether a frame is drawn in which the camera moves: at once when it has something to show, else
/// when what it costs (`drawSeconds`) leaves the larger part of the time since the last one to
/// pictures, of which a software device draws more then.
constexpr bool isWorthDrawing(const FrameNews& news, double sinceDraw, double drawSeconds)
{
    constexpr double kShare = 3;
    return news.picture || news.panel || news.layout || sinceDraw > kShare * drawSeconds;
}

}  // namespace app

// What is measured of pictures at more cost than a frame of the window may have: the comparison of
// A with B, and the map of FLIP. One thread, the newest pictures only.
#pragma once

#include <memory>

#include "app/pictures/picture.h"
#include "app/pictures/picture_comparison.h"
#include "core/base/worker.h"

namespace app {

/// What is to be measured; each part may be empty.
struct Judged {
    std::shared_ptr<const Picture> a, b;             // to be compared, both or neither
    std::shared_ptr<const Reference> reference;      // that A and B are compared against, or none
    std::shared_ptr<const Picture> seen;             // whose FLIP is on show
    std::shared_ptr<const Reference> seenReference;  // against this one
};

/// FLIP of a picture against a reference (core/image/flip.h).
struct FlipMap {
    std::shared_ptr<const Picture> picture;
    std::shared_ptr<const Reference> reference;
    core::Image map;  // one channel, in [0, 1]
    double mean = 0;
};

class PictureJudge {
public:
    PictureJudge();

    /// Once per frame: starts what is not measured yet, one after the other. Never blocks.
    void update(const Judged& wanted);

    /// Of the pictures last wanted; null until it is there, and without pictures.
    std::shared_ptr<const PictureComparison> comparison() const;

    /// The newest of the view that was last wanted; its picture may be one or two older.
    std::shared_ptr<const FlipMap> flip() const;

    bool busy() const { return worker_.status().active(); }

private:
    struct Compared {
        Judged of;
        PictureComparison comparison;
    };
    void compare();
    void judge();

    Judged wanted_, started_;
    std::shared_ptr<core::Mailbox<Compared>> compared_;
    std::shared_ptr<core::Mailbox<FlipMap>> flips_;
    core::Worker worker_;  // last: ends before what its jobs look at
};

}  // namespace app

// Jobs that measure pictures. See picture_judge.h.
#include "app/pictures/picture_judge.h"

#include "core/base/parallel.h"
#include "core/image/flip.h"

namespace app {
namespace {

bool samePair(const Judged& x, const Judged& y)
{
    return x.a == y.a && x.b == y.b && x.reference == y.reference;
}

TimedPicture timedPicture(const Picture& picture)
{
    return {picture.mean, picture.variance.get(), picture.samples, picture.seconds};
}

PictureComparison compared(const Judged& of)
{
    if (oneView(*of.a, *of.b))
        return comparePictures(timedPicture(*of.a), timedPicture(*of.b), of.reference.get());
    PictureComparison comparison;
    comparison.whyNot = "A and B show different views";
    return comparison;
}

}  // namespace

PictureJudge::PictureJudge()
    : compared_(std::make_shared<core::Mailbox<Compared>>()),
      flips_(std::make_shared<core::Mailbox<FlipMap>>()), worker_("judge", 10)
{}

void PictureJudge::update(const Judged& wanted)
{
    wanted_ = wanted;
    if (!wanted_.a && started_.a) {  // nobody looks at what is large
        started_.a = started_.b = nullptr;
        compared_ = std::make_shared<core::Mailbox<Compared>>();
    }
    if (!wanted_.seen && started_.seen) {
        started_.seen = nullptr;
        flips_ = std::make_shared<core::Mailbox<FlipMap>>();
    }
    if (busy()) return;
    if (wanted_.a && wanted_.b && !samePair(wanted_, started_))
        compare();
    else if (wanted_.seen && wanted_.seenReference &&
             (wanted_.seen != started_.seen || wanted_.seenReference != started_.seenReference))
        judge();
}

void PictureJudge::compare()
{
    started_.a = wanted_.a;
    started_.b = wanted_.b;
    started_.reference = wanted_.reference;
    worker_.start("compare", [of = wanted_, box = compared_](core::JobContext& job) {
        core::runLast([&] {
            box->publish(job.generation(),
                         std::make_shared<const Compared>(Compared{of, compared(of)}));
        });
    });
}

void PictureJudge::judge()
{
    started_.seen = wanted_.seen;
    started_.seenReference = wanted_.seenReference;
    worker_.start("FLIP", [picture = wanted_.seen, reference = wanted_.seenReference,
                           box = flips_](core::JobContext& job) {
        core::runLast([&] {
            core::FlipResult flip = core::flipHdr(picture->mean, reference->mean,
                                                  core::kFlipPixelsPerDegree, job.stop());
            if (job.stopped()) return;
            box->publish(job.generation(),
                         std::make_shared<const FlipMap>(
                             FlipMap{picture, reference, std::move(flip.map), flip.mean}));
        });
    });
}

std::shared_ptr<const PictureComparison> PictureJudge::comparison() const
{
    const std::shared_ptr<const Compared> newest = compared_->newest();
    if (!newest || !wanted_.a || !wanted_.b || !samePair(newest->of, wanted_)) return nullptr;
    return {newest, &newest->comparison};
}

std::shared_ptr<const FlipMap> PictureJudge::flip() const
{
    const std::shared_ptr<const FlipMap> newest = flips_->newest();
    const bool fits =
        newest && wanted_.seen && wanted_.seenReference && oneView(*newest->picture, *wanted_.seen);
    return fits ? newest : nullptr;
}

}  // namespace app

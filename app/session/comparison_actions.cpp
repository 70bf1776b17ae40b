// Equal time, the parameters of its sides, what comes out of it, and references. See
// comparison_actions.h.
#include "app/session/comparison_actions.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "app/session/action_arguments.h"
#include "app/session/set_param.h"

namespace app {

using Json = nlohmann::ordered_json;

namespace {

/// The parameters of the picture with `changes` ({"device": ..., "max-depth": ...}) made to them.
RenderParams changed(const Session& session, const Json& changes)
{
    RenderParams params = session.render;
    if (changes.is_null()) return params;
    if (!changes.is_object()) refuse("a, b", "objects of parameters");
    const std::string unknown = setRenderParams(params, changes);
    if (!unknown.empty()) throw unknownParam(unknown, renderParamNames(params));
    return params;
}

}  // namespace

void chooseParamsAction(const ActionContext& c, size_t side)
{
    const auto found = c.arguments.find("params");
    c.session.chosenParams[side] =
        found == c.arguments.end() ? c.session.render : changed(c.session, *found);
}

void useParamsAction(const ActionContext& c)
{
    const std::string side = text(c, "side");
    if (side != "a" && side != "b") refuse("side", "\"a\" or \"b\"");
    const RenderParams params = c.session.sideParams(side == "a" ? 0 : 1);
    c.session.chooseParams(params.method);
    c.session.render.device = params.device;
    c.session.render.deviceIndex = params.deviceIndex;
}

void copyComparisonAction(const ActionContext& c)
{
    const auto comparison = c.session.comparison();
    const auto &a = c.session.slots[0].picture, &b = c.session.slots[1].picture;
    if (comparison && a && b) {
        c.app.toClipboard =
            comparisonText(*comparison, {paramsLabel(a->params), paramsLabel(b->params)});
        c.session.notices.tell(Severity::news, "the errors of A and B are in the clipboard");
    } else {
        c.session.notices.tell(Severity::news, "there are no two pictures to compare: [ and ] keep "
                                               "one as A and one as B");
    }
}

void equalTimeAction(const ActionContext& c)
{
    const double seconds = number(c, "seconds", 5);
    if (!(seconds > 0 && seconds <= 86400)) refuse("seconds", "a time from 0 to 86400");
    const Json none;
    const auto side = [&](const char* name) -> const Json& {
        const auto found = c.arguments.find(name);
        return found == c.arguments.end() ? none : *found;
    };
    const auto params = [&](const char* name, size_t i) {
        return side(name).is_null() ? c.session.sideParams(i) : changed(c.session, side(name));
    };
    const RenderParams a = params("a", 0), b = params("b", 1);
    c.session.compareEqualTime(a, b, seconds);
}

void referenceAction(const ActionContext& c)
{
    const auto samples = count(c, "spp", static_cast<double>(c.session.referenceSamples));
    c.session.startReference(std::max(samples, 2u), text(c, "method", c.session.referenceMethod));
}

}  // namespace app

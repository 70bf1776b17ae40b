// The actions that compare A with B and with a reference, of the table in actions.cpp.
#pragma once

#include "app/session/actions.h"

namespace app {

/// "params": changes to the panel's parameters, or nothing. `side`: 0 or 1.
void chooseParamsAction(const ActionContext& c, size_t side);
void useParamsAction(const ActionContext& c);
void equalTimeAction(const ActionContext& c);
void copyComparisonAction(const ActionContext& c);
void referenceAction(const ActionContext& c);

}  // namespace app

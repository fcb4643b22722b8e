// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/verlet_step.h"

namespace limber {

/// stepVerlet for bodies that links, contacts or joints couple. Their dampers and volume terms must be
/// prepared. A body gives the same bits as by itself where nothing is between them.
void stepLinked(StepGroup& group, double tick, int substeps);

}  // namespace limber

// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/row_query.h"

namespace limber::bench {

/// Returns Limber's targets and results, with "hit" or "MISS". Targets without rows are left out.
std::string targetTable(const Rows& rows);

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include "accuracy/row_query.h"

namespace limber::bench {

/// What Limber is to reach, what it does reach, and "hit" or "MISS". Targets without rows are left out.
std::string targetTable(const Rows& rows);

}  // namespace limber::bench

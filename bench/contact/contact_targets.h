// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_row.h"

namespace limber::bench {

/// Returns a line for each target and each of Limber's settings: hit, MISS, or "-" if not measured.
std::string contactTargets(const std::vector<ContactRow>& rows);

}  // namespace limber::bench

// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_row.h"

namespace limber::bench {

/// Returns all results as a table for human readers.
std::string summariseContact(const std::vector<ContactRow>& rows);

}  // namespace limber::bench

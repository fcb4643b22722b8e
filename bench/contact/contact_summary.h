// SPDX-License-Identifier: Zlib
#pragma once

#include "contact/contact_row.h"

namespace limber::bench {

/// All that was measured, as a table for people.
std::string summariseContact(const std::vector<ContactRow>& rows);

}  // namespace limber::bench

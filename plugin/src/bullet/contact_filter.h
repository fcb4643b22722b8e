// SPDX-License-Identifier: Zlib

// This header declares where the user's contact filter is asked. Only worlds with a filter call it.

#pragma once

#include "bullet/soft_body_data.h"
#include "bullet/tick_contacts.h"

#include <limber/contact_filter.h>

#include <vector>

namespace limber {
inline namespace LIMBER_BULLET_PRECISION {

inline bool isFiltered(const SoftBodyData& body) { return body.filter && *body.filter; }

/// Asks for the plane contacts of a body, and removes those that do not act. Those that are only reported go
/// to `found`.
void filterPlanes(SoftBodyData& body, TickContacts& found);

/// Asks for rows of plane contacts, found within a tick, and removes those that do not act.
void filterPlanes(const SoftBodyData& body, std::vector<PlaneContact>& rows,
                  std::vector<const btCollisionObject*>& partners);

/// Asks for the contacts of moving bodies, and removes those that do not act. Those that are only reported
/// stay in found.sensed. `newIndex` is scratch.
void filterPairs(TickContacts& found, std::vector<std::uint32_t>& newIndex);

/// Asks for contacts found within a tick, and removes those that do not act.
void filterPairs(std::vector<Contact>& contacts, std::vector<ContactSource>& sources);

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
